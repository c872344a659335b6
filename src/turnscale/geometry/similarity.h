// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace turnscale {

/// Scale, rotation and translation between two frames, named `target_from_source`:
/// `x_in_target = scale * rotation * x_in_source + translation`.
struct Similarity {
  double scale = 1;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

inline Eigen::Vector3d operator*(const Similarity& target_from_source, const Eigen::Vector3d& x_in_source) {
  return target_from_source.scale * (target_from_source.rotation * x_in_source) + target_from_source.translation;
}

/// What may change when one set of points is laid over another.
enum class AlignmentModel {
  kRigid,       ///< SE(3): rotation and translation
  kSimilarity,  ///< Sim(3): scale as well
};

/// `target_from_source` that brings the source points nearest to the target points in the sense of least squares
/// (Umeyama 1991). The two sets correspond by index.
/// Throws InputError when the sets hold fewer than three points, or when one of them lies on a line, as the rotation
/// about that line then is anybody's guess; InternalError when they differ in size.
Similarity AlignPoints(const std::vector<Eigen::Vector3d>& source, const std::vector<Eigen::Vector3d>& target,
                       AlignmentModel model);

}  // namespace turnscale
