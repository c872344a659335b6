// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/segment_error.h"

#include <algorithm>
#include <sstream>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kShortestDrive = 1.0;  // metres

std::vector<double> TravelAt(const PosePairs& pairs) {
  std::vector<double> travel = {0};
  for (size_t i = 1; i < pairs.size(); ++i) {
    travel.push_back(travel.back() + (pairs[i].truth.translation - pairs[i - 1].truth.translation).norm());
  }
  return travel;
}

std::vector<double> LengthsFor(double path_length) {
  double unit = 100;
  while (unit > 0.1 * kShortestDrive && unit >= path_length) unit /= 10;
  std::vector<double> lengths;
  for (int i = 1; i <= 8; ++i) lengths.push_back(i * unit);
  return lengths;
}

}  // namespace

SegmentErrors MeasureSegments(const PosePairs& pairs, double scale, const SegmentOptions& options) {
  const std::vector<double> travel = TravelAt(pairs);
  std::vector<double> lengths = options.lengths.empty() ? LengthsFor(travel.back()) : options.lengths;
  std::sort(lengths.begin(), lengths.end());
  SegmentErrors errors;
  for (const double length : lengths) {
    SegmentLengthError sum{length};
    for (size_t first = 0; first < pairs.size(); first += static_cast<size_t>(options.start_every)) {
      const auto end = std::upper_bound(travel.begin(), travel.end(), travel[first] + length);
      if (end == travel.end()) break;
      const auto last = static_cast<size_t>(end - travel.begin());
      const RigidTransform true_motion = pairs[first].truth.inverse() * pairs[last].truth;
      RigidTransform motion = pairs[first].estimate.inverse() * pairs[last].estimate;
      motion.translation *= scale;
      const RigidTransform difference = motion.inverse() * true_motion;
      ++sum.segments;
      sum.translation += difference.translation.norm() / length;
      sum.rotation += RotationAngle(difference.rotation) / length;
    }
    if (sum.segments == 0) continue;
    errors.segments += sum.segments;
    errors.translation += sum.translation;
    errors.rotation += sum.rotation;
    sum.translation /= sum.segments;
    sum.rotation /= sum.segments;
    errors.by_length.push_back(sum);
  }
  if (errors.segments == 0 || travel.back() < kShortestDrive) {
    std::ostringstream message;
    message << "the ground truth has a path length of " << travel.back() << " m over " << pairs.size()
            << " associated poses: too short to evaluate";
    throw InputError(message.str());
  }
  errors.translation /= errors.segments;
  errors.rotation /= errors.segments;
  return errors;
}

}  // namespace turnscale
