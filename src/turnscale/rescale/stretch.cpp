// SPDX-License-Identifier: MIT
#include "turnscale/rescale/stretch.h"

#include <optional>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

std::vector<TurningRegion> TurnsOf(const std::vector<SwayStep>& steps, const TurnDetectorOptions& options) {
  TurnDetector detector(options);
  std::vector<TurningRegion> turns;
  const auto keep = [&](const std::optional<TurningRegion>& turn) {
    if (turn) turns.push_back(*turn);
  };
  for (const SwayStep& step : steps) keep(step.usable ? detector.Add(step.psi) : detector.AddUnmeasured());
  keep(detector.Finish());
  return turns;
}

class Splitter {
 public:
  explicit Splitter(const std::vector<SwayStep>& steps) : steps_(steps) {}

  void Turn(int first, int last) { Add(first, last, true); }

  void Straight(int first, int last, int max_steps) {
    for (int i = first + 1; i <= last; ++i) {
      if (!steps_[i].after_gap) continue;
      Parts(first, i - 1, max_steps);
      first = i;
    }
    Parts(first, last, max_steps);
  }

  std::vector<Stretch> Finish() && { return std::move(stretches_); }

 private:
  void Parts(int first, int last, int max_steps) {
    const int count = last - first + 1;
    const int parts = (count + max_steps - 1) / max_steps;
    for (int part = 0; part < parts; ++part) {
      Add(first + count / parts * part, part + 1 == parts ? last : first + count / parts * (part + 1) - 1, false);
    }
  }

  void Add(int first, int last, bool turning) {
    Stretch stretch{first, last, turning, steps_[first].after_gap};
    for (int i = first; i <= last; ++i) {
      stretch.angle += steps_[i].psi;
      stretch.length += steps_[i].length;
    }
    stretch.middle = length_ + 0.5 * stretch.length;
    length_ += stretch.length;
    stretches_.push_back(stretch);
  }

  const std::vector<SwayStep>& steps_;
  std::vector<Stretch> stretches_;
  double length_ = 0;
};

}  // namespace

void StretchOptions::Check() const {
  turns.Check();
  if (max_straight_steps < 1) throw InputError("stretches.max_straight_steps: has to be at least 1");
}

std::vector<Stretch> SplitIntoStretches(const std::vector<SwayStep>& steps, const StretchOptions& options) {
  options.Check();
  Splitter splitter(steps);
  int next = 0;
  for (const TurningRegion& turn : TurnsOf(steps, options.turns)) {
    splitter.Straight(next, turn.first - 1, options.max_straight_steps);
    splitter.Turn(turn.first, turn.last);
    next = turn.last + 1;
  }
  splitter.Straight(next, static_cast<int>(steps.size()) - 1, options.max_straight_steps);
  return std::move(splitter).Finish();
}

}  // namespace turnscale
