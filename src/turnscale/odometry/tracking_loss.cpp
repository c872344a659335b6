// SPDX-License-Identifier: MIT
#include "turnscale/odometry/tracking_loss.h"

#include <utility>

namespace turnscale {

bool TrackingLoss::AddTracked(double time) {
  last_seen_time_ = time;
  lost_images_ = 0;
  return std::exchange(after_repeats_, false);
}

void TrackingLoss::AddRepeat(double time) {
  last_seen_time_ = time;
  after_repeats_ = true;
}

void TrackingLoss::AddLost(const cv::Mat& gray) {
  if (lost_images_++ == 0) first_lost_ = gray;
  after_repeats_ = false;
}

bool TrackingLoss::GivesUp(const MotionModel& motion, bool stood, double time) const {
  const std::optional<double> frozen_since = FrozenSince(motion, time);
  // Where not a single pixel changed, it is not the scene that is hidden.
  const bool is_same_image = frozen_since && last_same_time_ > *frozen_since;
  const double patience = stood && !is_same_image ? options_.max_hidden_seconds : options_.max_lost_seconds;
  return lost_images_ >= options_.min_lost_frames && time - motion.last_measured_time() > patience;
}

std::optional<double> TrackingLoss::FrozenAtEnd(const MotionModel& motion, double end) const {
  constexpr double kLeastSeconds = 1;
  const std::optional<double> frozen_since = FrozenSince(motion, end);
  if (!frozen_since && !after_repeats_) return std::nullopt;
  const double since = frozen_since.value_or(motion.last_measured_time());
  return end - since > kLeastSeconds ? std::optional(since) : std::nullopt;
}

std::optional<double> FrozenSince(const MotionModel& motion, double time) {
  // Images that show the same for longer are those of a car that stands, however abruptly it stopped.
  constexpr double kLongestFreeze = 15;
  const std::optional<double> stopped = motion.StoppedAtOnce();
  return stopped && time - *stopped < kLongestFreeze ? stopped : std::nullopt;
}

}  // namespace turnscale
