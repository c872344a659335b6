// SPDX-License-Identifier: MIT
#include "turnscale/road/road_plane.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <opencv2/core/utility.hpp>

#include "turnscale/base/check_part.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/base/robust_weights.h"

namespace turnscale {
namespace {

// Coarse to fine: the half-size image first. So many are enough from a start that is 15 % off; each matches all patches
// once more.
constexpr int kIterationsHalf = 3;
constexpr int kIterationsFull = 3;
// Of one iteration, without matching; the next iteration goes on from the surface that they lead to.
constexpr int kReweightings = 4;
// In spreads of the residuals: of normal ones, 91 % of the information is kept. With a larger one, what is beside the
// road, or moves, has more weight.
constexpr double kTukey = 4.0;
// Weight of a patch that counts as an inlier: within 2.8 spreads.
constexpr double kInlierWeight = 0.25;
// Below this correlation the alignment of a patch need not lead towards the match. It is less than an inlier's, as
// patches do not lie on each other yet: where the start is 15 % off, the nearest are 3 pixels apart in KITTI's images.
constexpr double kLeastCorrelation = 0.3;
// From one height of the search to the next: well within the 15 % from which a fit finds the road.
constexpr double kSearchRatio = 1.06;
// Factor on sigma: neighbouring patches share errors of the motion between the images. A larger one gives heights less
// weight beside the turns; what many heights have in common is RoadEvidenceOptions::sigma.
constexpr double kCorrelatedErrors = 1.5;
// Logarithm of a height over that which the search starts with, 25 %: beyond it the fit is rejected. More than the 15 %
// from which it finds the road.
constexpr double kMostChange = 0.223;

// What the plane is expected to satisfy: row * plane = 0 +- sigma * down * plane. The vertical curvature is 0 +- its
// sigma.
struct Expectation {
  Eigen::Matrix3d level_from_camera;
  double pitch_sigma;
  double roll_sigma;
  double vertical_curvature_sigma;
};

struct Sample {
  Eigen::Vector3d ray;
  Eigen::Vector4d by_surface;  // change of its inverse depth by the plane's three numbers and the vertical curvature
  PatchMatch match;
  double variance;  // of its inverse depth about the surface
};

// Of the plane's three numbers and the vertical curvature.
struct Fit {
  Eigen::Vector4d change = Eigen::Vector4d::Zero();
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  double spread = 1;  // of the residuals, standard deviations
  std::vector<double> weights;
};

// MatchPatch for many patches, on as many threads as OpenCV is set to use.
std::vector<std::optional<PatchMatch>> MatchEach(const RoadPatchOptions& options, const RoadPair& pair,
                                                 const std::vector<RoadPatch>& patches, const RoadSurface& surface,
                                                 int size) {
  std::vector<std::optional<PatchMatch>> matches(patches.size());
  cv::parallel_for_(cv::Range(0, static_cast<int>(patches.size())), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) matches[i] = MatchPatch(options, pair, patches[i], surface, size);
  });
  return matches;
}

std::vector<Sample> MatchAll(const RoadPlaneOptions& options, const RoadPair& pair,
                             const std::vector<RoadPatch>& patches, const RoadSurface& surface, int size) {
  const std::vector<std::optional<PatchMatch>> matches = MatchEach(options.patches, pair, patches, surface, size);
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (!matches[i]) continue;
    const Eigen::Vector3d& ray = patches[i].ray;
    const double unevenness = options.unevenness * surface.InverseDepth(ray);
    samples.push_back({ray, surface.ByParameters(ray), *matches[i], matches[i]->variance + unevenness * unevenness});
  }
  return samples;
}

Fit ChangeOfSurface(const std::vector<Sample>& samples, const RoadSurface& surface, const Expectation& expected,
                    double min_correlation) {
  Fit fit;
  const double down = expected.level_from_camera.row(1).dot(surface.plane);
  for (int round = 0; round < kReweightings; ++round) {
    std::vector<double> residuals;
    for (const Sample& sample : samples)
      residuals.push_back((sample.match.inverse_depth_change - sample.by_surface.dot(fit.change)) /
                          std::sqrt(sample.variance));
    std::vector<double> deciding;
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (samples[i].match.correlation >= min_correlation) deciding.push_back(residuals[i]);
    fit.spread = std::max(1.0, RobustSigma(deciding));
    fit.information.setZero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    fit.weights.assign(samples.size(), 0);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (samples[i].match.correlation < min_correlation) continue;
      fit.weights[i] = TukeyWeight(residuals[i], kTukey * fit.spread);
      const double weight = fit.weights[i] / (samples[i].variance * fit.spread * fit.spread);
      const Eigen::Vector4d& by_surface = samples[i].by_surface;
      fit.information += weight * by_surface * by_surface.transpose();
      right += weight * samples[i].match.inverse_depth_change * by_surface;
    }
    const auto expect = [&](int axis, double sigma) {
      const Eigen::Vector3d row = expected.level_from_camera.row(axis);
      const double weight = 1 / (sigma * sigma * down * down);
      fit.information.topLeftCorner<3, 3>() += weight * row * row.transpose();
      right.head<3>() -= weight * row.dot(surface.plane) * row;
    };
    expect(2, expected.pitch_sigma);
    expect(0, expected.roll_sigma);
    const double curvature_weight = 1 / (expected.vertical_curvature_sigma * expected.vertical_curvature_sigma);
    fit.information(3, 3) += curvature_weight;
    right[3] -= curvature_weight * surface.vertical_curvature;
    fit.change = fit.information.ldlt().solve(right);
  }
  return fit;
}

RoadSurface LevelSurface(const RoadRegion& region, double height) {
  return {region.level_from_camera.row(1).transpose() / height, 0};
}

// The change may turn the plane, or change its distance, by a third at most: a start that is 15 % off needs less, and
// misleading patches do not lead far away.
void Move(const Eigen::Vector4d& change, RoadSurface& surface) {
  constexpr double kMost = 0.33;
  const double share = std::min(kMost * surface.plane.norm() / std::max(change.head<3>().norm(), 1e-12), 1.0);
  surface.plane += share * change.head<3>();
  surface.vertical_curvature += share * change[3];
}

// Changes of the fit's result by a small rotation and translation that follow `earlier_from_current`.
Eigen::Matrix<double, 4, 6> ChangeByMotion(const RoadPair& pair, const std::vector<Sample>& samples, const Fit& fit,
                                           const RoadSurface& surface, const Expectation& expected) {
  Eigen::Matrix<double, 4, 6> right = Eigen::Matrix<double, 4, 6>::Zero();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (fit.weights[i] == 0) continue;
    const auto by_motion = InverseDepthChangeByMotion(pair, samples[i].ray, surface);
    if (!by_motion) continue;
    const double weight = fit.weights[i] / (samples[i].variance * fit.spread * fit.spread);
    right += weight * samples[i].by_surface * *by_motion;
  }
  // The direction of travel in the axes of the current camera is the inverse rotation of the translation's.
  const RigidTransform& motion = pair.earlier_from_current;
  const double length = motion.translation.norm();
  const Eigen::RowVector3d plane = (motion.rotation * surface.plane).transpose();
  Eigen::Matrix<double, 1, 6> pitch;
  pitch << plane.cross(motion.translation.transpose() / length), plane / length;
  pitch.tail<3>() -= pitch.tail<3>().dot(motion.translation) / (length * length) * motion.translation.transpose();
  const Eigen::Vector3d forward = expected.level_from_camera.row(2);
  const double down = expected.level_from_camera.row(1).dot(surface.plane);
  const double weight = 1 / (expected.pitch_sigma * expected.pitch_sigma * down * down);
  right.topRows<3>() -= weight * forward * pitch;
  return fit.information.ldlt().solve(right);
}

double SumOfCorrelations(const RoadPlaneOptions& options, const RoadPair& pair, const std::vector<RoadPatch>& patches,
                         const RoadSurface& surface, int size) {
  double sum = 0;
  for (const std::optional<PatchMatch>& match : MatchEach(options.patches, pair, patches, surface, size))
    if (match) sum += std::max(match->correlation, 0.0);
  return sum;
}

}  // namespace

void RoadPlaneOptions::Check() const {
  patches.Check();
  Require(pitch_sigma > 0 && pitch_sigma < 1, "pitch_sigma_deg: has to be above 0 and below 57.3");
  Require(roll_sigma > 0 && roll_sigma < 1, "roll_sigma_deg: has to be above 0 and below 57.3");
  Require(vertical_curvature_sigma > 0, "vertical_curvature_sigma: has to be positive");
  Require(unevenness >= 0, "unevenness: must not be negative");
  Require(max_deviation > 0, "max_deviation: has to be positive");
  Require(min_correlation > 0 && min_correlation < 1, "min_correlation: has to be above 0 and below 1");
  Require(min_patches >= 6, "min_patches: has to be at least 6");
  Require(min_share > 0 && min_share <= 1, "min_share: has to be above 0, at most 1");
  Require(max_sigma > 0, "max_sigma: has to be positive");
}

std::optional<RoadPlane> FitRoadPlane(const RoadPlaneOptions& options, const RoadPair& pair, const RoadRegion& region,
                                      double height) {
  const Expectation expected = {region.level_from_camera, options.pitch_sigma, options.roll_sigma,
                                options.vertical_curvature_sigma};
  RoadSurface surface = LevelSurface(region, height);
  std::vector<RoadPatch> patches;
  std::vector<Sample> samples;
  Fit fit;
  for (int size = 1; size >= 0; --size) {
    patches = SelectRoadPatches(options.patches, pair, region, size);
    if (static_cast<int>(patches.size()) < options.min_patches) {
      if (size == 1) continue;
      return std::nullopt;
    }
    const int iterations = size == 1 ? kIterationsHalf : kIterationsFull;
    for (int i = 0; i < iterations; ++i) {
      samples = MatchAll(options, pair, patches, surface, size);
      fit = ChangeOfSurface(samples, surface, expected, kLeastCorrelation);
      if (!fit.change.allFinite()) return std::nullopt;
      Move(fit.change, surface);
    }
  }
  samples = MatchAll(options, pair, patches, surface, 0);
  fit = ChangeOfSurface(samples, surface, expected, options.min_correlation);
  RoadPlane road;
  for (const double weight : fit.weights) road.patches += weight > kInlierWeight ? 1 : 0;
  if (samples.empty()) return std::nullopt;
  road.share = static_cast<double>(road.patches) / static_cast<double>(samples.size());
  if (road.patches < options.min_patches || road.share < options.min_share) return std::nullopt;
  const Eigen::Matrix<double, 4, 6> by_motion = ChangeByMotion(pair, samples, fit, surface, expected);
  Move(fit.change, surface);
  const double norm = surface.plane.norm();
  if (!(norm > 0) || !std::isfinite(norm)) return std::nullopt;
  const Eigen::Vector3d level = region.level_from_camera * surface.plane / norm;
  if (std::abs(level.z()) > options.max_deviation * options.pitch_sigma * level.y() ||
      std::abs(level.x()) > options.max_deviation * options.roll_sigma * level.y())
    return std::nullopt;
  road.height = 1 / norm;
  road.normal = surface.plane / norm;
  const Eigen::RowVector3d by_surface = -surface.plane.transpose() / (norm * norm);
  road.by_rotation = by_surface * by_motion.topLeftCorner<3, 3>();
  road.by_direction = by_surface * by_motion.topRightCorner<3, 3>() * pair.earlier_from_current.translation.norm();
  Eigen::Vector4d by_plane;
  by_plane << surface.plane / (norm * norm), 0;
  road.sigma = kCorrelatedErrors * std::sqrt(by_plane.dot(fit.information.ldlt().solve(by_plane)));
  if (!(road.sigma <= options.max_sigma) || std::abs(std::log(road.height / height)) > kMostChange) return std::nullopt;
  return road;
}

std::optional<RoadPlane> FindRoadPlane(const RoadPlaneOptions& options, const RoadPair& pair, const RoadRegion& region,
                                       double least_height, double greatest_height) {
  const std::vector<RoadPatch> patches = SelectRoadPatches(options.patches, pair, region, 1);
  double best_height = 0;
  double best = 0;
  for (double height = least_height; height <= greatest_height; height *= kSearchRatio) {
    const double sum = SumOfCorrelations(options, pair, patches, LevelSurface(region, height), 1);
    if (sum <= best) continue;
    best = sum;
    best_height = height;
  }
  return best_height > 0 ? FitRoadPlane(options, pair, region, best_height) : std::nullopt;
}

}  // namespace turnscale
