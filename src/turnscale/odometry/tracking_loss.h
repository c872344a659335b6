// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>

#include <opencv2/core/mat.hpp>

#include "turnscale/odometry/motion_model.h"
#include "turnscale/odometry/options.h"

namespace turnscale {

/// What the images since the last tracked one have shown, and what follows where they are not tracked: whether the
/// scene is only hidden for a while, and since when the recording may have been frozen. Times are in seconds; `motion`
/// is that of the tracked images.
class TrackingLoss {
 public:
  explicit TrackingLoss(const TrackingOptions& options) : options_(options) {}

  /// An image was tracked, or the map starts with it. Returns whether images since the last tracked one repeated it.
  bool AddTracked(double time);
  /// An image repeats the last tracked one.
  void AddRepeat(double time);
  /// All pixels of an image are those of the last tracked one, whatever else becomes of it.
  void AddSamePixels(double time) { last_same_time_ = time; }
  /// An image was not tracked (8-bit gray).
  void AddLost(const cv::Mat& gray);
  /// There was no image: the map is no more lost than before.
  void AddUnreadable() { after_repeats_ = false; }

  /// Of the last image that was tracked or repeated.
  double last_seen_time() const { return last_seen_time_; }
  /// The first image that was not tracked since the last that was. Empty: none yet.
  const cv::Mat& first_lost() const { return first_lost_; }

  /// Whether to wait no longer for what the last tracked image showed. `stood`: the car stood, and what passes may hide
  /// the scene.
  bool GivesUp(const MotionModel& motion, bool stood, double time) const;

  /// Where the drive ends without another view: the time after which its images have shown a frozen one. Empty if they
  /// have not.
  std::optional<double> FrozenAtEnd(const MotionModel& motion, double end) const;

 private:
  TrackingOptions options_;
  double last_seen_time_ = 0;
  int lost_images_ = 0;  ///< consecutive, up to now
  cv::Mat first_lost_;
  bool after_repeats_ = false;  ///< images since the last tracked one repeat it
  double last_same_time_ = -std::numeric_limits<double>::infinity();
};

/// Since when the images have shown the same, seconds, although the car has driven on: it cannot have stopped like
/// that. Empty if they have not, or for so long that the car stands after all.
std::optional<double> FrozenSince(const MotionModel& motion, double time);

}  // namespace turnscale
