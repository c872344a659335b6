// SPDX-License-Identifier: MIT
#include "turnscale/odometry/gap_rotation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "turnscale/base/check_part.h"
#include "turnscale/geometry/angle.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/essential_motion.h"

namespace turnscale {
namespace {

// Of the five-point algorithm.
constexpr int kFewestMatches = 5;

// Whether a car can have moved like this.
bool IsMotionOfCar(const GapRotationOptions& options, const RigidTransform& second_from_first,
                   const Eigen::Quaterniond& vehicle_from_camera) {
  const Eigen::Vector3d turn = vehicle_from_camera * VectorFromRotation(second_from_first.rotation);
  if (InDegrees(std::hypot(turn.x(), turn.z())) > options.max_tilt_deg) return false;
  const Eigen::Vector3d way = vehicle_from_camera * second_from_first.inverse().translation;
  // Both to the right. The direction may be the opposite one: that of a car that reverses, or of things in a row, where
  // each is taken for the next.
  const double direction = InDegrees(std::atan2(way.z() < 0 ? -way.x() : way.x(), std::abs(way.z())));
  const double heading = -InDegrees(turn.y());
  return direction >= std::min(heading, 0.0) - options.max_direction_error_deg &&
         direction <= std::max(heading, 0.0) + options.max_direction_error_deg;
}

// From the first image to the second.
std::optional<Eigen::Quaterniond> RotationBetween(const GapRotationOptions& options, const CameraModel& camera,
                                                  const cv::Mat& before, const cv::Mat& after, const cv::Mat& mask,
                                                  const Eigen::Quaterniond& vehicle_from_camera) {
  std::vector<Eigen::Vector2d> first;
  std::vector<Eigen::Vector2d> second;
  for (const KeypointMatch& match : MatchKeypoints(options.keypoints, before, after, mask)) {
    const std::optional<Eigen::Vector2d> a = camera.Undistort({match.first.x, match.first.y});
    const std::optional<Eigen::Vector2d> b = camera.Undistort({match.second.x, match.second.y});
    if (!a || !b) continue;
    first.push_back(*a);
    second.push_back(*b);
  }
  const Pinhole& pinhole = camera.pinhole;
  const auto count = static_cast<int>(first.size());
  if (count < options.min_matches) return std::nullopt;
  const EssentialMotion motion = FindEssentialMotion(pinhole, first, second, options.max_epipolar_error);
  const auto agreeing = static_cast<int>(std::ranges::count(motion.inlier, 1));
  if (agreeing < options.min_matches || agreeing < options.min_match_share * count) return std::nullopt;
  if (!IsMotionOfCar(options, motion.second_from_first, vehicle_from_camera)) return std::nullopt;
  const std::optional<TwoViewGeometry> adjusted = AdjustTwoViews(pinhole, motion, first, second);
  return (adjusted ? adjusted->second_from_first : motion.second_from_first).rotation;
}

}  // namespace

void GapRotationOptions::Check() const {
  CheckPart("", keypoints);
  Require(max_epipolar_error > 0, "max_epipolar_error: has to be positive");
  Require(min_matches >= kFewestMatches, "min_matches: has to be at least 5");
  Require(min_match_share >= 0 && min_match_share <= 1, "min_match_share: has to be in 0...1");
  Require(max_tilt_deg > 0, "max_tilt_deg: has to be positive");
  Require(max_direction_error_deg > 0, "max_direction_error_deg: has to be positive");
}

std::optional<Eigen::Quaterniond> RotationAcrossGap(const GapRotationOptions& options, const CameraModel& camera,
                                                    const GapImages& images, const cv::Mat& mask,
                                                    const Eigen::Quaterniond& vehicle_from_camera) {
  const auto between = [&](const cv::Mat& first, const cv::Mat& second) {
    return RotationBetween(options, camera, first, second, mask, vehicle_from_camera);
  };
  if (const auto direct = between(images.before, images.after)) return direct;
  if (images.lost.empty()) return std::nullopt;
  const auto lost_from_before = between(images.before, images.lost);
  const auto after_from_lost = lost_from_before ? between(images.lost, images.after) : std::nullopt;
  if (!after_from_lost) return std::nullopt;
  return *after_from_lost * *lost_from_before;
}

}  // namespace turnscale
