// SPDX-License-Identifier: MIT
#include "turnscale/odometry/map_initializer.h"

#include <utility>

#include "turnscale/features/corners.h"
#include "turnscale/mapping/two_view_initialization.h"

namespace turnscale {
namespace {

// Below this share of its features a first view has gone out of sight.
constexpr double kFewestFeatures = 0.4;
// A car that waits longer than this gets a new first view, which bounds the memory.
constexpr size_t kMostFrames = 300;

}  // namespace

std::optional<InitialMap> MapInitializer::Add(const FlowImage& image, int frame, double time) {
  if (frames_.empty() || !Follow(image, frame, time)) {
    Start(image, frame, time);
    return std::nullopt;
  }
  return TryTwoViews();
}

void MapInitializer::Start(const FlowImage& image, int frame, double time) {
  frames_.clear();
  alive_.clear();
  pixels_.clear();
  WaitingFrame first{.frame = frame, .time = time, .features = {}, .pixels = {}};
  for (const cv::Point2f& corner : DetectCorners(options_.corners, image.gray, {})) {
    const std::optional<Eigen::Vector2d> undistorted = camera_.Undistort({corner.x, corner.y});
    if (!undistorted) continue;
    first.features.push_back(static_cast<int>(first.features.size()));
    first.pixels.push_back(*undistorted);
    pixels_.push_back(corner);
  }
  alive_ = first.features;
  first_image_ = image.gray;
  first_pixels_ = pixels_;
  frames_.push_back(std::move(first));
  last_ = image;
}

bool MapInitializer::Follow(const FlowImage& image, int frame, double time) {
  FlowResult flow = TrackPoints(options_.flow, last_, image, pixels_, pixels_);
  CheckReturn(options_.flow, last_, image, pixels_, flow);
  WaitingFrame next{.frame = frame, .time = time, .features = {}, .pixels = {}};
  std::vector<cv::Point2f> pixels;
  for (size_t i = 0; i < alive_.size(); ++i) {
    if (flow.found[i] == 0) continue;
    const std::optional<Eigen::Vector2d> undistorted = camera_.Undistort({flow.points[i].x, flow.points[i].y});
    if (!undistorted) continue;
    next.features.push_back(alive_[i]);
    next.pixels.push_back(*undistorted);
    pixels.push_back(flow.points[i]);
  }
  const size_t features = frames_.front().features.size();
  if (frames_.size() >= kMostFrames) return false;
  if (static_cast<double>(next.features.size()) < kFewestFeatures * static_cast<double>(features)) return false;
  // A dark or blurred first view never gets more features than it had.
  if (static_cast<int>(next.features.size()) < options_.initialization.min_landmarks) return false;
  alive_ = next.features;
  pixels_ = std::move(pixels);
  frames_.push_back(std::move(next));
  last_ = image;
  return true;
}

std::optional<InitialMap> MapInitializer::TryTwoViews() const {
  const WaitingFrame& first = frames_.front();
  const WaitingFrame& second = frames_.back();
  std::vector<Eigen::Vector2d> first_pixels;
  for (const int feature : second.features) first_pixels.push_back(first.pixels[feature]);
  const TwoViewResult views =
      InitializeFromTwoViews(options_.initialization, camera_.pinhole, first_pixels, second.pixels);
  if (views.status != TwoViewStatus::kInitialized) return std::nullopt;

  InitialMap map;
  map.frames = frames_;
  map.first_image = first_image_;
  map.first_pixels = first_pixels_;
  map.second_pixels = pixels_;
  map.second_from_first = views.second_from_first;
  map.has_point.assign(first.features.size(), 0);
  map.points.assign(first.features.size(), Eigen::Vector3d::Zero());
  for (size_t i = 0; i < second.features.size(); ++i) {
    map.has_point[second.features[i]] = views.triangulated[i];
    map.points[second.features[i]] = views.points[i];
  }
  return map;
}

}  // namespace turnscale
