// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/features/optical_flow.h"
#include "turnscale/odometry/options.h"

namespace turnscale {

/// A frame that waits for the map: what it saw of the first view's features.
struct WaitingFrame {
  int frame = 0;
  double time = 0;
  std::vector<int> features;            ///< numbers of the features seen
  std::vector<Eigen::Vector2d> pixels;  ///< undistorted, one per feature seen
};

/// What a new map starts from. All in the first view's camera frame, in the arbitrary unit of the start.
struct InitialMap {
  std::vector<WaitingFrame> frames;  ///< first view ... second view; the first saw every feature
  cv::Mat first_image;
  std::vector<cv::Point2f> first_pixels;   ///< in the first image as it came, one per feature
  std::vector<cv::Point2f> second_pixels;  ///< in the second image as it came, one per feature the second view saw
  RigidTransform second_from_first;
  std::vector<char> has_point;          ///< one flag per feature
  std::vector<Eigen::Vector3d> points;  ///< one per feature

  int CountPoints() const { return static_cast<int>(std::ranges::count(has_point, 1)); }
};

/// Collects views until two of them give a map: follows the first view's features from image to image, waits through
/// standstill, pure rotation and low parallax, and takes a new first view when too few features are left.
class MapInitializer {
 public:
  MapInitializer(const OdometryOptions& options, const CameraModel& camera) : options_(options), camera_(camera) {}

  /// Takes the next image; gives the map's start as soon as two views suffice for it.
  std::optional<InitialMap> Add(const FlowImage& image, int frame, double time);

  int tracked() const { return static_cast<int>(alive_.size()); }

 private:
  void Start(const FlowImage& image, int frame, double time);
  bool Follow(const FlowImage& image, int frame, double time);
  std::optional<InitialMap> TryTwoViews() const;

  OdometryOptions options_;
  CameraModel camera_;
  cv::Mat first_image_;
  std::vector<cv::Point2f> first_pixels_;
  FlowImage last_;
  std::vector<int> alive_;           ///< features found in the last image
  std::vector<cv::Point2f> pixels_;  ///< theirs, in the last image
  std::vector<WaitingFrame> frames_;
};

}  // namespace turnscale
