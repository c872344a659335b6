// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace turnscale {

/// Top view of a drive: positions as (to the right, ahead) on the page, metres.
struct PathPicture {
  std::string title;
  std::vector<std::vector<Eigen::Vector2d>> outlines;  ///< of what stands there, closed; may be empty
  std::vector<Eigen::Vector2d> truth;
  std::vector<Eigen::Vector2d> estimate;
};

/// The top view as SVG, with a legend and a scale bar; ahead is up. Throws InputError where there is no place at
/// all, or one is not finite.
std::string PathSvg(const PathPicture& picture);

}  // namespace turnscale
