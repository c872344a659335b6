// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "turnscale/geometry/pinhole.h"
#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Motion between two views by matches, some of which may be wrong.
struct EssentialMotion {
  RigidTransform second_from_first;  ///< unit translation
  std::vector<char> agrees;          ///< one flag per match; empty: no motion
  std::vector<char> inlier;          ///< one flag per match: it agrees, and is near enough for a depth
};

/// Five-point essential matrix with RANSAC, and the one of its four motions that puts most points in front of both
/// cameras. `first`, `second`: undistorted pixels of the matches, of which there have to be five. A match agrees if it
/// is at most `max_error` pixels from its epipolar line.
EssentialMotion FindEssentialMotion(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& first,
                                    const std::vector<Eigen::Vector2d>& second, double max_error);

/// Share of the inliers of a motion that lie on one plane. If nearly all do, another motion may explain them as well
/// (Longuet-Higgins 1986, The reconstruction of a plane surface from two perspective projections).
double ShareOnPlane(const EssentialMotion& motion, const std::vector<Eigen::Vector2d>& first,
                    const std::vector<Eigen::Vector2d>& second, double max_error);

/// Whether the inliers of a motion may be the side of a vehicle that passes before a camera that stands: nearly all of
/// them lie on one plane, and one of the two motions that a plane allows is sideways (along the x axis of the vehicle).
/// `first`, `second`, `max_error`: as above, undistorted pixels. `vehicle_from_camera`: how the camera sits on the car.
bool MayBePassingVehicle(const Pinhole& pinhole, const EssentialMotion& motion,
                         const std::vector<Eigen::Vector2d>& first, const std::vector<Eigen::Vector2d>& second,
                         double max_error, const Eigen::Quaterniond& vehicle_from_camera);

/// Motion between two views and what they show, adjusted together.
struct TwoViewGeometry {
  RigidTransform second_from_first;  ///< in a unit of length of its own
  std::vector<std::size_t> match_of_point;
  std::vector<Eigen::Vector3d> points;  ///< in the first camera, in that unit
};

/// Triangulates the inliers of a motion, and adjusts points and motion to the undistorted pixels (two-view bundle
/// adjustment). Empty where that fails, or no point can be triangulated.
std::optional<TwoViewGeometry> AdjustTwoViews(const Pinhole& pinhole, const EssentialMotion& motion,
                                              const std::vector<Eigen::Vector2d>& first,
                                              const std::vector<Eigen::Vector2d>& second);

}  // namespace turnscale
