// SPDX-License-Identifier: MIT
#include "turnscale/run/time_check.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Core>
#include <fmt/format.h>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

// A step over a missing image is twice as long as those beside it; over two, three times.
constexpr double kLeastGrowth = 1.6;
constexpr double kMostGrowth = 4;
// Beyond the noise of poses, metres.
constexpr double kLeastExcess = 0.05;
// Beyond what engines and brakes can do, m/s^2.
constexpr double kLeastAcceleration = 15;
// Intervals that differ by more are uneven: it is the times that make the speed jump then.
constexpr double kEvenIntervals = 0.2;
constexpr int kLeastSkips = 3;
constexpr double kLeastSkipShare = 0.01;
// A car that turns round stops between: a step back is no longer than those beside it.
constexpr double kLeastJump = 3;
// In the median over turns, weighted by their angles, each from its beginning to its end, m/s^2: tyres hold as much,
// but nobody drives so.
constexpr double kMostSideways = 6;
// The same, where even a car that is parked turns faster.
constexpr double kLeastSideways = 0.25;

// Intervals of which one is this many times as long as the one beside it.
constexpr double kUneven = 2;
// Over them, the distances differ by less than this power of the ratio of the intervals where it is the times that are
// wrong.
constexpr double kMostFollowed = 0.35;
constexpr int kLeastUneven = 10;
constexpr double kLeastUnevenShare = 0.1;  // of the steps
constexpr double kLeastEvenShare = 0.7;    // of the pairs with uneven intervals
// A step that counts is at least this share of the usual one: others are noise.
constexpr double kLeastOfUsual = 0.3;

struct ImageStep {
  double time = 0;      // of the image that it leads to
  double seconds = 0;   // since the image before
  double distance = 0;  // metres
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();
};

ImageStep StepBetween(const FrameResult& before, const FrameResult& after) {
  const Eigen::Vector3d motion = after.world_from_camera->translation - before.world_from_camera->translation;
  return {after.time, after.time - before.time, motion.norm(), motion};
}

// Between tracked images that follow one another in the drive; any other image between them ends a row of steps.
std::vector<std::vector<ImageStep>> RowsOfSteps(const std::vector<FrameResult>& frames) {
  std::vector<std::vector<ImageStep>> rows(1);
  const FrameResult* last = nullptr;
  for (const FrameResult& frame : frames) {
    if (frame.is_measured() && last) {
      rows.back().push_back(StepBetween(*last, frame));
    } else if (!rows.back().empty()) {
      rows.emplace_back();
    }
    last = frame.is_measured() ? &frame : nullptr;
  }
  return rows;
}

bool SkipsAnImage(const ImageStep& before, const ImageStep& step, const ImageStep& after) {
  const auto [shorter, longer] = std::minmax(before.distance, after.distance);
  const double excess = step.distance - longer;
  const double uneven =
      std::max(std::abs(before.seconds - step.seconds), std::abs(after.seconds - step.seconds)) / step.seconds;
  return uneven < kEvenIntervals && step.distance > kLeastGrowth * longer && step.distance < kMostGrowth * shorter &&
         excess > kLeastExcess && excess > kLeastAcceleration * step.seconds * step.seconds;
}

std::optional<std::string> SkippedImages(const std::vector<std::vector<ImageStep>>& rows, double first_time) {
  size_t steps = 0;
  std::vector<double> skips;  // times
  for (const std::vector<ImageStep>& row : rows) {
    steps += row.size();
    for (size_t i = 1; i + 1 < row.size(); ++i)
      if (SkipsAnImage(row[i - 1], row[i], row[i + 1])) skips.push_back(row[i].time);
  }
  if (skips.size() < kLeastSkips || static_cast<double>(skips.size()) < kLeastSkipShare * static_cast<double>(steps))
    return std::nullopt;
  return fmt::format(
      "images seem to be missing in at least {} places (the first at {:.1f} s), as the car moves about twice as far "
      "from one image to the next as before and after, at even times: speeds are wrong, and the scale may be; give the "
      "true times of the images (--timestamps)",
      skips.size(), skips.front() - first_time);
}

std::optional<std::string> UnevenTimes(const std::vector<std::vector<ImageStep>>& rows, double first_time) {
  std::vector<double> distances;
  for (const std::vector<ImageStep>& row : rows)
    for (const ImageStep& step : row) distances.push_back(step.distance);
  if (distances.empty()) return std::nullopt;
  const double least = kLeastOfUsual * Median(distances);
  int uneven = 0;
  std::vector<double> evenly_driven;  // times
  for (const std::vector<ImageStep>& row : rows) {
    for (size_t i = 1; i < row.size(); ++i) {
      const double by_time = std::abs(std::log(row[i].seconds / row[i - 1].seconds));
      if (by_time < std::log(kUneven) || !(std::min(row[i].distance, row[i - 1].distance) > least)) continue;
      ++uneven;
      const double by_distance = std::abs(std::log(row[i].distance / row[i - 1].distance));
      if (by_distance < kMostFollowed * by_time) evenly_driven.push_back(row[i].time);
    }
  }
  const double count = static_cast<double>(evenly_driven.size());
  if (evenly_driven.size() < kLeastUneven || count < kLeastUnevenShare * static_cast<double>(distances.size()) ||
      count < kLeastEvenShare * uneven)
    return std::nullopt;
  return fmt::format(
      "the times of the images are uneven in at least {} places (the first at {:.1f} s), although the car moves as far "
      "from one image to the next as before: they are not those of the exposure, speeds are wrong, and the scale may "
      "be; give the true times (--timestamps), or the rate (--fps)",
      evenly_driven.size(), evenly_driven.front() - first_time);
}

bool JumpsBack(const ImageStep& before, const ImageStep& step, const ImageStep& after) {
  const auto [shorter, longer] = std::minmax(before.distance, after.distance);
  return before.motion.dot(step.motion) < 0 && after.motion.dot(step.motion) < 0 && shorter > kLeastExcess &&
         step.distance > kLeastJump * longer &&
         step.distance > kLeastExcess + kLeastAcceleration * step.seconds * step.seconds;
}

// Tracking may be lost for a moment at the jump.
std::vector<ImageStep> StepsOverLosses(const std::vector<FrameResult>& frames) {
  std::vector<ImageStep> steps;
  const FrameResult* last = nullptr;
  for (const FrameResult& frame : frames) {
    if (!frame.is_measured()) continue;
    if (last) steps.push_back(StepBetween(*last, frame));
    last = &frame;
  }
  return steps;
}

std::optional<std::string> JumpBack(const std::vector<FrameResult>& frames, double first_time) {
  const std::vector<ImageStep> steps = StepsOverLosses(frames);
  const ImageStep* first = nullptr;
  int jumps = 0;
  for (size_t i = 1; i + 1 < steps.size(); ++i) {
    if (!JumpsBack(steps[i - 1], steps[i], steps[i + 1])) continue;
    if (jumps++ == 0) first = &steps[i];
  }
  if (!first) return std::nullopt;
  return fmt::format(
      "the car seems to jump back by {:.1f} m at {:.1f} s{}, and the path is wrong there: if clips that overlap were "
      "joined into this video, give the clips themselves",
      first->distance, first->time - first_time, jumps > 1 ? fmt::format(" (the first of {} such jumps)", jumps) : "");
}

double TimeOf(const std::vector<FrameResult>& frames, int number) {
  const auto found = std::ranges::lower_bound(frames, number, {}, &FrameResult::frame);
  return found == frames.end() ? frames.back().time : found->time;
}

std::optional<std::string> UnusualTurns(const std::vector<FrameResult>& frames, const std::vector<TurnResult>& turns) {
  std::vector<std::pair<double, double>> sideways;
  for (const TurnResult& turn : turns) {
    const double seconds = TimeOf(frames, turn.last_frame) - TimeOf(frames, turn.first_frame);
    if (turn.used && seconds > 0)
      sideways.emplace_back(turn.speed * std::abs(turn.angle) / seconds, std::abs(turn.angle));
  }
  return UnusualTurnsWarning(std::move(sideways), "the times of the images (--fps, --timestamps)");
}

}  // namespace

std::optional<std::string> UnusualTurnsWarning(std::vector<std::pair<double, double>> sideways,
                                               const std::string& check, size_t fewest_slow) {
  if (sideways.empty()) return std::nullopt;
  const size_t count = sideways.size();
  const double median = WeightedMedian(std::move(sideways));
  if (median > kMostSideways)
    return fmt::format(
        "the car would take its turns at {:.0f} m/s^2 sideways, which hardly any car does: check {} and the lever arm",
        median, check);
  if (median < kLeastSideways && count >= fewest_slow)
    return fmt::format(
        "the car would take its turns at {:.2g} m/s^2 sideways, as slowly as hardly any car does: check {}; with wrong "
        "ones, as of slow motion, the scale is wrong, too",
        median, check);
  return std::nullopt;
}

std::vector<std::string> TimeWarnings(const std::vector<FrameResult>& frames, const std::vector<TurnResult>& turns,
                                      double first_time) {
  std::vector<std::string> warnings;
  const std::vector<std::vector<ImageStep>> rows = RowsOfSteps(frames);
  if (std::optional<std::string> uneven = UnevenTimes(rows, first_time)) warnings.push_back(std::move(*uneven));
  if (frames.empty() || frames.back().scale_state == ScaleState::kPending) return warnings;
  if (std::optional<std::string> skipped = SkippedImages(rows, first_time)) warnings.push_back(std::move(*skipped));
  if (std::optional<std::string> jump = JumpBack(frames, first_time)) warnings.push_back(std::move(*jump));
  if (std::optional<std::string> unusual = UnusualTurns(frames, turns)) warnings.push_back(std::move(*unusual));
  return warnings;
}

}  // namespace turnscale
