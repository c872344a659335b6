// SPDX-License-Identifier: MIT
#include "turnscale/rescale/rescale.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "turnscale/base/check_part.h"
#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/calibration/calibration.h"
#include "turnscale/calibration/camera_axes.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/geometry/angle.h"
#include "turnscale/rescale/pose_direction.h"
#include "turnscale/scale/live_scale.h"
#include "turnscale/scale/scale_track.h"

namespace turnscale {
namespace {

constexpr std::string_view kGivenRotationDisagrees =
    "with this camera rotation most of the path goes sideways, up, down or backwards; let the rotation be estimated "
    "(--camera-rotation auto)";

// Standard deviation of the yaw of a Q that is only the mean direction of travel, which is off in a drive that turns
// one way, rad.
constexpr double kUnobservedYawSigma = 5.0 / kDegreesPerRadian;

// The calibration's steps are as long as the car drives in a certain time.
Trajectory AtUsualRate(Trajectory trajectory) {
  constexpr double kInterval = 0.1;
  for (std::size_t i = 0; i < trajectory.size(); ++i) trajectory[i].time = kInterval * static_cast<double>(i);
  return trajectory;
}

std::vector<Trajectory> CutAtGaps(const Trajectory& trajectory, const std::vector<int>& gaps) {
  std::vector<Trajectory> pieces(1);
  auto gap = gaps.begin();
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (gap != gaps.end() && *gap == static_cast<int>(i)) {
      pieces.emplace_back();
      ++gap;
    }
    pieces.back().push_back(trajectory[i]);
  }
  return pieces;
}

// Gaps, and the poses between which the camera has turned too far for a step.
std::vector<int> GapsAndHoles(const Trajectory& trajectory, bool timed, const VehicleStepOptions& options,
                              std::vector<int> gaps) {
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const std::optional<double> seconds =
        timed ? std::optional(trajectory[i].time - trajectory[i - 1].time) : std::nullopt;
    const Eigen::Quaterniond turn =
        trajectory[i - 1].world_from_camera.rotation.conjugate() * trajectory[i].world_from_camera.rotation;
    if (AreFarApart(seconds, RotationAngle(turn), options)) gaps.push_back(static_cast<int>(i));
  }
  std::ranges::sort(gaps);
  gaps.erase(std::unique(gaps.begin(), gaps.end()), gaps.end());
  return gaps;
}

Eigen::Quaterniond Upright(const std::vector<CameraStep>& steps) {
  Eigen::Vector3d forward = Eigen::Vector3d::Zero();
  for (const CameraStep& step : steps) forward += step.frames * step.previous_from_current.translation;
  return RotationFromForwardAndDown(forward, Eigen::Vector3d::UnitY());
}

void CheckTrajectory(const Trajectory& trajectory, bool timed, const std::vector<PathGap>& gaps) {
  if (trajectory.size() < 2) throw InputError("the trajectory has fewer than two poses");
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (!trajectory[i].world_from_camera.IsFinite()) throw InputError("pose " + std::to_string(i) + " is not finite");
    if (timed && i > 0 && !(trajectory[i].time > trajectory[i - 1].time)) {
      throw InputError("the time of pose " + std::to_string(i) + " does not come after the one before");
    }
  }
  int last = 0;
  for (const PathGap& gap : gaps) {
    if (gap.pose <= last || gap.pose >= static_cast<int>(trajectory.size())) {
      throw InputError("gaps: " + std::to_string(gap.pose) + " is not a pose after the first, or out of order");
    }
    if (!(gap.sigma > 0)) throw InputError("gaps: sigma has to be positive");
    last = gap.pose;
  }
}

void CheckHeights(const std::vector<PathHeight>& heights) {
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const PathHeight& height = heights[i];
    if (!(height.height > 0 && std::isfinite(height.height)))
      throw InputError("height " + std::to_string(i) + " is not positive");
    if (!(height.sigma > 0 && std::isfinite(height.sigma)))
      throw InputError("the sigma of height " + std::to_string(i) + " is not positive");
    if (!std::isfinite(height.time) || (i > 0 && !(height.time > heights[i - 1].time)))
      throw InputError("the time of height " + std::to_string(i) + " does not come after the one before");
  }
}

// Each step has the heights after its first pose and up to its last one.
void SetHeights(const std::vector<PathHeight>& heights, const Trajectory& trajectory, std::vector<VehicleStep>& steps) {
  auto height = heights.begin();
  for (VehicleStep& step : steps) {
    StepHeight mean;
    while (height != heights.end() && height->time <= trajectory[step.first].time) ++height;
    for (; height != heights.end() && height->time <= trajectory[step.last].time; ++height)
      mean.Add(height->height, height->sigma);
    if (!step.after_gap && step.usable) mean.SetOn(step);
  }
}

CarPrior CarFor(const RescaleOptions& options, double yaw_sigma) {
  CarPrior car = options.car;
  car.yaw_sigma = yaw_sigma;
  if (options.timed || car.is_rigid()) return car;
  car.side_slip = car.side_slip_sigma = 0;
  car.lever_arm *= 1 - options.untimed_slip;
  car.lever_arm_sigma = std::min(std::hypot(car.lever_arm_sigma, options.untimed_slip_sigma * options.car.lever_arm),
                                 kMostLengthSigma * car.lever_arm);
  return car;
}

ScaleEstimatorOptions EstimatorFor(const RescaleOptions& options) {
  ScaleEstimatorOptions estimator = options.estimator;
  // A trace of drift keeps the smoother's covariances regular.
  constexpr double kNoDrift = 1e-5;
  if (!options.drifting) estimator.drift = {kNoDrift, 0};
  return estimator;
}

// What poses that are too far apart have to do with a scale that could not be estimated.
enum class SparsePoses { kNothing, kMayContribute, kExplainIt };

struct NoScale {
  std::string reason;
  SparsePoses sparse = SparsePoses::kExplainIt;
};

// Returns why there is none.
std::optional<NoScale> FindMount(const RescaleOptions& options, const Trajectory& trajectory,
                                 const std::vector<PathGap>& gaps, RescaleResult& result) {
  std::vector<int> first_poses;
  for (const PathGap& gap : gaps) first_poses.push_back(gap.pose);
  result.yaw_sigma = options.car.yaw_sigma;
  if (AreInverse(CutAtGaps(trajectory, first_poses))) return NoScale{std::string(kInversePoses), SparsePoses::kNothing};
  if (options.vehicle_from_camera) {
    result.vehicle_from_camera = *options.vehicle_from_camera;
    return std::nullopt;
  }
  try {
    const MountFromPath mount = FindCameraMount(trajectory, options.timed, first_poses, options.steps);
    result.vehicle_from_camera = mount.vehicle_from_camera;
    result.yaw_sigma = mount.yaw_sigma ? PriorYawSigma(*mount.yaw_sigma, options.car.yaw_sigma)
                                       : std::max(options.car.yaw_sigma, kUnobservedYawSigma);
    return std::nullopt;
  } catch (const InputError& error) {
    return NoScale{error.what()};
  }
}

// Most of the way goes along the car's axis, and it leads forward in all. A step counts by its length, as standing is
// many short steps in any direction, but at most by the usual one, as a jump is long.
bool GoesForward(const std::vector<VehicleStep>& steps) {
  std::vector<std::pair<double, double>> lengths;
  for (const VehicleStep& step : steps)
    if (step.driven() > 0) lengths.emplace_back(step.motion.step, step.motion.step);
  const double usual = WeightedMedian(std::move(lengths));
  double moving = 0;
  double along = 0;
  double way = 0;
  for (const VehicleStep& step : steps) {
    if (step.after_gap || !(step.motion.step > 0)) continue;
    moving += std::min(step.motion.step, usual);
    if (!step.usable) continue;
    along += std::min(step.motion.step, usual);
    way += step.forward();
  }
  return along > 0 && 2 * along >= moving && way >= 0;
}

// What the filter knew at each pose.
void Filter(const RescaleOptions& options, RescaleResult& result) {
  LiveScale live(CarFor(options, result.yaw_sigma), EstimatorFor(options));
  for (const VehicleStep& step : result.steps) {
    live.Add(step);
    const std::optional<LiveReading>& now = live.Now();
    for (int i = step.first + 1; now && i <= step.last; ++i) {
      result.poses[i].filtered_metres_per_unit = now->belief.metres_per_unit();
      result.poses[i].filtered_sigma = now->belief.sigma();
    }
  }
}

// Mean speed over up to a second on the side of pose `from` where `end` is, m/s; nothing without another pose there.
std::optional<double> SpeedBeside(const Trajectory& metric, int from, int end) {
  constexpr double kSeconds = 1;
  const int direction = end > from ? 1 : -1;
  int last = from;
  while (last != end && std::abs(metric[last].time - metric[from].time) < kSeconds) last += direction;
  const double seconds = std::abs(metric[last].time - metric[from].time);
  if (!(seconds > 0)) return std::nullopt;
  return (metric[last].world_from_camera.translation - metric[from].world_from_camera.translation).norm() / seconds;
}

// The way across a gap was not measured: it has the unit of the map before it, of the one after it, or neither. Here it
// is as long as at the mean of the speeds before and after it.
void CrossGapsAtMeanSpeed(const std::vector<PathGap>& gaps, Trajectory& metric) {
  std::vector<Eigen::Vector3d> shifts(metric.size(), Eigen::Vector3d::Zero());  // of all poses from this one on
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    const int after = gaps[i].pose;
    const int begin = i == 0 ? 0 : gaps[i - 1].pose;
    const int end = i + 1 < gaps.size() ? gaps[i + 1].pose : static_cast<int>(metric.size());
    const std::optional<double> speed_before = SpeedBeside(metric, after - 1, begin);
    const std::optional<double> speed_after = SpeedBeside(metric, after, end - 1);
    const Eigen::Vector3d way =
        metric[after].world_from_camera.translation - metric[after - 1].world_from_camera.translation;
    if (!speed_before || !speed_after || !(way.norm() > 0)) continue;
    const double length = 0.5 * (*speed_before + *speed_after) * (metric[after].time - metric[after - 1].time);
    shifts[after] = (length / way.norm() - 1) * way;
  }
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < metric.size(); ++k) {
    shift += shifts[k];
    metric[k].world_from_camera.translation += shift;
  }
}

void BringToMetres(const Trajectory& trajectory, RescaleResult& result) {
  std::vector<Eigen::Vector3d> positions;
  for (const StampedPose& pose : trajectory) positions.push_back(pose.world_from_camera.translation);
  const std::vector<PoseScale> scales = ScaleTrack(static_cast<int>(trajectory.size()), result.steps, *result.estimate);
  positions = MetricPositions(positions, scales);
  result.metric = trajectory;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    result.metric[i].world_from_camera.translation = positions[i];
    result.poses.push_back({scales[i].metres_per_unit, scales[i].sigma, scales[i].from_road});
  }
  for (const VehicleStep& step : result.steps) result.length += step.driven() * scales[step.last].metres_per_unit;
}

// What is wrong where the car mostly turns between poses that are too far apart: then no turn can be read, and other
// reasons why there is no scale mislead. Empty if it does not.
std::string WhyTooSparse(const RescaleOptions& options, const Trajectory& trajectory,
                         const std::vector<PathGap>& gaps) {
  constexpr double kMostShare = 0.5;
  double turned = 0;
  double turned_unseen = 0;  // between poses that are too far apart
  std::vector<double> intervals;
  auto gap = gaps.begin();
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    if (gap != gaps.end() && gap->pose == static_cast<int>(i)) {
      ++gap;
      continue;
    }
    const double interval = trajectory[i].time - trajectory[i - 1].time;
    const double angle = RotationAngle(trajectory[i - 1].world_from_camera.rotation.conjugate() *
                                       trajectory[i].world_from_camera.rotation);
    turned += angle;
    if (!AreFarApart(options.timed ? std::optional(interval) : std::nullopt, angle, options.steps)) continue;
    turned_unseen += angle;
    intervals.push_back(interval);
  }
  if (intervals.empty() || turned_unseen < options.estimator.segments.turns.min_region_angle ||
      turned_unseen < kMostShare * turned)
    return "";
  const double tenths = std::round(10 * Median(std::move(intervals)));
  return "in turns the poses are too far apart" +
         (options.timed ? " (median interval " + NumberText(tenths / 10) + " s)" : std::string()) +
         "; give the poses of more frames";
}

// Returns why there is no scale.
std::optional<NoScale> EstimateScaleOf(const RescaleOptions& options, const Trajectory& trajectory,
                                       const std::vector<PathGap>& gaps, const std::vector<PathHeight>& heights,
                                       RescaleResult& result) {
  if (std::optional<NoScale> none = FindMount(options, trajectory, gaps, result)) return none;
  Trajectory path = trajectory;
  for (StampedPose& pose : path)
    pose.world_from_camera.rotation = pose.world_from_camera.rotation * result.vehicle_from_camera.conjugate();
  result.steps = CutIntoSteps(path, gaps, options.timed, options.steps);
  SetHeights(heights, trajectory, result.steps);
  if (!GoesForward(result.steps)) {
    if (options.vehicle_from_camera) return NoScale{std::string(kGivenRotationDisagrees), SparsePoses::kMayContribute};
    return NoScale{
        "most of the path goes sideways, up, down or backwards, also with the estimated camera rotation; check that "
        "the poses are world_from_camera, not their inverse"};
  }
  ScaleEstimateResult estimate = EstimateScale(result.steps, CarFor(options, result.yaw_sigma), EstimatorFor(options));
  if (!estimate.estimate) return NoScale{std::move(estimate.reason)};
  result.estimate = std::move(estimate.estimate);
  result.observable = true;
  return std::nullopt;
}

std::string ReasonOf(const NoScale& none, const std::string& sparse) {
  if (sparse.empty() || none.sparse == SparsePoses::kNothing) return none.reason;
  return none.sparse == SparsePoses::kExplainIt ? sparse : none.reason + "; " + sparse;
}

}  // namespace

MountFromPath FindCameraMount(const Trajectory& trajectory, bool timed, const std::vector<int>& gaps,
                              const VehicleStepOptions& options) {
  std::vector<Trajectory> pieces =
      CutAtGaps(timed ? trajectory : AtUsualRate(trajectory), GapsAndHoles(trajectory, timed, options, gaps));
  const AxisConvention axes = FindAxisConvention(StepsAlong(pieces));
  for (Trajectory& piece : pieces) piece = InCameraAxes(std::move(piece), axes);
  const Eigen::Quaterniond body_from_camera = BodyFromCamera(axes);
  const std::vector<CameraStep> steps = StepsAlong(pieces);
  const Calibration calibration = Calibrate(steps);
  MountFromPath mount;
  if (calibration.observable) mount.yaw_sigma = calibration.sigma.yaw;
  mount.vehicle_from_camera =
      (calibration.observable ? calibration.vehicle_from_camera : Upright(steps)) * body_from_camera.conjugate();
  return mount;
}

void RescaleOptions::Check() const {
  car.Check();
  CheckPart("steps.", steps);
  CheckPart("estimator.", estimator);
  if (!(untimed_slip >= 0 && untimed_slip < 1)) throw InputError("untimed_slip: has to be from 0 to below 1");
  if (!(untimed_slip_sigma >= 0 && untimed_slip_sigma < 1))
    throw InputError("untimed_slip_sigma: has to be from 0 to below 1");
}

RescaleResult RescaleTrajectory(const RescaleOptions& options, const Trajectory& trajectory,
                                const std::vector<PathGap>& gaps, const std::vector<PathHeight>& heights) {
  options.Check();
  CheckTrajectory(trajectory, options.timed, gaps);
  if (!heights.empty() && !options.timed)
    throw InputError("heights: the poses have no times, by which heights find their steps; give times in seconds");
  CheckHeights(heights);
  RescaleResult result;
  if (options.timed) result.assumed_slip = {options.car.side_slip, options.car.side_slip_sigma};
  if (const auto none = EstimateScaleOf(options, trajectory, gaps, heights, result)) {
    result.reason = ReasonOf(*none, WhyTooSparse(options, trajectory, gaps));
    return result;
  }
  BringToMetres(trajectory, result);
  if (options.timed) CrossGapsAtMeanSpeed(gaps, result.metric);
  for (const PathGap& gap : gaps)
    result.gap_length += (result.metric[gap.pose].world_from_camera.translation -
                          result.metric[gap.pose - 1].world_from_camera.translation)
                             .norm();
  Filter(options, result);
  return result;
}

}  // namespace turnscale
