// SPDX-License-Identifier: MIT
#include "turnscale/odometry/live_path.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "turnscale/odometry/drive_steps.h"

namespace turnscale {
namespace {

// Keyframes back to which a turn may change the live scale: on a long straight the path before it stays.
constexpr int kMostRevised = 500;

}  // namespace

void LivePath::Update(const Map& map, const std::optional<LiveReading>& now, const Change& change) {
  const bool was_known = state_ != ScaleState::kPending;
  const double scale = now ? now->belief.metres_per_unit() : 1.0;
  sigma_ = now ? now->belief.sigma() : std::numeric_limits<double>::infinity();
  state_ = now ? now->state : ScaleState::kPending;
  if (now && change.turn_ended) state_ = ScaleState::kObserved;

  const int count = CountKeyframes(map);
  std::vector<double>& scales = path_.metres_per_unit;
  scales.resize(count, scale);
  path_.centres.resize(count);
  int first = std::max(0, std::min(change.first, count) - 1 - movable_);
  if (was_known != now.has_value()) {
    std::ranges::fill(scales, scale);
    first = 0;
  } else if (change.reread_turn_end || state_ == ScaleState::kObserved) {
    first = std::min(first, SpreadScale(map, scale, change.reread_turn_end.value_or(count - 1)));
  }
  if (first == 0) path_.centres[0] = scales[0] * Centre(map.keyframes[0]);
  for (int k = first + 1; k < count; ++k) {
    // The bridged step is predicted, in the unit before the gap.
    const double metres_per_unit = map.keyframes[k].after_gap ? scales[k - 1] : scales[k];
    path_.centres[k] = path_.centres[k - 1] + metres_per_unit * (KnownCentre(map, k) - KnownCentre(map, k - 1));
  }
  if (change.reread_turn_end) last_turn_end_ = *change.reread_turn_end;
}

// From the end of the turn before the scale passes evenly to that of the turn under way; at a loss of tracking it
// changes at once.
int LivePath::SpreadScale(const Map& map, double scale, int last) {
  const int begin = std::max(last_turn_end_, last - kMostRevised);
  if (last <= begin) return begin;
  std::vector<double>& scales = path_.metres_per_unit;
  std::fill(scales.begin() + last, scales.end(), scale);
  int gap = last;
  while (gap > begin && !map.keyframes[gap].after_gap) --gap;
  if (gap > begin) {
    std::fill(scales.begin() + gap, scales.begin() + last, scale);
    return begin;
  }
  std::vector<double> length(last - begin + 1, 0.0);  // from `begin` on
  for (int k = begin + 1; k <= last; ++k)
    length[k - begin] = length[k - begin - 1] + (KnownCentre(map, k) - KnownCentre(map, k - 1)).norm();
  const double growth = std::log(scale / scales[begin]);
  for (int k = begin + 1; k <= last; ++k)
    scales[k] = scales[begin] * std::exp(length.back() > 0 ? growth * length[k - begin] / length.back() : growth);
  return begin;
}

}  // namespace turnscale
