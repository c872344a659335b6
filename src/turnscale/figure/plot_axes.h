// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <Eigen/Core>

#include "turnscale/figure/figure.h"

namespace turnscale {

/// Room around a panel's axes for numbers, labels and the title, about pixels.
double AxisLeft(const PlotPanel& panel);
double AxisBottom(const PlotPanel& panel);
constexpr double kAxisTop = 30;
/// Width of a letter, about.
constexpr double kLetter = 6.6;

/// Where a panel's values stand on the page.
class PlotAxes {
 public:
  /// `corner` is the upper left one. Throws InternalError where the panel has neither data nor ranges.
  PlotAxes(const PlotPanel& panel, const Eigen::Vector2d& corner, const Eigen::Vector2d& size);

  Eigen::Vector2d At(const Eigen::Vector2d& value) const;
  bool Holds(const Eigen::Vector2d& value) const;
  Eigen::Vector2d corner() const { return corner_; }
  double width() const { return size_.x(); }
  double height() const { return size_.y(); }

  /// Background, to be drawn before the data, and what goes around them; the bar of a map is among the labels.
  std::string Grid(const PlotPanel& panel) const;
  std::string Labels(const PlotPanel& panel) const;

 private:
  std::string Bar(const std::string& unit) const;

  Eigen::Vector2d corner_;
  Eigen::Vector2d size_;
  PlotRange x_;
  PlotRange y_;
};

/// A text element with what XML reserves escaped. `style` is a class, `extra` more attributes.
std::string SvgText(double x, double y, const std::string& text, const std::string& style = "",
                    const std::string& extra = "");

}  // namespace turnscale
