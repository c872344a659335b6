// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

namespace turnscale {

/// A point of a road's middle, or of the way that is driven, with the ground's height there.
struct RoadPoint {
  Eigen::Vector2d place;  ///< (x, z), metres
  double up = 0;          ///< metres
};

/// How far it is to the nearest road, and how high the ground lies, on a grid around the roads.
class RoadMap {
 public:
  /// `roads`: middles of all roads; `driven`: the way of the car itself. Points at most 2 m apart. Reaches `margin`
  /// metres beyond them.
  RoadMap(const std::vector<std::vector<RoadPoint>>& roads, const std::vector<RoadPoint>& driven, double margin);

  /// To the middle of the nearest road, metres; `kFar` where none is near.
  double ToRoad(const Eigen::Vector2d& place) const { return Interpolated(to_road_, place); }
  /// To the nearest point of the car's way, metres; `kFar` where none is near.
  double ToDriven(const Eigen::Vector2d& place) const { return Interpolated(to_driven_, place); }
  /// Ground without kerbs and crowns, metres.
  double Up(const Eigen::Vector2d& place) const { return Interpolated(up_, place); }

  const Eigen::Vector2d& low() const { return low_; }  ///< south-western corner
  Eigen::Vector2d high() const;                        ///< north-eastern corner
  static constexpr double kCell = 1;                   ///< metres
  static constexpr double kFar = 45;                   ///< metres

 private:
  using Grid = std::vector<double>;

  double Interpolated(const Grid& grid, const Eigen::Vector2d& place) const;
  void Nearest(const std::vector<RoadPoint>& points, Grid& distance) const;
  void Heights(const std::vector<std::vector<RoadPoint>>& roads);

  Eigen::Vector2d low_;
  int columns_ = 0;
  int rows_ = 0;
  Grid to_road_;
  Grid to_driven_;
  Grid up_;
};

}  // namespace turnscale
