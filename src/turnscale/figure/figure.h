// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace turnscale {

using PlotPoints = std::vector<Eigen::Vector2d>;

/// A curve, broken where a value is not finite, or markers where `marker` is set.
struct PlotLine {
  PlotPoints points;
  std::string label;           ///< in the legend; empty: not there
  std::string color = "#222";  ///< as SVG has it
  double width = 2;            ///< of the stroke, about pixels
  std::string dash = "none";   ///< SVG's stroke-dasharray
  char marker = 0;             ///< 'o' dots, 'x' crosses, 's' open squares, 0 a line
  double marker_size = 3;
  double opacity = 1;
};

/// A filled outline.
struct PlotArea {
  PlotPoints outline;
  std::string label;
  std::string color = "#1565c0";
  double opacity = 0.2;
  double edge = 0;  ///< width of the outline's stroke
};

/// A box of one sigma about a mean, with whiskers to the extremes.
struct PlotBox {
  double x = 0;
  double width = 0.6;  ///< in units of x
  double mean = 0;
  double sigma = 0;
  double low = 0;
  double high = 0;
  std::string label;
  std::string color = "#42a5f5";
};

struct PlotRange {
  double low = 0;
  double high = 1;
};

/// One pair of axes and what is drawn in it. Values beyond the axes are cut off.
struct PlotPanel {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::optional<PlotRange> x;  ///< unset: what the data need
  std::optional<PlotRange> y;
  std::vector<std::pair<double, std::string>> x_names;  ///< instead of numbers at the x axis
  std::vector<std::pair<double, std::string>> y_names;  ///< the same at the y axis
  bool equal_axes = false;                              ///< a unit is as long on both
  /// A map: no axes but a bar of a round length in this unit, at the lower left.
  std::string bar_unit;
  double height = 0;  ///< of the axes; 0: that of the figure's panels
  bool legend = true;
  std::vector<PlotArea> areas;
  std::vector<PlotBox> boxes;
  std::vector<PlotLine> lines;
};

/// Panels side by side, row by row.
struct Figure {
  std::string title;
  std::string note;  ///< under the panels
  int columns = 1;
  double panel_width = 420;  ///< of the axes, about pixels
  double panel_height = 300;
  std::vector<PlotPanel> panels;
};

/// The figure as SVG. Throws InternalError where it has no panel, or a panel neither data nor ranges.
std::string FigureSvg(const Figure& figure);

/// A colour of the scale from blue over green to yellow, for a share in [0, 1].
std::string ScaleColor(double share);

/// Round numbers within a range, about `wanted` of them.
std::vector<double> Ticks(const PlotRange& range, int wanted);

}  // namespace turnscale
