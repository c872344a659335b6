// SPDX-License-Identifier: MIT
#include "turnscale/run/path_summary.h"

#include <algorithm>

namespace turnscale {
namespace {

// Along the keyframes, and from frame to frame where the path is not measured. A standing car adds no keyframes: else
// the noise of its poses would add up, the more the higher the frame rate. One that turns back between two keyframes is
// measured by way of its farthest place.
void MeasurePath(const std::vector<FrameResult>& frames, PathSummary& path) {
  const FrameResult* measured = nullptr;  // up to which the path has been measured
  const FrameResult* farthest = nullptr;  // from there, of the frames since
  const FrameResult* before = nullptr;
  const auto measure_to = [&](const FrameResult& frame) {
    double step = DistanceBetween(*measured, frame);
    if (farthest && DistanceBetween(*measured, *farthest) > step)
      step = DistanceBetween(*measured, *farthest) + DistanceBetween(*farthest, frame);
    path.distance += step;
    measured = &frame;
    farthest = nullptr;
    return step;
  };
  for (const FrameResult& frame : frames) {
    if (!frame.world_from_camera) continue;
    if (!before) {
      measured = &frame;
    } else if (IsMissing(path.missing, before->time, frame.time)) {
      measure_to(*before);
      path.missing_distance += measure_to(frame);
    } else if (frame.keyframe) {
      measure_to(frame);
    } else if (frame.is_measured() &&
               (!farthest || DistanceBetween(*measured, frame) > DistanceBetween(*measured, *farthest))) {
      farthest = &frame;
    }
    before = &frame;
  }
  if (before) measure_to(*before);
}

// Images that show that the car waits are no sign of a path that is lacking.
std::optional<UnmappedBeginning> FindBeginning(const std::vector<FrameResult>& frames, const SeenImages& seen,
                                               const std::optional<UncertainScale>& uncertain) {
  constexpr double kBriefSeconds = 0.5;
  const std::optional<MissingPart> part = PartBeforeMap(frames);
  if (!part || seen.Still()) return std::nullopt;
  double length = LengthBefore(*part, frames);
  // A map whose scale is hardly known does not tell the speed.
  if (uncertain && uncertain->from < part->to + kBriefSeconds)
    length = std::max(length, uncertain->usual_speed() * (part->to - part->from));
  return UnmappedBeginning{*part, length, IsMostOfDrive(*part, frames)};
}

int CountOf(TrackingState state, const std::vector<FrameResult>& frames) {
  return static_cast<int>(std::ranges::count(frames, state, &FrameResult::state));
}

}  // namespace

FrameCounts FrameCountsOf(const std::vector<FrameResult>& frames) {
  return {.total = static_cast<int>(frames.size()),
          .tracked = CountOf(TrackingState::kTracked, frames),
          .repeated = CountOf(TrackingState::kRepeated, frames),
          .bridged = CountOf(TrackingState::kBridged, frames),
          .initializing = CountOf(TrackingState::kInitializing, frames),
          .keyframes = static_cast<int>(std::ranges::count_if(frames, &FrameResult::keyframe))};
}

PathSummary PathSummaryOf(const std::vector<FrameResult>& frames, const std::vector<int>& repeated,
                          const SeenImages& seen, double lever_arm) {
  PathSummary path;
  path.seconds = frames.empty() ? 0 : frames.back().time - frames.front().time;
  path.missing = FindMissingParts(frames);
  MeasurePath(frames, path);
  path.impossible = FindImpossibleMotion(frames);
  path.impossible_directions = FindImpossibleDirections(frames, lever_arm);
  path.uncertain = FindUncertainScale(frames);
  path.frozen = FindFrozenParts(frames, repeated);
  path.beginning = FindBeginning(frames, seen, path.uncertain);
  return path;
}

}  // namespace turnscale
