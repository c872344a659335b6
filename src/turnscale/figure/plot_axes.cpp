// SPDX-License-Identifier: MIT
#include "turnscale/figure/plot_axes.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"

namespace turnscale {
namespace {

constexpr int kXTicks = 7;
constexpr int kYTicks = 6;
constexpr double kAir = 0.05;  // around the data, a share of their range

Eigen::AlignedBox2d Extent(const PlotPanel& panel) {
  Eigen::AlignedBox2d box;
  for (const PlotLine& line : panel.lines) {
    for (const Eigen::Vector2d& point : line.points)
      if (point.allFinite()) box.extend(point);
  }
  for (const PlotArea& area : panel.areas) {
    for (const Eigen::Vector2d& point : area.outline) box.extend(point);
  }
  for (const PlotBox& b : panel.boxes) {
    box.extend(Eigen::Vector2d(b.x - b.width, std::min(b.low, b.mean - b.sigma)));
    box.extend(Eigen::Vector2d(b.x + b.width, std::max(b.high, b.mean + b.sigma)));
  }
  return box;
}

PlotRange WithAir(double low, double high) {
  const double air = high > low ? kAir * (high - low) : std::max(1e-9, 0.1 * std::abs(low));
  return {low - air, high + air};
}

// Widens the shorter range until a unit is as long on both axes.
void Equalize(const Eigen::Vector2d& size, PlotRange& x, PlotRange& y) {
  const auto widen = [](PlotRange& range, double wanted) {
    const double more = 0.5 * (wanted - (range.high - range.low));
    range.low -= more;
    range.high += more;
  };
  const double per_pixel = std::max((x.high - x.low) / size.x(), (y.high - y.low) / size.y());
  widen(x, per_pixel * size.x());
  widen(y, per_pixel * size.y());
}

std::string Number(double value) { return fmt::format("{:.6g}", std::abs(value) < 1e-12 ? 0.0 : value); }

}  // namespace

double AxisBottom(const PlotPanel& panel) { return !panel.bar_unit.empty() ? 12 : panel.x_label.empty() ? 38 : 56; }

double AxisLeft(const PlotPanel& panel) {
  if (!panel.bar_unit.empty()) return 0;
  std::size_t longest = 0;
  for (const auto& [y, name] : panel.y_names) longest = std::max(longest, name.size());
  return std::max(66.0, 14 + kLetter * static_cast<double>(longest));
}

std::vector<double> Ticks(const PlotRange& range, int wanted) {
  const double span = range.high - range.low;
  if (!(span > 0) || wanted < 1) return {};
  const double least = span / wanted;
  const double decade = std::pow(10, std::floor(std::log10(least)));
  double step = 10 * decade;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * decade >= least) step = factor * decade;
  }
  std::vector<double> ticks;
  const double slack = 1e-9 * span;
  for (double k = std::ceil((range.low - slack) / step); k * step <= range.high + slack; ++k) ticks.push_back(k * step);
  return ticks;
}

std::string SvgText(double x, double y, const std::string& text, const std::string& style, const std::string& extra) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\"{}{}>{}</text>\n", x, y,
                     style.empty() ? "" : fmt::format(" class=\"{}\"", style), extra.empty() ? "" : " " + extra,
                     EscapedXml(text));
}

PlotAxes::PlotAxes(const PlotPanel& panel, const Eigen::Vector2d& corner, const Eigen::Vector2d& size)
    : corner_(corner), size_(size) {
  const Eigen::AlignedBox2d box = Extent(panel);
  Ensure(!box.isEmpty() || (panel.x && panel.y), "panel " + panel.title + ": nothing to draw");
  x_ = panel.x ? *panel.x : WithAir(box.min().x(), box.max().x());
  y_ = panel.y ? *panel.y : WithAir(box.min().y(), box.max().y());
  if (panel.equal_axes) Equalize(size_, x_, y_);
}

Eigen::Vector2d PlotAxes::At(const Eigen::Vector2d& value) const {
  return {corner_.x() + size_.x() * (value.x() - x_.low) / (x_.high - x_.low),
          corner_.y() + size_.y() * (y_.high - value.y()) / (y_.high - y_.low)};
}

bool PlotAxes::Holds(const Eigen::Vector2d& value) const {
  return value.x() >= x_.low && value.x() <= x_.high && value.y() >= y_.low && value.y() <= y_.high;
}

std::string PlotAxes::Grid(const PlotPanel& panel) const {
  if (!panel.bar_unit.empty()) return "";
  std::string path;
  if (panel.x_names.empty()) {
    for (const double x : Ticks(x_, kXTicks)) {
      path += fmt::format("M{:.1f},{:.1f}v{:.1f}", At({x, 0}).x(), corner_.y(), size_.y());
    }
  }
  for (const double y : panel.y_names.empty() ? Ticks(y_, kYTicks) : std::vector<double>()) {
    path += fmt::format("M{:.1f},{:.1f}h{:.1f}", corner_.x(), At({0, y}).y(), size_.x());
  }
  return path.empty() ? "" : fmt::format("<path class=\"grid\" d=\"{}\"/>\n", path);
}

std::string PlotAxes::Bar(const std::string& unit) const {
  // The round length nearest to a fifth of the width, from below.
  const double per_unit = size_.x() / (x_.high - x_.low);
  const double most = 0.2 * size_.x() / per_unit;
  const double decade = std::pow(10, std::floor(std::log10(most)));
  double length = decade;
  for (const double factor : {2.0, 5.0}) {
    if (factor * decade <= most) length = factor * decade;
  }
  const double bottom = corner_.y() + size_.y() - 4;
  return fmt::format("<path class=\"bar\" d=\"M{:.1f},{:.1f}v5h{:.1f}v-5\"/>\n", corner_.x() + 1, bottom - 5,
                     length * per_unit) +
         SvgText(corner_.x() + length * per_unit + 9, bottom + 4, Number(length) + " " + unit);
}

std::string PlotAxes::Labels(const PlotPanel& panel) const {
  if (!panel.bar_unit.empty()) return Bar(panel.bar_unit) + SvgText(corner_.x(), corner_.y() - 9, panel.title, "panel");
  const double bottom = corner_.y() + size_.y();
  std::string text = fmt::format("<path class=\"frame\" d=\"M{:.1f},{:.1f}h{:.1f}v{:.1f}h-{:.1f}Z\"/>\n", corner_.x(),
                                 corner_.y(), size_.x(), size_.y(), size_.x());
  constexpr auto kMiddle = "text-anchor=\"middle\"";
  if (panel.x_names.empty()) {
    for (const double x : Ticks(x_, kXTicks)) text += SvgText(At({x, 0}).x(), bottom + 17, Number(x), "", kMiddle);
  }
  for (const auto& [x, name] : panel.x_names) text += SvgText(At({x, 0}).x(), bottom + 17, name, "", kMiddle);
  for (const auto& [y, name] : panel.y_names)
    text += SvgText(corner_.x() - 7, At({0, y}).y() + 4.5, name, "", "text-anchor=\"end\"");
  for (const double y : panel.y_names.empty() ? Ticks(y_, kYTicks) : std::vector<double>()) {
    text += SvgText(corner_.x() - 7, At({0, y}).y() + 4.5, Number(y), "", "text-anchor=\"end\"");
  }
  const Eigen::Vector2d middle = corner_ + 0.5 * size_;
  text += SvgText(middle.x(), bottom + 37, panel.x_label, "", kMiddle);
  text += SvgText(0, 0, panel.y_label, "",
                  fmt::format("text-anchor=\"middle\" transform=\"translate({:.1f},{:.1f}) rotate(-90)\"",
                              corner_.x() - 48, middle.y()));
  return text + SvgText(corner_.x(), corner_.y() - 9, panel.title, "panel");
}

}  // namespace turnscale
