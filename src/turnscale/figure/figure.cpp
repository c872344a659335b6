// SPDX-License-Identifier: MIT
#include "turnscale/figure/figure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/figure/plot_axes.h"

namespace turnscale {
namespace {

// All lengths of the page in its own units, about pixels.
constexpr double kEdge = 20;
constexpr double kTitle = 36;
constexpr double kNote = 26;
constexpr double kLegendLine = 18;

constexpr auto kStyle =
    "text{font-family:Helvetica,Arial,sans-serif;font-size:13px;fill:#333}.title{font-size:17px;font-weight:bold}"
    ".panel{font-size:14px;font-weight:bold}.note{font-size:12px;fill:#666}path{fill:none;stroke-linejoin:round}"
    ".frame{stroke:#555;stroke-width:1}.grid{stroke:#e3e3e3;stroke-width:1}.bar{stroke:#333;stroke-width:2}";

std::string LineElement(const PlotLine& line, const PlotAxes& axes) {
  std::string path;
  bool drawing = false;
  for (const Eigen::Vector2d& point : line.points) {
    const Eigen::Vector2d at = axes.At(point);
    // M begins a piece; the points after it are joined to it.
    if (point.allFinite()) path += fmt::format("{}{:.1f},{:.1f} ", drawing ? "" : "M", at.x(), at.y());
    drawing = point.allFinite();
  }
  if (path.empty()) return "";
  path.pop_back();
  return fmt::format("<path stroke=\"{}\" stroke-width=\"{:g}\" stroke-dasharray=\"{}\"{} d=\"{}\"/>\n", line.color,
                     line.width, line.dash,
                     line.opacity < 1 ? fmt::format(" stroke-opacity=\"{:g}\"", line.opacity) : "", path);
}

std::string Marker(const PlotLine& line, const Eigen::Vector2d& at) {
  const double r = line.marker_size;
  if (line.marker == 'o') {
    return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:g}\" fill=\"{}\"/>\n", at.x(), at.y(), r, line.color);
  }
  const auto path =
      line.marker == 'x'
          ? fmt::format("M{0:.1f},{1:.1f}l{2:g},{2:g}m0,-{2:g}l-{2:g},{2:g}", at.x() - r, at.y() - r, 2 * r)
          : fmt::format("M{0:.1f},{1:.1f}h{2:g}v{2:g}h-{2:g}Z", at.x() - r, at.y() - r, 2 * r);
  return fmt::format("<path stroke=\"{}\" stroke-width=\"{:g}\" d=\"{}\"/>\n", line.color, line.width, path);
}

std::string Drawn(const PlotLine& line, const PlotAxes& axes) {
  if (line.marker == 0) return LineElement(line, axes);
  std::string text;
  for (const Eigen::Vector2d& point : line.points) {
    if (axes.Holds(point)) text += Marker(line, axes.At(point));
  }
  return text;
}

std::string Drawn(const PlotArea& area, const PlotAxes& axes) {
  if (area.outline.empty()) return "";
  std::string text = fmt::format("<path style=\"fill:{};fill-opacity:{:g}\"", area.color, area.opacity);
  if (area.edge > 0) text += fmt::format(" stroke=\"{}\" stroke-width=\"{:g}\"", area.color, area.edge);
  text += " d=\"M";
  for (const Eigen::Vector2d& point : area.outline) {
    const Eigen::Vector2d at = axes.At(point);
    text += fmt::format("{:.1f},{:.1f} ", at.x(), at.y());
  }
  text.back() = 'Z';
  return text + "\"/>\n";
}

std::string Drawn(const PlotBox& box, const PlotAxes& axes) {
  const auto at = [&](double x, double y) { return axes.At({x, y}); };
  const Eigen::Vector2d left = at(box.x - 0.5 * box.width, box.mean);
  const Eigen::Vector2d right = at(box.x + 0.5 * box.width, box.mean);
  const double top = at(box.x, box.mean + box.sigma).y();
  const double bottom = at(box.x, box.mean - box.sigma).y();
  return fmt::format(
      "<path stroke=\"#333\" stroke-width=\"1.4\" d=\"M{0:.1f},{1:.1f}V{2:.1f}\"/>"
      "<rect x=\"{3:.1f}\" y=\"{4:.1f}\" width=\"{5:.1f}\" height=\"{6:.1f}\" fill=\"{7}\" stroke=\"#333\"/>"
      "<path stroke=\"#111\" stroke-width=\"2\" d=\"M{3:.1f},{8:.1f}h{5:.1f}\"/>\n",
      at(box.x, 0).x(), at(box.x, box.low).y(), at(box.x, box.high).y(), left.x(), top, right.x() - left.x(),
      bottom - top, box.color, left.y());
}

// What the legend shows: a sample, centred at half height, and words.
struct LegendEntry {
  std::string label;
  std::string sample;
};

constexpr double kSample = 26;

std::vector<LegendEntry> LegendEntries(const PlotPanel& panel) {
  std::vector<LegendEntry> entries;
  const auto add = [&](const std::string& label, std::string sample) {
    if (label.empty()) return;
    const bool there = std::ranges::any_of(entries, [&](const LegendEntry& entry) { return entry.label == label; });
    if (!there) entries.push_back({label, std::move(sample)});
  };
  for (const PlotLine& line : panel.lines) {
    const auto stroke = fmt::format(
        "<path stroke=\"{}\" stroke-width=\"{:g}\" stroke-dasharray=\"{}\" stroke-opacity=\"{:g}\" d=\"M0,0h{:g}\"/>",
        line.color, line.width, line.dash, line.opacity, kSample - 4);
    add(line.label, line.marker == 0 ? stroke : Marker(line, {0.5 * kSample - 2, 0}));
  }
  for (const PlotBox& box : panel.boxes) {
    add(box.label,
        fmt::format("<rect x=\"4\" y=\"-6\" width=\"14\" height=\"12\" fill=\"{}\" stroke=\"#333\"/>", box.color));
  }
  for (const PlotArea& area : panel.areas) {
    add(area.label, fmt::format("<rect y=\"-6\" width=\"22\" height=\"12\" fill=\"{}\" fill-opacity=\"{:g}\"/>",
                                area.color, area.opacity));
  }
  return entries;
}

std::string Legend(const std::vector<LegendEntry>& entries, double x, double y) {
  std::string text;
  for (const LegendEntry& entry : entries) {
    text += fmt::format("<g transform=\"translate({:.1f},{:.1f})\">{}</g>", x, y, entry.sample);
    text += SvgText(x + kSample, y + 4.5, entry.label);
    y += kLegendLine;
  }
  return text;
}

double LegendWidth(const std::vector<LegendEntry>& entries) {
  std::size_t longest = 0;
  for (const LegendEntry& entry : entries) longest = std::max(longest, entry.label.size());
  return entries.empty() ? 0 : kSample + kLetter * static_cast<double>(longest) + 14;
}

// Everything of a panel but its legend, which stands to the right of the axes.
std::string PanelElement(const PlotPanel& panel, const PlotAxes& axes, std::size_t number) {
  const Eigen::Vector2d corner = axes.corner();
  std::string text = fmt::format(
      "<clipPath id=\"c{}\"><rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/></clipPath>\n", number,
      corner.x(), corner.y(), axes.width(), axes.height());
  text += axes.Grid(panel);
  text += fmt::format("<g clip-path=\"url(#c{})\">\n", number);
  for (const PlotArea& area : panel.areas) text += Drawn(area, axes);
  for (const PlotBox& box : panel.boxes) text += Drawn(box, axes);
  for (const PlotLine& line : panel.lines) text += Drawn(line, axes);
  return text + "</g>\n" + axes.Labels(panel);
}

}  // namespace

std::string ScaleColor(double share) {
  constexpr std::array<std::array<double, 3>, 4> kStops = {
      {{0x1b, 0x2a, 0x6b}, {0x1b, 0x7f, 0xa8}, {0x5c, 0xb8, 0x5c}, {0xe8, 0xb9, 0x22}}};
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(kStops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(place), kStops.size() - 2);
  std::string color = "#";
  for (std::size_t c = 0; c < 3; ++c) {
    color +=
        fmt::format("{:02x}", std::lround(std::lerp(kStops[i][c], kStops[i + 1][c], place - static_cast<double>(i))));
  }
  return color;
}

std::string FigureSvg(const Figure& figure) {
  Ensure(!figure.panels.empty(), "a figure without panels");
  const int columns = std::clamp(figure.columns, 1, static_cast<int>(figure.panels.size()));
  // Each column is as wide as its widest legend asks for.
  std::vector<std::vector<LegendEntry>> legends;
  std::vector<double> column_left(columns + 1, kEdge);
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const PlotPanel& panel = figure.panels[i];
    legends.push_back(panel.legend ? LegendEntries(panel) : std::vector<LegendEntry>());
    double& next = column_left[i % columns + 1];
    next = std::max(next, AxisLeft(panel) + figure.panel_width + 14 + LegendWidth(legends.back()));
  }
  for (int c = 1; c <= columns; ++c) column_left[c] += column_left[c - 1];
  const int rows = (static_cast<int>(figure.panels.size()) + columns - 1) / columns;
  const auto height_of = [&](const PlotPanel& panel) { return panel.height > 0 ? panel.height : figure.panel_height; };
  std::vector<double> row_top(rows + 1, kTitle);
  for (int row = 0; row < rows; ++row) {
    double height = 0;
    const std::size_t end = std::min<std::size_t>((row + 1) * columns, figure.panels.size());
    for (std::size_t i = static_cast<std::size_t>(row) * columns; i < end; ++i)
      height = std::max(height, kAxisTop + height_of(figure.panels[i]) + AxisBottom(figure.panels[i]));
    row_top[row + 1] = row_top[row] + height;
  }
  const double width = column_left[columns] + kEdge;
  const double height = row_top[rows] + (figure.note.empty() ? kEdge : kNote + kEdge);
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\">\n<style>{2}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      width, height, kStyle);
  text += SvgText(kEdge, 28, figure.title, "title");
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const PlotPanel& panel = figure.panels[i];
    const Eigen::Vector2d corner(column_left[i % columns] + AxisLeft(panel), row_top[i / columns] + kAxisTop);
    const PlotAxes axes(panel, corner, {figure.panel_width, height_of(panel)});
    text += PanelElement(panel, axes, i);
    text += Legend(legends[i], corner.x() + figure.panel_width + 14, corner.y() + 10);
  }
  if (!figure.note.empty()) text += SvgText(kEdge, height - kEdge, figure.note, "note");
  return text + "</svg>\n";
}

}  // namespace turnscale
