// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/association.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <string>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

constexpr double kLargestDefaultTolerance = 0.02;  // seconds

void CheckNotEmpty(const Trajectory& trajectory, const std::string& name) {
  if (trajectory.empty()) throw InputError("the " + name + " holds no poses");
}

void CheckTimes(const Trajectory& trajectory, const std::string& name) {
  CheckNotEmpty(trajectory, name);
  for (size_t i = 1; i < trajectory.size(); ++i) {
    if (!(trajectory[i].time > trajectory[i - 1].time)) {
      std::ostringstream message;
      message << "the times of the " << name << " do not increase at pose " << i << ": " << std::setprecision(12)
              << trajectory[i - 1].time << " then " << trajectory[i].time << " s";
      throw InputError(message.str());
    }
  }
}

double DefaultTolerance(const Trajectory& truth) {
  if (truth.size() < 2) return kLargestDefaultTolerance;
  std::vector<double> intervals;
  for (size_t i = 1; i < truth.size(); ++i) intervals.push_back(truth[i].time - truth[i - 1].time);
  return std::min(kLargestDefaultTolerance, 0.5 * Median(std::move(intervals)));
}

int NearestInTime(const Trajectory& trajectory, double time) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), time,
                                      [](const StampedPose& pose, double t) { return pose.time < t; });
  const auto index = after - trajectory.begin();
  if (after == trajectory.end()) return static_cast<int>(index) - 1;
  if (index == 0) return 0;
  return static_cast<int>(time - trajectory[index - 1].time <= after->time - time ? index - 1 : index);
}

}  // namespace

PosePairs AssociateByTime(const Trajectory& estimate, const Trajectory& truth, const AssociationOptions& options) {
  CheckTimes(estimate, "estimate");
  CheckTimes(truth, "ground truth");
  const double tolerance = options.tolerance.value_or(DefaultTolerance(truth));
  PosePairs pairs;
  for (size_t i = 0; i < estimate.size(); ++i) {
    const int j = NearestInTime(truth, estimate[i].time);
    const double difference = std::abs(truth[j].time - estimate[i].time);
    if (difference > tolerance) continue;
    const PosePair pair{static_cast<int>(i), j, estimate[i].time, estimate[i].world_from_camera,
                        truth[j].world_from_camera};
    if (pairs.empty() || pairs.back().truth_index != j) {
      pairs.push_back(pair);
    } else if (difference < std::abs(truth[j].time - pairs.back().time)) {
      pairs.back() = pair;
    }
  }
  if (pairs.empty()) {
    std::ostringstream message;
    message << std::setprecision(12) << "no pose of the estimate (" << estimate.front().time << " to "
            << estimate.back().time << " s) is within " << tolerance << " s of one of the ground truth ("
            << truth.front().time << " to " << truth.back().time
            << " s); if they have other clocks, give the times of the ground truth (--timestamps)";
    throw InputError(message.str());
  }
  return pairs;
}

CommonPoses PosesInCommonTime(const Trajectory& estimate, const Trajectory& truth) {
  if (estimate.empty() || truth.empty()) return {};
  const double from = std::max(estimate.front().time, truth.front().time);
  const double to = std::min(estimate.back().time, truth.back().time);
  const auto count = [&](const Trajectory& trajectory) {
    return static_cast<int>(std::count_if(trajectory.begin(), trajectory.end(), [&](const StampedPose& pose) {
      return pose.time >= from && pose.time <= to;
    }));
  };
  return {count(estimate), count(truth)};
}

PosePairs AssociateByFrame(const Trajectory& estimate, const Trajectory& truth) {
  CheckNotEmpty(estimate, "estimate");
  CheckNotEmpty(truth, "ground truth");
  if (estimate.size() != truth.size()) {
    throw InputError("the estimate has " + std::to_string(estimate.size()) + " poses and the ground truth " +
                     std::to_string(truth.size()) +
                     ": without timestamps in both, they can only be associated by index");
  }
  PosePairs pairs;
  for (size_t i = 0; i < estimate.size(); ++i) {
    pairs.push_back({static_cast<int>(i), static_cast<int>(i), estimate[i].time, estimate[i].world_from_camera,
                     truth[i].world_from_camera});
  }
  return pairs;
}

double TruePathLength(const PosePairs& pairs) {
  double length = 0;
  for (size_t i = 1; i < pairs.size(); ++i) {
    length += (pairs[i].truth.translation - pairs[i - 1].truth.translation).norm();
  }
  return length;
}

double EstimatedPathLength(const PosePairs& pairs) {
  double length = 0;
  for (size_t i = 1; i < pairs.size(); ++i) {
    length += (pairs[i].estimate.translation - pairs[i - 1].estimate.translation).norm();
  }
  return length;
}

}  // namespace turnscale
