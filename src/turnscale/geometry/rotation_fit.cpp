// SPDX-License-Identifier: MIT
#include "turnscale/geometry/rotation_fit.h"

#include <algorithm>

#include <Eigen/SVD>

namespace turnscale {
namespace {

constexpr int kReweightings = 20;
constexpr double kSmallestAngle = 1e-6;  // radians; bounds the weight of directions that agree already

}  // namespace

Eigen::Quaterniond FitRotation(const std::vector<Eigen::Vector3d>& first, const std::vector<Eigen::Vector3d>& second) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (int round = 0; round < kReweightings; ++round) {
    Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
    for (size_t i = 0; i < first.size(); ++i) {
      const Eigen::Vector3d a = first[i].normalized();
      const Eigen::Vector3d b = second[i].normalized();
      const double weight = round == 0 ? 1.0 : 1.0 / std::max(kSmallestAngle, (R * a - b).norm());
      correlation += weight * b * a.transpose();
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d signs = Eigen::Vector3d::Ones();
    signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0;
    R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  }
  return Eigen::Quaterniond(R).normalized();
}

}  // namespace turnscale
