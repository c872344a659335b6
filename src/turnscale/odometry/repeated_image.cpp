// SPDX-License-Identifier: MIT
#include "turnscale/odometry/repeated_image.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

// Landmarks that are compared: enough for a median, few enough to cost little.
constexpr size_t kSample = 150;
constexpr size_t kFewest = 20;
// Share of them that has to look the same; the others may be covered by what moves by itself.
constexpr double kLeastShare = 0.7;

// Median motion that has to be expected where all pixels are the same, pixels: images of a car that still moves differ.
constexpr double kExpectedOfSame = 0.2;

// A sample of the landmarks with where they are expected.
std::vector<LandmarkMotion> SampleLandmarks(const Map& map, const std::vector<FeatureTrack>& tracks,
                                            const RigidTransform& predicted_from_world) {
  std::vector<LandmarkMotion> sample;
  for (const FeatureTrack* track : SampleWithDepth(map, tracks, kSample)) {
    const Eigen::Vector3d x = predicted_from_world * map.landmarks[track->landmark].position;
    const std::optional<Eigen::Vector2d> expected = map.camera.ProjectInFront(x);
    const Eigen::Vector2d before(track->pixel.x, track->pixel.y);
    if (expected) sample.push_back({before, *expected, before});
  }
  return sample;
}

}  // namespace

void RepeatOptions::Check() const {
  if (!(min_expected_motion > 0)) throw InputError("min_expected_motion: has to be positive");
  if (!(max_motion_share >= 0 && max_motion_share < 1)) throw InputError("max_motion_share: has to be in 0...1");
  if (!(max_motion > 0)) throw InputError("max_motion: has to be positive");
  if (!(max_interval >= 0)) throw InputError("max_interval: must not be negative");
  if (!(max_seconds >= 0)) throw InputError("max_seconds: must not be negative");
}

bool HaveSamePixels(const cv::Mat& first, const cv::Mat& second) {
  for (int row = 0; row < first.rows; ++row)
    if (!std::equal(first.ptr<uchar>(row), first.ptr<uchar>(row) + first.cols, second.ptr<uchar>(row))) return false;
  return true;
}

ImageMotion MedianMotion(const std::vector<LandmarkMotion>& landmarks) {
  if (landmarks.size() < kFewest) return {};
  std::vector<double> expected;
  std::vector<double> seen;
  for (const LandmarkMotion& landmark : landmarks) {
    expected.push_back((landmark.expected - landmark.before).norm());
    seen.push_back((landmark.seen - landmark.before).norm());
  }
  return {Median(std::move(expected)), Median(std::move(seen))};
}

bool IsRepeated(const RepeatOptions& options, const ImageTiming& timing, const ImageMotion& motion) {
  return timing.since_measured <= options.max_seconds && timing.interval <= options.max_interval &&
         motion.expected >= options.min_expected_motion &&
         motion.seen <= std::min(options.max_motion, options.max_motion_share * motion.expected);
}

bool IsRepeated(const RepeatOptions& options, const PatchAlignmentOptions& alignment, const Map& map,
                const ImagePair& images) {
  if (images.timing.since_measured > options.max_seconds) return false;
  const std::vector<LandmarkMotion> sample = SampleLandmarks(map, images.tracks, images.predicted_from_world);
  const double expected = MedianMotion(sample).expected;
  if (expected < options.min_expected_motion || images.timing.interval > options.max_interval)
    return expected >= kExpectedOfSame && HaveSamePixels(images.first, images.second);
  const double least = kLeastShare * static_cast<double>(sample.size());
  std::vector<LandmarkMotion> same;
  for (size_t i = 0; i < sample.size(); ++i) {
    // Of most images this is certain after a part of the sample.
    if (static_cast<double>(same.size() + sample.size() - i) < least) return false;
    const LandmarkMotion& landmark = sample[i];
    const std::optional<Eigen::Vector2d> seen = AlignPatch(alignment, images.first, landmark.before,
                                                           Eigen::Matrix2d::Identity(), images.second, landmark.before);
    if (seen) same.push_back({landmark.before, landmark.expected, *seen});
  }
  return static_cast<double>(same.size()) >= least && IsRepeated(options, images.timing, MedianMotion(same));
}

}  // namespace turnscale
