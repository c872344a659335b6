// SPDX-License-Identifier: MIT
#include "turnscale/geometry/rotation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/SVD>

namespace turnscale {
namespace {

constexpr int kReweightings = 20;
constexpr double kSmallestAngle = 1e-6;  // radians; bounds the weight of directions that agree already

}  // namespace

Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Quaterniond RotationFromVector(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  const double half = 0.5 * angle;
  // sin(half)/angle by its series where the quotient loses digits.
  const double factor = angle < 1e-6 ? 0.5 - angle * angle / 48.0 : std::sin(half) / angle;
  return Eigen::Quaterniond(std::cos(half), factor * v.x(), factor * v.y(), factor * v.z()).normalized();
}

Eigen::Vector3d VectorFromRotation(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0 ? -1.0 : 1.0;
  const double w = sign * rotation.w();
  const Eigen::Vector3d v = sign * rotation.vec();
  const double sine = v.norm();
  const double factor = sine < 1e-9 ? 2.0 / w : 2.0 * std::atan2(sine, w) / sine;
  return factor * v;
}

double RotationAngle(const Eigen::Quaterniond& rotation) {
  return 2.0 * std::atan2(rotation.vec().norm(), std::abs(rotation.w()));
}

double TwistAboutY(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0 ? -1.0 : 1.0;
  return 2.0 * std::atan2(sign * rotation.y(), sign * rotation.w());
}

Eigen::Quaterniond RotationFromYawPitchRoll(const YawPitchRoll& angles) {
  return Eigen::AngleAxisd(angles.yaw, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(angles.pitch, Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(angles.roll, Eigen::Vector3d::UnitZ());
}

YawPitchRoll YawPitchRollFromRotation(const Eigen::Quaterniond& rotation) {
  // R_y(yaw) R_x(pitch) R_z(roll): the third column is the viewing axis, the second row holds the roll.
  const Eigen::Matrix3d R = rotation.toRotationMatrix();
  YawPitchRoll angles;
  angles.yaw = std::atan2(R(0, 2), R(2, 2));
  angles.pitch = std::asin(std::clamp(-R(1, 2), -1.0, 1.0));
  angles.roll = std::atan2(R(1, 0), R(1, 1));
  return angles;
}

Eigen::Quaterniond FitRotation(const std::vector<Eigen::Vector3d>& first, const std::vector<Eigen::Vector3d>& second) {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> directions;
  directions.reserve(first.size());
  for (size_t i = 0; i < first.size(); ++i) directions.emplace_back(first[i].normalized(), second[i].normalized());
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (int round = 0; round < kReweightings; ++round) {
    Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
    for (const auto& [a, b] : directions) {
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
