// SPDX-License-Identifier: MIT
#include "turnscale/rescale/pose_scale.h"

#include <algorithm>
#include <cmath>

namespace turnscale {
namespace {

// Where a pose lies among the stretches.
struct Place {
  std::size_t before = 0;  // stretch
  std::size_t after = 0;
  double share = 0;       // of `after`
  std::size_t ended = 0;  // number of stretches that had ended by then
};

// Poses between two keys lie evenly between them; those behind the last key, at it.
std::vector<double> PlacesAlongPath(int poses, const std::vector<SwayStep>& steps) {
  std::vector<double> places(poses, 0);
  double length = 0;
  for (const SwayStep& step : steps) {
    for (int i = step.first + 1; i <= step.last; ++i) {
      places[i] = length + step.length * (i - step.first) / (step.last - step.first);
    }
    length += step.length;
  }
  for (int i = steps.back().last + 1; i < poses; ++i) places[i] = length;
  return places;
}

std::vector<Place> PlacesAmong(const std::vector<Stretch>& stretches, const std::vector<SwayStep>& steps,
                               const std::vector<double>& along) {
  std::vector<Place> places;
  places.reserve(along.size());
  std::size_t next = 0;  // first stretch whose middle is not passed
  std::size_t ended = 0;
  for (std::size_t i = 0; i < along.size(); ++i) {
    const auto beyond_gap = [&](const Stretch& stretch) {
      return !stretch.after_gap || static_cast<int>(i) >= steps[stretch.first].last;
    };
    const auto passed = [&](std::size_t k, double share) {
      return k < stretches.size() && beyond_gap(stretches[k]) &&
             stretches[k].middle + share * stretches[k].length <= along[i];
    };
    while (passed(next, 0)) ++next;
    while (passed(ended, 0.5)) ++ended;
    Place place{next == 0 ? 0 : next - 1, std::min(next, stretches.size() - 1), 0, ended};
    const Stretch& after = stretches[place.after];
    if (after.after_gap) {
      place.share = beyond_gap(after) ? 1 : 0;
    } else if (place.after != place.before) {
      const double before = stretches[place.before].middle;
      place.share = (along[i] - before) / (after.middle - before);
    }
    places.push_back(place);
  }
  return places;
}

double SigmaOf(const Belief& belief) { return std::sqrt(belief.covariance(kLogScale, kLogScale)); }

}  // namespace

std::vector<PoseScale> ScalePoses(int poses, const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
                                  const ScaleEstimate& estimate, double common_sigma) {
  std::size_t first_turn = 0;
  while (!stretches[first_turn].turning) ++first_turn;
  std::vector<PoseScale> scales;
  scales.reserve(poses);
  for (const Place& place : PlacesAmong(stretches, steps, PlacesAlongPath(poses, steps))) {
    const Belief& before = estimate.smoothed[place.before];
    const Belief& after = estimate.smoothed[place.after];
    const auto between = [&](double a, double b) { return (1 - place.share) * a + place.share * b; };
    PoseScale scale;
    scale.metres_per_unit = std::exp(between(before.mean[kLogScale], after.mean[kLogScale]));
    scale.own_sigma = between(SigmaOf(before), SigmaOf(after));
    scale.sigma = std::hypot(scale.own_sigma, common_sigma);
    if (place.ended > first_turn) {
      const Belief& filtered = estimate.filtered[place.ended - 1];
      scale.filtered_metres_per_unit = std::exp(filtered.mean[kLogScale]);
      scale.filtered_sigma = std::hypot(SigmaOf(filtered), common_sigma);
    }
    scales.push_back(scale);
  }
  return scales;
}

}  // namespace turnscale
