// SPDX-License-Identifier: MIT
#include "turnscale/geometry/similarity.h"

#include <string>

#include <Eigen/Eigenvalues>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

Eigen::Matrix3Xd Columns(const std::vector<Eigen::Vector3d>& points) {
  return Eigen::Map<const Eigen::Matrix3Xd>(points.front().data(), 3, static_cast<Eigen::Index>(points.size()));
}

void CheckSpread(const Eigen::Matrix3Xd& points, const std::string& name) {
  const Eigen::Matrix3Xd centred = points.colwise() - points.rowwise().mean();
  const Eigen::Vector3d variances =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(centred * centred.transpose()).eigenvalues();
  // Rounding leaves about 1e-16 of the variance across an exact line.
  if (!(variances[1] > 1e-14 * variances[2])) {
    throw InputError("cannot align: the " + name + " positions lie on one line or point");
  }
}

}  // namespace

Similarity AlignPoints(const std::vector<Eigen::Vector3d>& source, const std::vector<Eigen::Vector3d>& target,
                       AlignmentModel model) {
  Ensure(source.size() == target.size(), "positions to align are not as many on both sides");
  if (source.size() < 3) {
    throw InputError("cannot align: needs at least 3 positions, has " + std::to_string(source.size()));
  }
  const Eigen::Matrix3Xd source_columns = Columns(source);
  const Eigen::Matrix3Xd target_columns = Columns(target);
  CheckSpread(source_columns, "first");
  CheckSpread(target_columns, "second");
  const Eigen::Matrix4d matrix = Eigen::umeyama(source_columns, target_columns, model == AlignmentModel::kSimilarity);
  Similarity target_from_source;
  target_from_source.scale = matrix.topLeftCorner<3, 1>().norm();
  target_from_source.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>() / target_from_source.scale)).normalized();
  target_from_source.translation = matrix.topRightCorner<3, 1>();
  return target_from_source;
}

}  // namespace turnscale
