// SPDX-License-Identifier: MIT
#include "turnscale/scale/path_segment.h"

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "turnscale/base/check_part.h"
#include "turnscale/base/error.h"
#include "turnscale/scale/road_parts.h"

namespace turnscale {
namespace {

class Splitter {
 public:
  explicit Splitter(const std::vector<VehicleStep>& steps) : steps_(steps) {}

  void Turn(int first, int last) { Add(first, last).turning = true; }

  void Straight(int first, int last, int max_steps) {
    for (int i = first + 1; i <= last; ++i) {
      if (!steps_[i].after_gap && !IsUnitBroken(steps_[i])) continue;
      Parts(first, i - 1, max_steps);
      first = i;
    }
    Parts(first, last, max_steps);
  }

  std::vector<PathSegment> Finish() && { return std::move(segments_); }

 private:
  void Parts(int first, int last, int max_steps) {
    const int count = last - first + 1;
    if (count <= 0) return;
    const int most = MostStraightSteps(std::span(steps_).subspan(first, count), max_steps);
    const int parts = (count - 1) / most + 1;
    const auto begin = [&](std::int64_t part) { return first + static_cast<int>(count * part / parts); };
    for (int part = 0; part < parts; ++part)
      Add(begin(part), begin(part + 1) - 1).road_part = parts > 1 && most < max_steps;
  }

  PathSegment& Add(int first, int last) {
    PathSegment segment{.first = first, .last = last, .gap_sigma = steps_[first].gap_sigma};
    if (IsUnitBroken(steps_[first]))
      segment.gap_sigma = std::hypot(segment.gap_sigma, std::sqrt(steps_[first].unit_variance));
    for (int i = first; i <= last; ++i) {
      segment.angle += steps_[i].turned();
      segment.turned += std::abs(steps_[i].turned());
      segment.length += steps_[i].driven();
      if (i > first || !IsUnitBroken(steps_[i])) segment.unit_variance += steps_[i].unit_variance;
    }
    segment.middle = length_ + 0.5 * segment.length;
    length_ += segment.length;
    return segments_.emplace_back(segment);
  }

  const std::vector<VehicleStep>& steps_;
  std::vector<PathSegment> segments_;
  double length_ = 0;
};

}  // namespace

void PathSegmentOptions::Check() const {
  CheckPart("turns.", turns);
  if (max_straight_steps < 1) throw InputError("max_straight_steps: has to be at least 1");
}

bool IsUnitBroken(const VehicleStep& step) {
  constexpr double kMostSigma = 0.05;
  return step.unit_variance > kMostSigma * kMostSigma;
}

std::vector<TurningRegion> FindTurns(const std::vector<VehicleStep>& steps, const TurnDetectorOptions& options) {
  TurnDetector detector(options);
  std::vector<TurningRegion> turns;
  const auto keep = [&](const std::optional<TurningRegion>& turn) {
    if (turn) turns.push_back(*turn);
  };
  for (const VehicleStep& step : steps) keep(step.usable ? detector.Add(step.motion.psi) : detector.AddUnmeasured());
  keep(detector.Finish());
  return turns;
}

std::vector<PathSegment> SplitIntoSegments(const std::vector<VehicleStep>& steps, const PathSegmentOptions& options) {
  options.Check();
  Splitter splitter(steps);
  int next = 0;
  for (const TurningRegion& turn : FindTurns(steps, options.turns)) {
    splitter.Straight(next, turn.first - 1, options.max_straight_steps);
    splitter.Turn(turn.first, turn.last);
    next = turn.last + 1;
  }
  splitter.Straight(next, static_cast<int>(steps.size()) - 1, options.max_straight_steps);
  return std::move(splitter).Finish();
}

}  // namespace turnscale
