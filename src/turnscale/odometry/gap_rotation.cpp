// SPDX-License-Identifier: MIT
#include "turnscale/odometry/gap_rotation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "turnscale/base/check_part.h"
#include "turnscale/base/random.h"
#include "turnscale/geometry/angle.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/essential_motion.h"
#include "turnscale/odometry/mount_calibration.h"

namespace turnscale {
namespace {

// Of the five-point algorithm.
constexpr int kFewestMatches = 5;
constexpr double kSigma = 0.5 / kDegreesPerRadian;

// Undistorted pixels of matches, and how exact they are.
struct Matches {
  std::vector<Eigen::Vector2d> first;
  std::vector<Eigen::Vector2d> second;
  double max_error = 0;  // pixels; of a distance to the epipolar line

  int count() const { return static_cast<int>(first.size()); }
  void Add(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    first.push_back(a);
    second.push_back(b);
  }
};

struct PixelOrder {
  bool operator()(const cv::Point2f& a, const cv::Point2f& b) const { return a.x != b.x ? a.x < b.x : a.y < b.y; }
};
using PixelSet = std::set<cv::Point2f, PixelOrder>;

// An image with what is known to be far away in it: keypoints that have moved since an earlier view as its rotation
// moves them.
struct GapView {
  DescribedKeypoints keypoints;
  PixelSet far;
};

PixelSet FarPixels(const GapRotationOptions& options, const CameraModel& camera, const DescribedKeypoints& earlier,
                   const DescribedKeypoints& now, const Eigen::Quaterniond& now_from_earlier) {
  const double reach = options.max_still_motion * std::max(earlier.scale, now.scale);
  PixelSet far;
  for (const KeypointMatch& match : MatchKeypoints(options.keypoints, earlier, now)) {
    if (cv::norm(match.second - match.first) <= 2 * reach) continue;
    const std::optional<Eigen::Vector2d> then = camera.Undistort({match.first.x, match.first.y});
    const std::optional<Eigen::Vector2d> seen = camera.Undistort({match.second.x, match.second.y});
    if (!then || !seen) continue;
    const Eigen::Vector3d expected = now_from_earlier * camera.pinhole.Ray(*then).normalized();
    if ((expected - camera.pinhole.Ray(*seen).normalized()).norm() * camera.pinhole.fx <= reach)
      far.insert(match.second);
  }
  return far;
}

// Of the scene, as far as is known, and those of them that are far away.
struct SceneMatches {
  Matches all;
  Matches far;
};

SceneMatches MatchedPixels(const GapRotationOptions& options, const CameraModel& camera, const GapView& first,
                           const DescribedKeypoints& second, bool car_stood) {
  const double scale = std::max(first.keypoints.scale, second.scale);
  SceneMatches matches;
  matches.all.max_error = matches.far.max_error = options.max_epipolar_error * scale;
  for (const KeypointMatch& match : MatchKeypoints(options.keypoints, first.keypoints, second)) {
    const bool stands_still = cv::norm(match.second - match.first) <= options.max_still_motion * scale;
    const bool is_far = first.far.contains(match.first);
    if (stands_still && !car_stood && !is_far) continue;
    const std::optional<Eigen::Vector2d> a = camera.Undistort({match.first.x, match.first.y});
    const std::optional<Eigen::Vector2d> b = camera.Undistort({match.second.x, match.second.y});
    if (!a || !b) continue;
    matches.all.Add(*a, *b);
    if (is_far) matches.far.Add(*a, *b);
  }
  return matches;
}

bool AreEnough(const GapRotationOptions& options, std::size_t agreeing, double share, const Matches& matches) {
  const auto count = static_cast<double>(agreeing);
  return count >= options.min_matches && count >= share * matches.count();
}

// The rotation that explains most matches without any way between the views, if there is one (RANSAC).
std::optional<Eigen::Quaterniond> RotationAlone(const GapRotationOptions& options, const Pinhole& pinhole,
                                                const Matches& matches) {
  constexpr int kSamples = 100;
  std::vector<Eigen::Vector3d> first;
  std::vector<Eigen::Vector3d> second;
  for (int i = 0; i < matches.count(); ++i) {
    first.push_back(pinhole.Ray(matches.first[i]).normalized());
    second.push_back(pinhole.Ray(matches.second[i]).normalized());
  }
  const double reach = 2 * matches.max_error / pinhole.fx;
  const auto agreeing = [&](const Eigen::Quaterniond& rotation) {
    std::vector<int> list;
    for (int i = 0; i < matches.count(); ++i)
      if ((rotation * first[i] - second[i]).norm() < reach) list.push_back(i);
    return list;
  };
  Random random(1);
  std::vector<int> best;
  for (int i = 0; i < kSamples; ++i) {
    const int a = random.Below(matches.count());
    const int b = random.Below(matches.count());
    if (a == b) continue;
    std::vector<int> list = agreeing(FitRotation({first[a], first[b]}, {second[a], second[b]}));
    if (list.size() > best.size()) best = std::move(list);
  }
  if (!AreEnough(options, best.size(), options.min_still_share, matches)) return std::nullopt;
  std::vector<Eigen::Vector3d> from;
  std::vector<Eigen::Vector3d> to;
  for (const int i : best) {
    from.push_back(first[i]);
    to.push_back(second[i]);
  }
  return FitRotation(from, to);
}

// What the rotation of the camera on the car may be off by, rad.
struct MountReach {
  double yaw = 0;
  double tilt = 0;
};

MountReach ReachOf(const Mount& mount) {
  constexpr double kAssumed = 3 / kDegreesPerRadian;
  if (!mount.found) return {2 * kAssumed, 2 * kAssumed};
  return {2 * mount.sigma.yaw, 2 * std::hypot(mount.sigma.pitch, mount.sigma.roll)};
}

// The angle by which the car has turned to the right, rad; empty if it is not about its vertical.
std::optional<double> TurnOfCar(const GapRotationOptions& options, const Eigen::Quaterniond& rotation,
                                const Mount& mount) {
  const Eigen::Vector3d turn = mount.vehicle_from_camera * VectorFromRotation(rotation);
  const double tilt = std::hypot(turn.x(), turn.z());
  if (InDegrees(tilt - ReachOf(mount).tilt * std::abs(turn.y())) > options.max_tilt_deg) return std::nullopt;
  return -turn.y();
}

// Whether a car can have moved like this.
bool IsMotionOfCar(const GapRotationOptions& options, const RigidTransform& second_from_first, const Mount& mount) {
  const std::optional<double> turn = TurnOfCar(options, second_from_first.rotation, mount);
  if (!turn) return false;
  const Eigen::Vector3d way = mount.vehicle_from_camera * second_from_first.inverse().translation;
  // To the right. It may be the opposite one: that of a car that reverses, or of things in a row, where each is taken
  // for the next.
  const double direction = std::atan2(way.z() < 0 ? -way.x() : way.x(), std::abs(way.z()));
  const double reach = options.max_direction_error_deg / kDegreesPerRadian + ReachOf(mount).yaw;
  return direction >= std::min(*turn, 0.0) - reach && direction <= std::max(*turn, 0.0) + reach;
}

// Of the second image from the first.
std::optional<Eigen::Quaterniond> RotationBetween(const GapRotationOptions& options, const CameraModel& camera,
                                                  const GapView& first, const DescribedKeypoints& second,
                                                  bool car_stood, const Mount& mount) {
  const Pinhole& pinhole = camera.pinhole;
  const auto [matches, far] = MatchedPixels(options, camera, first, second, car_stood);
  if (far.count() >= options.min_matches) {
    const auto rotation = RotationAlone(options, pinhole, far);
    if (rotation && TurnOfCar(options, *rotation, mount)) return rotation;
  }
  if (matches.count() < options.min_matches) return std::nullopt;
  if (const auto rotation = RotationAlone(options, pinhole, matches))
    return TurnOfCar(options, *rotation, mount) ? rotation : std::nullopt;
  const EssentialMotion motion = FindEssentialMotion(pinhole, matches.first, matches.second, matches.max_error);
  const auto agreeing = static_cast<std::size_t>(std::ranges::count(motion.inlier, 1));
  if (!AreEnough(options, agreeing, options.min_match_share, matches)) return std::nullopt;
  if (ShareOnPlane(motion, matches.first, matches.second, 2 * matches.max_error) > options.max_plane_share)
    return std::nullopt;
  const std::optional<TwoViewGeometry> adjusted = AdjustTwoViews(pinhole, motion, matches.first, matches.second);
  if (!adjusted || !IsMotionOfCar(options, adjusted->second_from_first, mount)) return std::nullopt;
  return adjusted->second_from_first.rotation;
}

}  // namespace

void GapRotationOptions::Check() const {
  CheckPart("", keypoints);
  Require(max_epipolar_error > 0, "max_epipolar_error: has to be positive");
  Require(max_still_motion > 2 * max_epipolar_error, "max_still_motion: has to be above twice max_epipolar_error");
  Require(min_matches >= kFewestMatches, "min_matches: has to be at least 5");
  Require(min_match_share >= 0 && min_match_share <= 1, "min_match_share: has to be in 0...1");
  Require(min_still_share >= 0 && min_still_share <= 1, "min_still_share: has to be in 0...1");
  Require(max_plane_share >= 0 && max_plane_share <= 1, "max_plane_share: has to be in 0...1");
  Require(max_tilt_deg > 0, "max_tilt_deg: has to be positive");
  Require(max_direction_error_deg > 0, "max_direction_error_deg: has to be positive");
}

std::optional<GapRotation> MeasureGapRotation(const GapRotationOptions& options, const CameraModel& camera,
                                              const GapImages& images, const cv::Mat& mask, const Mount& mount) {
  const auto describe = [&](const cv::Mat& gray) { return DescribeKeypoints(options.keypoints, gray, mask); };
  const DescribedKeypoints earlier = images.earlier.gray.empty() ? DescribedKeypoints{} : describe(images.earlier.gray);
  const auto view = [&](DescribedKeypoints keypoints, const Eigen::Quaterniond& now_from_earlier) {
    PixelSet far;
    if (!earlier.pixels.empty()) far = FarPixels(options, camera, earlier, keypoints, now_from_earlier);
    return GapView{std::move(keypoints), std::move(far)};
  };
  const auto between = [&](const GapView& first, const DescribedKeypoints& second) {
    return RotationBetween(options, camera, first, second, images.car_stood, mount);
  };
  const GapView before = view(describe(images.before), images.earlier.now_from_then);
  const DescribedKeypoints after = describe(images.after);
  if (const auto direct = between(before, after)) return GapRotation{*direct, kSigma};
  if (images.lost.empty()) return std::nullopt;
  DescribedKeypoints lost = describe(images.lost);
  const auto lost_from_before = between(before, lost);
  if (!lost_from_before) return std::nullopt;
  const auto after_from_lost = between(view(std::move(lost), *lost_from_before * images.earlier.now_from_then), after);
  if (!after_from_lost) return std::nullopt;
  return GapRotation{*after_from_lost * *lost_from_before, std::numbers::sqrt2 * kSigma};
}

}  // namespace turnscale
