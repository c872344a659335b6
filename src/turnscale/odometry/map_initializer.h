// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/features/optical_flow.h"
#include "turnscale/mapping/two_view_initialization.h"
#include "turnscale/odometry/image_mask.h"
#include "turnscale/odometry/options.h"

namespace turnscale {

/// A frame that waits for the map: what it saw of the first view's features.
struct WaitingFrame {
  int frame = 0;
  double time = 0;
  std::vector<int> features;                 ///< numbers of the features seen
  std::vector<Eigen::Vector2d> undistorted;  ///< their pixels in the ideal pinhole image
};

/// What a new map starts from. All in the first view's camera frame, in the arbitrary unit of the start.
struct InitialMap {
  std::vector<WaitingFrame> frames;  ///< first view ... second view; the first saw every feature
  cv::Mat first_image;
  std::vector<cv::Point2f> first_pixels;   ///< in the first image as it came, one per feature
  std::vector<cv::Point2f> second_pixels;  ///< in the second image as it came, one per feature the second view saw
  double radial_correction = 0;            ///< under which the frames' pixels are undistorted
  RigidTransform second_from_first;
  std::vector<char> has_point;          ///< one flag per feature
  std::vector<Eigen::Vector3d> points;  ///< one per feature
  /// Where features stood still in the image, and where others moved; empty if all belong to the scene.
  std::vector<ObservedMotion> motion;
  /// Features stood still in the image, far away or none of the scene.
  bool has_still_features = false;

  int CountPoints() const { return static_cast<int>(std::ranges::count(has_point, 1)); }
};

/// Collects views until two of them give a map: follows the first view's features from image to image, waits through
/// standstill, pure rotation and low parallax, and takes a new first view when too few features are left. Where a good
/// part of the features moves as a scene does before a car that drives, those that stand still in the image, but would
/// have to move if they belonged to it, are left out. What seems to move back beside them, in too few cells of the
/// image, is a vehicle that leaves before a car that waits, and no start.
class MapInitializer {
 public:
  /// Where `vehicle_from_camera` is known, what moves sideways is no start, nor what may be the side of a vehicle that
  /// passes (MayBePassingVehicle).
  MapInitializer(const OdometryOptions& options, const CameraModel& camera,
                 const std::optional<Eigen::Quaterniond>& vehicle_from_camera = {})
      : options_(options), camera_(camera), vehicle_from_camera_(vehicle_from_camera) {}

  /// Takes the next image; gives the map's start as soon as two views suffice for it. `mask`: as ImageMask::pixels.
  std::optional<InitialMap> Add(const FlowImage& image, const cv::Mat& mask, int frame, double time);

  int tracked() const { return static_cast<int>(alive_.size()); }

 private:
  void Start(const FlowImage& image, const cv::Mat& mask, int frame, double time);
  bool Follow(const FlowImage& image, const cv::Mat& mask, int frame, double time);
  std::optional<InitialMap> TryTwoViews() const;
  /// The first and the latest view, and which features of the latest are left out, as they stand still.
  struct MatchedViews {
    TwoViewResult views;
    std::vector<char> left_out;
    bool has_still = false;  ///< features stand still, left out or not
  };
  MatchedViews MatchViews() const;
  /// Undistorted pixels of the features that both views have.
  struct Matches {
    std::vector<Eigen::Vector2d> first;
    std::vector<Eigen::Vector2d> second;
  };
  Matches MatchesWithout(const std::vector<char>& left_out) const;
  /// Flags and points of the result are those of all features that the latest view has.
  TwoViewResult MatchWithout(const std::vector<char>& left_out) const;
  bool MayBePassing(const TwoViewResult& views) const;
  /// Whether the first view is out of sight.
  bool HasGone(const WaitingFrame& next) const;
  /// Features that are where the first view saw them: one flag per feature seen.
  std::vector<char> FindStatic(const WaitingFrame& next) const;
  /// Whether features of the latest view that stand still can be far points.
  bool BelongToScene(const std::vector<char>& still, const RigidTransform& second_from_first) const;

  OdometryOptions options_;
  CameraModel camera_;
  std::optional<Eigen::Quaterniond> vehicle_from_camera_;
  cv::Mat first_image_;
  std::vector<cv::Point2f> first_pixels_;
  FlowImage last_;
  std::vector<int> alive_;           ///< features found in the last image
  std::vector<cv::Point2f> pixels_;  ///< theirs, in the last image
  std::vector<WaitingFrame> frames_;
};

}  // namespace turnscale
