// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/evaluation.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "turnscale/base/error.h"
#include "turnscale/geometry/path_length.h"

namespace turnscale {
namespace {

PositionErrors Measure(const PosePairs& pairs, const Similarity& truth_from_estimate) {
  std::vector<double> distances;
  for (const PosePair& pair : pairs) {
    distances.push_back((truth_from_estimate * pair.estimate.translation - pair.truth.translation).norm());
  }
  return {truth_from_estimate, Summarize(std::move(distances))};
}

constexpr double kShortestDrive = 1.0;  // metres

std::vector<double> LengthsFor(double path_length) {
  double unit = 100;
  while (unit > 0.1 * kShortestDrive && unit >= path_length) unit /= 10;
  std::vector<double> lengths;
  for (int i = 1; i <= 8; ++i) lengths.push_back(i * unit);
  return lengths;
}

constexpr double kSameTime = 1e-3;  // seconds; a table may print fewer digits than a trajectory

RigidTransform Motion(const RigidTransform& world_from_first, const RigidTransform& world_from_last) {
  return world_from_first.inverse() * world_from_last;
}

double TurningAngle(const RigidTransform& motion, const Eigen::Quaterniond& vehicle_from_camera) {
  return TwistAboutY(vehicle_from_camera * motion.rotation * vehicle_from_camera.conjugate());
}

ScaledErrors MeasureAtScale(const PosePairs& pairs, const std::vector<Step>& steps, double scale,
                            const EvaluationOptions& options) {
  ScaledErrors errors;
  errors.scale = scale;
  errors.segments = MeasureSegments(pairs, scale, options.segments);
  errors.path_length_error = scale * EstimatedPathLength(pairs) / TruePathLength(pairs) - 1;
  errors.all_steps = MeasureSteps(pairs, steps, false, scale, options.steps);
  errors.turning_steps = MeasureSteps(pairs, steps, true, scale, options.steps);
  return errors;
}

}  // namespace

ErrorStatistics Summarize(std::vector<double> errors) {
  ErrorStatistics statistics;
  if (errors.empty()) return statistics;
  double squares = 0;
  for (double& error : errors) {
    error = std::abs(error);
    squares += error * error;
  }
  std::sort(errors.begin(), errors.end());
  const size_t middle = errors.size() / 2;
  statistics.count = static_cast<int>(errors.size());
  statistics.rms = std::sqrt(squares / static_cast<double>(errors.size()));
  statistics.median = errors.size() % 2 == 1 ? errors[middle] : 0.5 * (errors[middle - 1] + errors[middle]);
  statistics.max = errors.back();
  return statistics;
}

PositionErrors MeasurePositionsFromFirstPose(const PosePairs& pairs) {
  if (pairs.empty()) throw InputError("no paired poses to compare");
  const RigidTransform truth_from_estimate = pairs.front().truth * pairs.front().estimate.inverse();
  return Measure(pairs, {1.0, truth_from_estimate.rotation, truth_from_estimate.translation});
}

PositionErrors MeasureAlignedPositions(const PosePairs& pairs, AlignmentModel model) {
  std::vector<Eigen::Vector3d> estimate;
  std::vector<Eigen::Vector3d> truth;
  for (const PosePair& pair : pairs) {
    estimate.push_back(pair.estimate.translation);
    truth.push_back(pair.truth.translation);
  }
  return Measure(pairs, AlignPoints(estimate, truth, model));
}

SegmentErrors MeasureSegments(const PosePairs& pairs, double scale, const SegmentOptions& options) {
  const std::vector<double> travel =
      LengthsAlong(pairs, [](const PosePair& pair) -> const Eigen::Vector3d& { return pair.truth.translation; });
  const double whole = travel.empty() ? 0 : travel.back();
  std::vector<double> lengths = options.lengths.empty() ? LengthsFor(whole) : options.lengths;
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
  if (errors.segments == 0 || whole < kShortestDrive) {
    std::ostringstream message;
    message << "the ground truth has a path length of " << whole << " m over " << pairs.size()
            << " associated poses: too short to evaluate";
    throw InputError(message.str());
  }
  errors.translation /= errors.segments;
  errors.rotation /= errors.segments;
  return errors;
}

std::vector<Step> StepsAlongPath(const PosePairs& pairs, const StepErrorOptions& options) {
  std::vector<Step> steps;
  int first = 0;
  double travel = 0;
  for (int i = 1; i < static_cast<int>(pairs.size()); ++i) {
    travel += (pairs[i].truth.translation - pairs[i - 1].truth.translation).norm();
    if (travel < options.length) continue;
    const double psi = TurningAngle(Motion(pairs[first].truth, pairs[i].truth), options.vehicle_from_camera);
    steps.push_back({first, i, std::abs(psi) > options.turning_angle});
    first = i;
    travel = 0;
  }
  return steps;
}

std::vector<Step> StepsBetweenKeyframes(const PosePairs& pairs, const std::vector<KeyframeRow>& keyframes,
                                        KeyframeKey key) {
  std::vector<Step> steps;
  int previous = -1;
  for (const KeyframeRow& row : keyframes) {
    const double wanted = key == KeyframeKey::kTime ? row.time : row.frame;
    const double tolerance = key == KeyframeKey::kTime ? kSameTime : 0.0;
    const auto found = std::lower_bound(pairs.begin(), pairs.end(), wanted - tolerance,
                                        [](const PosePair& pair, double value) { return pair.time < value; });
    if (found == pairs.end() || found->time > wanted + tolerance) continue;
    const auto place = static_cast<int>(found - pairs.begin());
    if (previous >= 0 && place > previous) steps.push_back({previous, place, row.turning});
    previous = place;
  }
  return steps;
}

StepErrors MeasureSteps(const PosePairs& pairs, const std::vector<Step>& steps, bool turning_only, double scale,
                        const StepErrorOptions& options) {
  std::vector<double> scale_errors;
  std::vector<double> psi_errors;
  for (const Step& step : steps) {
    if (turning_only && !step.turning) continue;
    const RigidTransform motion = Motion(pairs[step.first].estimate, pairs[step.last].estimate);
    const RigidTransform true_motion = Motion(pairs[step.first].truth, pairs[step.last].truth);
    psi_errors.push_back(std::remainder(
        TurningAngle(motion, options.vehicle_from_camera) - TurningAngle(true_motion, options.vehicle_from_camera),
        2 * M_PI));
    const double true_length = true_motion.translation.norm();
    if (true_length < options.shortest_length) continue;
    scale_errors.push_back((scale * motion.translation.norm() - true_length) / true_length);
  }
  return {Summarize(std::move(scale_errors)), Summarize(std::move(psi_errors))};
}

Evaluation Evaluate(const PosePairs& pairs, const std::vector<Step>& steps, const EvaluationOptions& options) {
  Evaluation evaluation;
  evaluation.poses = static_cast<int>(pairs.size());
  evaluation.true_path_length = TruePathLength(pairs);
  evaluation.estimated_path_length = EstimatedPathLength(pairs);
  evaluation.from_first_pose = MeasurePositionsFromFirstPose(pairs);
  evaluation.as_given = MeasureAtScale(pairs, steps, 1.0, options);
  try {
    evaluation.rigid = MeasureAlignedPositions(pairs, AlignmentModel::kRigid);
    evaluation.similarity = MeasureAlignedPositions(pairs, AlignmentModel::kSimilarity);
    evaluation.rescaled = MeasureAtScale(pairs, steps, evaluation.similarity->truth_from_estimate.scale, options);
  } catch (const InputError& error) {
    // A dead straight drive still has a length and a scale to judge.
    evaluation.alignment_problem = error.what();
  }
  return evaluation;
}

}  // namespace turnscale
