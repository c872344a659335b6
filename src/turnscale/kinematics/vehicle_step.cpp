// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/vehicle_step.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <span>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/base/square.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Steps to either side that show what is an ordinary speed there.
constexpr std::ptrdiff_t kNeighbours = 5;
constexpr std::size_t kFewestPaces = 4;
// Of a step whose squared speed is weighted by turning, rad.
constexpr double kLeastTurn = 0.005;
// Of max_pose_turn, where times are unknown.
constexpr double kUntimedTurns = 3;
// Of squared speeds within a step.
constexpr double kMostRatio = 4;

double Pace(const VehicleStep& step) { return step.duration > 0 ? step.speed() : step.motion.step; }

// Steps between two losses of tracking.
void MarkJumps(std::span<VehicleStep> steps, double max_speed_ratio) {
  const auto count = static_cast<std::ptrdiff_t>(steps.size());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    std::vector<double> paces;
    for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(0, i - kNeighbours); k <= std::min(count - 1, i + kNeighbours);
         ++k)
      if (k != i) paces.push_back(Pace(steps[k]));
    if (paces.size() < kFewestPaces) continue;
    if (Pace(steps[i]) > max_speed_ratio * Quantile(std::move(paces), 0.8)) steps[i].usable = false;
  }
}

}  // namespace

double VehicleStep::lateral() const { return motion.step * std::sin(motion.theta - 0.5 * motion.psi - heading_offset); }

double VehicleStep::forward() const { return motion.step * std::cos(motion.theta - 0.5 * motion.psi - heading_offset); }

double VehicleStep::swing() const { return 2.0 * std::sin(0.5 * motion.psi); }

double VehicleStep::signed_square_speed() const {
  return std::copysign(speed() * speed() * square_speed_ratio, forward());
}

double VehicleStep::signed_speed() const { return std::copysign(speed() * std::sqrt(square_speed_ratio), forward()); }

void VehicleStepOptions::Check() const {
  if (!(angle >= 0 && angle < 0.5)) throw InputError("angle_deg: has to be from 0 to below 28.6");
  if (!(max_duration > 0)) throw InputError("max_duration: has to be positive");
  if (max_poses < 1) throw InputError("max_poses: has to be at least 1");
  if (!(max_pose_interval > 0)) throw InputError("max_pose_interval: has to be positive");
  if (!(max_pose_turn > 0)) throw InputError("max_pose_turn_deg: has to be positive");
  if (!(max_isolated_turn > 0)) throw InputError("max_isolated_turn_deg: has to be positive");
  if (!(max_speed_ratio > 1)) throw InputError("max_speed_ratio: has to be above 1");
  if (!(max_direction > 0)) throw InputError("max_direction_deg: has to be positive");
}

bool AreFarApart(std::optional<double> seconds, double turned, const VehicleStepOptions& options) {
  if (!seconds) return turned > kUntimedTurns * options.max_pose_turn;
  return *seconds > options.max_pose_interval && turned > options.max_pose_turn;
}

VehicleStep LevelStep(const RigidTransform& previous_from_current, const Eigen::Quaterniond& vehicle_from_camera,
                      double dt, const VehicleStepOptions& options) {
  const Eigen::Quaterniond half_back = RotationFromVector(-0.5 * VectorFromRotation(previous_from_current.rotation));
  const Eigen::Vector3d travel = vehicle_from_camera * (half_back * previous_from_current.translation);
  VehicleStep step;
  step.duration = dt;
  // Of the line of travel: in reverse, levelling the direction itself would turn the axes over.
  const double way = std::copysign(1.0, travel.z());
  const double pitch = std::atan2(way * travel.y(), way * travel.z());
  const Eigen::Quaterniond level_from_camera = RotationFromVector({pitch, 0, 0}) * vehicle_from_camera;
  step.motion = TurningMotionOf(previous_from_current, level_from_camera);
  step.roll = (level_from_camera * VectorFromRotation(previous_from_current.rotation)).z();
  const double length = travel.norm();
  // The kinematics hold in reverse as well.
  step.usable = length > 0 && std::abs(travel.z()) >= std::cos(options.max_direction) * length;
  return step;
}

std::vector<VehicleStep> StepBuilder::Add(const StampedPose& pose, std::optional<double> gap_sigma) {
  const int index = poses_++;
  if (gap_sigma) gap_sigma_ = gap_sigma;
  if (!pose.world_from_camera.IsFinite()) return {};
  const std::optional<double> gap = std::exchange(gap_sigma_, std::nullopt);
  std::vector<VehicleStep> ended;
  if (!under_way_) {
    under_way_ = BeginAt(pose, index);
  } else if (gap) {
    if (under_way_->first < index - 1) ended.push_back(StepOf(*under_way_, index - 1));
    VehicleStep& across = ended.emplace_back();
    across.first = index - 1;
    across.last = index;
    across.usable = false;
    across.after_gap = true;
    across.gap_sigma = *gap;
    if (timed_) across.duration = pose.time - under_way_->end.time;
    under_way_ = BeginAt(pose, index);
  } else {
    GoOn(pose, *under_way_);
    const VehicleStep step = StepOf(*under_way_, index);
    if (!IsLongEnough(step)) return {};
    ended.push_back(step);
    under_way_ = BeginAt(pose, index);
  }
  return ended;
}

void StepBuilder::TurnAxes(const Eigen::Quaterniond& old_from_new) {
  if (!under_way_) return;
  for (StampedPose* pose : {&under_way_->begin, &under_way_->end})
    pose->world_from_camera.rotation = pose->world_from_camera.rotation * old_from_new;
}

std::optional<VehicleStep> StepBuilder::Finish() {
  const int last = poses_ - 1;
  if (!under_way_ || last <= under_way_->first) return std::nullopt;
  const VehicleStep step = StepOf(*under_way_, last);
  under_way_ = BeginAt(under_way_->end, last);
  return step;
}

bool StepBuilder::AreSparse(double seconds, double turned) const {
  constexpr double kIsolated = 2.5;  // times the shortest of the intervals before
  if (AreFarApart(timed_ ? std::optional(seconds) : std::nullopt, turned, options_)) return true;
  return timed_ && !intervals_.empty() && seconds > options_.max_pose_interval &&
         seconds > kIsolated * *std::ranges::min_element(intervals_) && turned > options_.max_isolated_turn;
}

void StepBuilder::GoOn(const StampedPose& pose, StepUnderWay& step) {
  const double heading = Measure(step.begin, pose).motion.psi;
  const double travel = (pose.world_from_camera.translation - step.end.world_from_camera.translation).norm();
  const double duration = pose.time - step.end.time;
  step.heading_integral += travel * 0.5 * (step.heading + heading);
  step.travel += travel;
  if (timed_ && duration > 0) step.square_speed_integral += (heading - step.heading) * Square(travel / duration);
  const double turned = std::abs(heading - step.heading);
  step.dense = step.dense && !AreSparse(duration, turned);
  constexpr std::size_t kIntervals = 8;
  intervals_.push_back(duration);
  if (intervals_.size() > kIntervals) intervals_.pop_front();
  step.heading = heading;
  step.end = pose;
}

VehicleStep StepBuilder::Measure(const StampedPose& from, const StampedPose& to) const {
  return LevelStep(from.world_from_camera.inverse() * to.world_from_camera, Eigen::Quaterniond::Identity(),
                   timed_ ? to.time - from.time : 0, options_);
}

VehicleStep StepBuilder::StepOf(const StepUnderWay& under_way, int last) const {
  // In axes that may have turned since `end` was taken.
  VehicleStep step = Measure(under_way.begin, under_way.end);
  step.first = under_way.first;
  step.last = last;
  step.dense = under_way.dense;
  const double heading = step.motion.psi;
  if (under_way.travel > 0) step.heading_offset = under_way.heading_integral / under_way.travel - 0.5 * heading;
  // A heading that hardly changes is noise.
  if (std::abs(heading) > kLeastTurn && step.speed() > 0)
    step.square_speed_ratio =
        std::clamp(under_way.square_speed_integral / (heading * Square(step.speed())), 1 / kMostRatio, kMostRatio);
  return step;
}

bool StepBuilder::IsLongEnough(const VehicleStep& step) const {
  // Half a period of the fastest cameras: times are rounded.
  constexpr double kTimeTolerance = 0.004;
  if (std::abs(step.motion.psi) >= options_.angle) return true;
  return timed_ ? step.duration >= options_.max_duration - kTimeTolerance
                : step.last - step.first >= options_.max_poses;
}

std::vector<VehicleStep> CutIntoSteps(const Trajectory& path, const std::vector<PathGap>& gaps, bool timed,
                                      const VehicleStepOptions& options) {
  options.Check();
  StepBuilder builder(options, timed);
  std::vector<VehicleStep> steps;
  auto gap = gaps.begin();
  for (int i = 0; i < static_cast<int>(path.size()); ++i) {
    std::optional<double> gap_sigma;
    if (gap != gaps.end() && gap->pose == i) gap_sigma = (gap++)->sigma;
    std::ranges::move(builder.Add(path[i], gap_sigma), std::back_inserter(steps));
  }
  if (const std::optional<VehicleStep> rest = builder.Finish()) steps.push_back(*rest);
  // Units of length differ across a gap.
  auto piece = steps.begin();
  while (piece != steps.end()) {
    const auto end = std::find_if(piece + 1, steps.end(), [](const VehicleStep& step) { return step.after_gap; });
    MarkJumps({piece->after_gap ? piece + 1 : piece, end}, options.max_speed_ratio);
    piece = end;
  }
  return steps;
}

}  // namespace turnscale
