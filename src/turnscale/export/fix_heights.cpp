// SPDX-License-Identifier: MIT
#include "turnscale/export/fix_heights.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "turnscale/base/quantiles.h"
#include "turnscale/base/robust_weights.h"

namespace turnscale {
namespace {

constexpr double kUsualSlope = 0.03;  // of a whole drive, standard deviation
constexpr int kHeightIterations = 30;

}  // namespace

HeightPlacement PlaceHeights(const std::vector<HeightOfFix>& fixes) {
  // Rise to the right, rise ahead, height of the origin.
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  const auto residual = [&](const HeightOfFix& fix) {
    return fix.height - fix.path.z() - plane.dot(Eigen::Vector3d(fix.path.x(), fix.path.y(), 1));
  };
  std::vector<double> heights;
  for (const HeightOfFix& fix : fixes) heights.push_back(residual(fix));
  plane.z() = Median(heights);
  for (int i = 0; i < kHeightIterations; ++i) {
    std::vector<double> deviations;
    for (const HeightOfFix& fix : fixes) deviations.push_back(std::abs(residual(fix)) / fix.sigma);
    // Before the slope is found, it makes all deviations large.
    const double unit = std::max(1.0, kSigmaPerMad * Median(deviations));
    Eigen::Matrix3d normal = Eigen::Vector3d(1, 1, 0).asDiagonal() * std::pow(kUsualSlope, -2);
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const HeightOfFix& fix : fixes) {
      const double weight =
          TukeyWeight(residual(fix) / (unit * fix.sigma), kTukeyThreshold) / std::pow(unit * fix.sigma, 2);
      const Eigen::Vector3d row(fix.path.x(), fix.path.y(), 1);
      normal += weight * row * row.transpose();
      right += weight * (fix.height - fix.path.z()) * row;
    }
    plane = normal.ldlt().solve(right);
  }
  const Eigen::Vector3d up = Eigen::Vector3d(-plane.x(), -plane.y(), 1).normalized();
  return {plane.z(), Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up)};
}

}  // namespace turnscale
