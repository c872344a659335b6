// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <vector>

#include <opencv2/core.hpp>

#include "turnscale/features/patch_alignment.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/feature_tracks.h"

namespace turnscale {

/// What counts as an image that a recorder has written once more. At ten images a second, a car does not lose most of
/// its speed from one to the next: that would be a braking of 10 m/s^2 and more. The longer an image stays the same,
/// the less this tells: a car that went on at 10 m/s can stop within two seconds. Live poses of repeated images are
/// predictions, which overshoot where the car has in fact stopped. In the refined path they lie between the measured
/// poses before and after.
struct RepeatOptions {
  /// Median motion of the landmarks that the prediction has to expect, pixels: less is like tracking noise. Where all
  /// pixels of the two images are the same, 0.2 are enough: noise makes any two images of a camera differ.
  double min_expected_motion = 1.5;
  /// The image repeats the one before if its landmarks have moved by less than this share of what was expected.
  double max_motion_share = 0.25;
  /// And by no more than this, pixels, which is tracking noise: where a prediction is wrong its share is large.
  double max_motion = 0.3;
  /// Images further apart than this, seconds, are repeats only where all their pixels are the same: a car can brake to
  /// a stop within that time.
  double max_interval = 0.15;
  /// A car whose image has not moved for longer stands, seconds. Longer than most recorders hang; where the car stands
  /// after all, its refined path leads to the same place.
  double max_seconds = 3;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Median motion of the landmarks since an image, pixels.
struct ImageMotion {
  double expected = 0;
  double seen = std::numeric_limits<double>::infinity();
};

/// Where an image showed a landmark, where the next one was expected to, and where it does.
struct LandmarkMotion {
  Eigen::Vector2d before = Eigen::Vector2d::Zero();
  Eigen::Vector2d expected = Eigen::Vector2d::Zero();
  Eigen::Vector2d seen = Eigen::Vector2d::Zero();
};

/// Of two images of one size.
bool HaveSamePixels(const cv::Mat& first, const cv::Mat& second);

ImageMotion MedianMotion(const std::vector<LandmarkMotion>& landmarks);

/// When an image was taken, seconds after others.
struct ImageTiming {
  double since_measured = 0;  ///< after the last one whose pose was measured, which it may repeat
  double interval = 0;        ///< after the last one that was tracked or a repeat itself
};

/// Whether the image is a repeated one, by its time and by what has moved in it; for images whose pixels are not kept.
bool IsRepeated(const RepeatOptions& options, const ImageTiming& timing, const ImageMotion& motion);

/// An image, and the one before it; for the time of a call, as it refers to both.
struct ImagePair {
  const cv::Mat& first;
  const std::vector<FeatureTrack>& tracks;  ///< what it shows
  const cv::Mat& second;
  const RigidTransform& predicted_from_world;  ///< where the camera is expected in the second
  ImageTiming timing;                          ///< of the second
};

/// Whether the second image shows what the first one does, where another one is expected: patches around landmarks are
/// compared at the same place, up to gain, offset, noise and a fraction of a pixel, so a repeat that was compressed
/// anew is found and another image of an even gray is none.
bool IsRepeated(const RepeatOptions& options, const PatchAlignmentOptions& alignment, const Map& map,
                const ImagePair& images);

}  // namespace turnscale
