// SPDX-License-Identifier: MIT
#include "turnscale/odometry/map_initializer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turnscale/base/quantiles.h"
#include "turnscale/features/corners.h"
#include "turnscale/mapping/essential_motion.h"
#include "turnscale/mapping/left_out.h"

namespace turnscale {
namespace {

// Below this share of its features, without those that no other image shows, a first view has gone out of sight.
constexpr double kFewestFeatures = 0.4;
// A car that waits longer than this, seconds, gets a new first view: light and shadows change, and memory grows.
constexpr double kMostSeconds = 30;
// Share of the features that have to move for static features to be separated from the scene.
constexpr double kLeastMovingShare = 0.2;
// Fewer features that stand still do no harm.
constexpr int kFewestStatic = 10;
// What stands still belongs to the scene if the camera's motion, whose rotation is estimated, moves it by no more than
// this, in the motion that counts as none.
constexpr double kMostMotionShare = 1.5;
// Least share of a car's motion straight ahead or back: within 60 degrees of it. A lorry that passes before a car that
// waits moves sideways.
constexpr double kLeastAhead = 0.5;

bool IsOfCar(const RigidTransform& second_from_first, const Eigen::Quaterniond& vehicle_from_camera) {
  const Eigen::Vector3d travel = vehicle_from_camera * second_from_first.inverse().translation;
  return std::abs(travel.z()) >= kLeastAhead * travel.norm();
}

// Takes features of the second view out of all views but the first.
void LeaveOut(const std::vector<char>& left_out, InitialMap& map) {
  const std::vector<int> seen = map.frames.back().features;
  std::vector<char> is_left_out(map.has_point.size(), 0);
  std::vector<cv::Point2f> kept;
  for (size_t i = 0; i < seen.size(); ++i) {
    is_left_out[seen[i]] = left_out[i];
    map.motion.push_back({map.second_pixels[i], left_out[i] != 0});
    if (left_out[i] == 0) kept.push_back(map.second_pixels[i]);
  }
  map.second_pixels = std::move(kept);
  for (size_t k = 1; k < map.frames.size(); ++k) {
    WaitingFrame& frame = map.frames[k];
    size_t next = 0;
    for (size_t i = 0; i < frame.features.size(); ++i) {
      if (is_left_out[frame.features[i]] != 0) continue;
      frame.features[next] = frame.features[i];
      frame.undistorted[next++] = frame.undistorted[i];
    }
    frame.features.resize(next);
    frame.undistorted.resize(next);
  }
}

}  // namespace

std::optional<InitialMap> MapInitializer::Add(const FlowImage& image, const cv::Mat& mask, int frame, double time) {
  if (frames_.empty() || !Follow(image, mask, frame, time)) {
    Start(image, mask, frame, time);
    return std::nullopt;
  }
  return TryTwoViews();
}

void MapInitializer::Start(const FlowImage& image, const cv::Mat& mask, int frame, double time) {
  frames_.clear();
  alive_.clear();
  pixels_.clear();
  WaitingFrame first{.frame = frame, .time = time, .features = {}, .undistorted = {}};
  const std::vector<cv::KeyPoint> candidates = FindCandidates(options_.corners, image.gray, image.dark);
  for (const cv::Point2f& corner : DetectCorners(options_.corners, image.gray, candidates, {}, mask)) {
    const std::optional<Eigen::Vector2d> undistorted = camera_.Undistort({corner.x, corner.y});
    if (!undistorted) continue;
    first.features.push_back(static_cast<int>(first.features.size()));
    first.undistorted.push_back(*undistorted);
    pixels_.push_back(corner);
  }
  alive_ = first.features;
  first_image_ = image.gray;
  first_pixels_ = pixels_;
  frames_.push_back(std::move(first));
  last_ = image;
}

bool MapInitializer::Follow(const FlowImage& image, const cv::Mat& mask, int frame, double time) {
  const FlowImage before = MatchBrightness(options_.flow, last_, image);
  FlowResult flow = TrackPoints(options_.flow, before, image, pixels_, pixels_);
  CheckReturn(options_.flow, before, image, pixels_, flow);
  WaitingFrame next{.frame = frame, .time = time, .features = {}, .undistorted = {}};
  std::vector<cv::Point2f> pixels;
  for (size_t i = 0; i < alive_.size(); ++i) {
    if (flow.found[i] == 0 || !IsKept(mask, flow.points[i])) continue;
    const std::optional<Eigen::Vector2d> undistorted = camera_.Undistort({flow.points[i].x, flow.points[i].y});
    if (!undistorted) continue;
    next.features.push_back(alive_[i]);
    next.undistorted.push_back(*undistorted);
    pixels.push_back(flow.points[i]);
  }
  // No first view is closer to an image than the image before it.
  if (time - frames_.front().time >= kMostSeconds || (frames_.size() > 1 && HasGone(next))) return false;
  // A dark or blurred first view never gets more features than it had.
  if (static_cast<int>(next.features.size()) < options_.initialization.min_landmarks) return false;
  alive_ = next.features;
  pixels_ = std::move(pixels);
  frames_.push_back(std::move(next));
  last_ = image;
  return true;
}

bool MapInitializer::HasGone(const WaitingFrame& next) const {
  // Corners of noise are gone in the next image.
  const double all = static_cast<double>(frames_[1].features.size());
  const double left = static_cast<double>(next.features.size());
  if (left < kFewestFeatures * all) return true;
  // A dashboard never goes out of sight.
  const std::vector<char> still = FindStatic(next);
  const double standing = static_cast<double>(std::ranges::count(still, 1));
  return all - standing > kLeastMovingShare * all && left - standing < kFewestFeatures * (all - standing);
}

std::vector<char> MapInitializer::FindStatic(const WaitingFrame& next) const {
  std::vector<char> still;
  for (size_t i = 0; i < next.features.size(); ++i) {
    const double motion = (next.undistorted[i] - frames_.front().undistorted[next.features[i]]).norm();
    still.push_back(motion <= options_.static_regions.max_motion ? 1 : 0);
  }
  return still;
}

MapInitializer::Matches MapInitializer::MatchesWithout(const std::vector<char>& left_out) const {
  Matches matches;
  for (size_t i = 0; i < left_out.size(); ++i) {
    if (left_out[i] != 0) continue;
    matches.first.push_back(frames_.front().undistorted[frames_.back().features[i]]);
    matches.second.push_back(frames_.back().undistorted[i]);
  }
  return matches;
}

TwoViewResult MapInitializer::MatchWithout(const std::vector<char>& left_out) const {
  const auto [first, second] = MatchesWithout(left_out);
  const int gone = static_cast<int>(frames_[1].features.size() - frames_.back().features.size());
  TwoViewResult views = InitializeFromTwoViews(options_.initialization, camera_.pinhole, first, second, gone);
  if (views.status != TwoViewStatus::kInitialized) return views;
  views.essential.agrees = OfAll(left_out, views.essential.agrees, char{0});
  views.essential.inlier = OfAll(left_out, views.essential.inlier, char{0});
  views.triangulated = OfAll(left_out, views.triangulated, char{0});
  views.points = OfAll(left_out, views.points, Eigen::Vector3d(0, 0, 0));
  return views;
}

bool MapInitializer::BelongToScene(const std::vector<char>& still, const RigidTransform& second_from_first) const {
  std::vector<double> motion;
  for (size_t i = 0; i < still.size(); ++i)
    if (still[i] != 0)
      motion.push_back(LeastSceneMotion(camera_.pinhole, second_from_first,
                                        frames_.front().undistorted[frames_.back().features[i]]));
  return Median(std::move(motion)) <= kMostMotionShare * options_.static_regions.max_motion;
}

MapInitializer::MatchedViews MapInitializer::MatchViews() const {
  const std::vector<char> still = FindStatic(frames_.back());
  const std::vector<char> none(still.size(), 0);
  if (std::ranges::count(still, 1) < kFewestStatic) return {MatchWithout(none), none, false};
  const Eigen::Quaterniond vehicle_from_camera = vehicle_from_camera_.value_or(Eigen::Quaterniond::Identity());
  std::vector<char> has_moved = still;
  for (char& flag : has_moved) flag = flag == 0 ? 1 : 0;
  const TwoViewResult moving = MatchWithout(still);
  const bool is_ahead = moving.status == TwoViewStatus::kInitialized &&
                        (vehicle_from_camera * moving.second_from_first.inverse().translation).z() > 0;
  // A vehicle that leaves before a car that waits has few cells, and looks like a scene before a car that reverses.
  if (!is_ahead && !IsScene(options_.initialization, camera_.pinhole, frames_.back().undistorted, has_moved)) {
    TwoViewResult stands;
    stands.status = TwoViewStatus::kStandstill;
    return {stands, none, true};
  }
  const bool drives =
      moving.status == TwoViewStatus::kInitialized && IsOfCar(moving.second_from_first, vehicle_from_camera);
  if (drives && !BelongToScene(still, moving.second_from_first)) return {moving, still, true};
  // What stands still may be far away: then it takes part.
  TwoViewResult all = MatchWithout(none);
  if (drives && all.status == TwoViewStatus::kStandstill) return {moving, none, true};
  // A dashboard and a scene that turns look like near and far points beside a camera that moves sideways.
  if (all.status == TwoViewStatus::kInitialized &&
      (!IsOfCar(all.second_from_first, vehicle_from_camera) || !BelongToScene(still, all.second_from_first)))
    all.status = TwoViewStatus::kFailed;
  return {all, none, true};
}

bool MapInitializer::MayBePassing(const TwoViewResult& views) const {
  if (!vehicle_from_camera_) return false;
  if (!IsOfCar(views.second_from_first, *vehicle_from_camera_)) return true;
  const auto [first, second] = MatchesWithout(std::vector<char>(frames_.back().undistorted.size(), 0));
  return MayBePassingVehicle(camera_.pinhole, views.essential, first, second,
                             options_.initialization.max_epipolar_error, *vehicle_from_camera_);
}

std::optional<InitialMap> MapInitializer::TryTwoViews() const {
  const auto [views, left_out, has_still] = MatchViews();
  if (views.status != TwoViewStatus::kInitialized || MayBePassing(views)) return std::nullopt;

  InitialMap map;
  map.frames = frames_;
  map.first_image = first_image_;
  map.first_pixels = first_pixels_;
  map.second_pixels = pixels_;
  map.radial_correction = camera_.radial_correction;
  map.second_from_first = views.second_from_first;
  const WaitingFrame& first = frames_.front();
  const WaitingFrame& second = frames_.back();
  map.has_point.assign(first.features.size(), 0);
  map.points.assign(first.features.size(), Eigen::Vector3d::Zero());
  for (size_t i = 0; i < second.features.size(); ++i) {
    map.has_point[second.features[i]] = views.triangulated[i];
    map.points[second.features[i]] = views.points[i];
  }
  map.has_still_features = has_still;
  if (std::ranges::count(left_out, 1) > 0) LeaveOut(left_out, map);
  return map;
}

}  // namespace turnscale
