// SPDX-License-Identifier: MIT
#include "turnscale/scale/missing_scale.h"

#include <algorithm>
#include <cmath>

#include "turnscale/base/number_text.h"
#include "turnscale/geometry/angle.h"

namespace turnscale {
namespace {

// What would make the scale known.
std::string Remedy(const DriveEvidence& evidence, const CarPrior& car, const ScaleEstimatorOptions& options) {
  if (!car.knows_lever_arm()) return "give the lever arm, or the height of the camera more exactly";
  if (car.lever_arm_sigma > options.max_sigma * car.lever_arm)
    return "the lever arm, " + NumberText(car.lever_arm) + " +-" +
           NumberText(std::round(100 * car.lever_arm_sigma) / 100) + " m, is itself too uncertain: measure it";
  const long degrees = std::lround(InDegrees(options.segments.turns.min_region_angle));
  const bool road = std::ranges::any_of(evidence.of_segments,
                                        [](const SegmentEvidence& segment) { return segment.road.has_value(); });
  const bool turns = std::ranges::any_of(evidence.of_segments,
                                         [](const SegmentEvidence& segment) { return segment.turn.has_value(); });
  return (turns ? "a sharper or slower turn is needed"
                : "a slow turn of " + std::to_string(degrees) + " degrees or more is needed") +
         (road && !car.knows_height() ? ", or the measured height of the camera above the road" : "");
}

bool AllSwingInward(const std::vector<SegmentEvidence>& evidence, const DriveState& state) {
  int turns = 0;
  for (const SegmentEvidence& segment : evidence) {
    if (!segment.turn) continue;
    if (!SwingsInward(*segment.turn, state)) return false;
    ++turns;
  }
  return turns > 0;
}

}  // namespace

std::string WhyNoStart(const DriveEvidence& evidence, const CarPrior& car, const ScaleEstimatorOptions& options) {
  const std::string remedy = Remedy(evidence, car, options);
  if (evidence.has_turns() && evidence.has_sparse_steps)
    return "in turns the camera turns by too much from one image or pose to the next, which are far apart in time; " +
           remedy;
  if (!car.knows_lever_arm()) return "too few steps show the height above the road";
  if (!evidence.has_turns()) return "no turn; " + remedy;
  if (AllSwingInward(evidence.of_segments, PriorBelief(car, 0).mean))
    return "in all turns the camera swings to the inside: they are too fast, or the camera is not ahead of the rear "
           "axle, looking forward, as the lever arm says; " +
           remedy;
  return "no sufficiently slow turn shows the expected lateral motion, or the times of the images are wrong; " + remedy;
}

std::string WhyTooUncertain(double sigma, const DriveEvidence& evidence, const CarPrior& car,
                            const ScaleEstimatorOptions& options) {
  const long limit = std::lround(100 * options.max_sigma);
  return "the drive leaves the scale uncertain by " + std::to_string(std::max(std::lround(100 * sigma), limit + 1)) +
         " %, more than " + std::to_string(limit) + " %; " + Remedy(evidence, car, options);
}

}  // namespace turnscale
