// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/path_picture.h"

#include <algorithm>

#include <Eigen/Geometry>

#include "turnscale/base/error.h"
#include "turnscale/figure/figure.h"

namespace turnscale {
namespace {

// About pixels.
constexpr double kSide = 800;  // of the longer side of what is drawn
constexpr double kLeast = 240;

Eigen::AlignedBox2d Extent(const PathPicture& picture) {
  Eigen::AlignedBox2d box;
  const auto extend = [&](const std::vector<Eigen::Vector2d>& places) {
    for (const Eigen::Vector2d& place : places) {
      if (!place.allFinite()) throw InputError("the top view: a position is not finite");
      box.extend(place);
    }
  };
  extend(picture.truth);
  extend(picture.estimate);
  for (const auto& outline : picture.outlines) extend(outline);
  if (box.isEmpty()) throw InputError("the top view: nothing to draw");
  return box;
}

}  // namespace

std::string PathSvg(const PathPicture& picture) {
  const Eigen::AlignedBox2d box = Extent(picture);
  const Eigen::Vector2d size = box.sizes().cwiseMax(1.0);
  const double scale = kSide / size.maxCoeff();
  PlotPanel panel;
  panel.bar_unit = "m";
  panel.equal_axes = true;
  panel.x = PlotRange{box.center().x() - 0.53 * size.x(), box.center().x() + 0.53 * size.x()};
  panel.y = PlotRange{box.center().y() - 0.53 * size.y(), box.center().y() + 0.53 * size.y()};
  // An outline within another one is darker.
  for (const auto& outline : picture.outlines) panel.areas.push_back({outline, "", "#9aa0a8", 0.3, 1});
  panel.lines.push_back({picture.truth, "true", "#222", 5, "none", 0, 3, 0.35});
  panel.lines.push_back({picture.estimate, "estimated", "#c2185b", 1.8});
  Figure figure;
  figure.title = picture.title;
  figure.panel_width = std::max(scale * size.x(), kLeast);
  figure.panel_height = std::max(scale * size.y(), kLeast);
  figure.panels = {panel};
  return FigureSvg(figure);
}

}  // namespace turnscale
