// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/geometry/angle.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {

/// The camera's motion between two poses of a path, in kinematic terms.
struct VehicleStep {
  TurningMotion motion;  ///< in the odometry's unit of length
  double duration = 0;   ///< seconds; 0 where times are unknown
  int first = 0;         ///< poses that the step leads from and to
  int last = 0;
  /// False if the step is not evaluated: its motion is unknown (across a loss of tracking), it goes sideways, is a jump
  /// or has no length.
  bool usable = true;
  /// False if two poses within the step are so far apart that the circle of (1) does not hold between them: it is
  /// driven and turned, and shows nothing of the car (VehicleStepOptions::max_pose_turn). Independent of `usable`:
  /// without times, a hole in a turn is a jump as well.
  bool dense = true;
  bool after_gap = false;  ///< across a loss of tracking: its motion is unknown
  /// Relative standard deviation by which the unit of length may have changed across the gap.
  double gap_sigma = 0;
  /// Variance of the logarithm of the unit of length along the step, due to the errors of the landmarks; at most 1, 0
  /// where it is not known.
  double unit_variance = 0;
  /// Mean of the squared speed weighted by turning, over the square of `speed()`: slip acts where the car turns.
  double square_speed_ratio = 1;
  double height = 0;        ///< of the camera above the road, odometry units; 0 where the road is not seen
  double height_sigma = 0;  ///< relative standard deviation of `height`

  /// Mean of the heading over the distance driven, less the mean of the headings at both ends, rad. 0 on the circle of
  /// (1); at the start and at the end of a turn, where the curvature changes, it is not.
  double heading_offset = 0;
  /// Rotation about the levelled forward axis, rad, leaning right positive, also in reverse. The body leans outwards in
  /// a turn and takes the camera, which is above the axis of the roll, with it.
  double roll = 0;

  /// y = length sin(theta - psi/2 - heading_offset): lateral displacement in the axes of the mean heading, odometry
  /// units. The rear axle does not move sideways there, whatever way the curvature changes within the step.
  double lateral() const;
  /// length cos(theta - psi/2 - heading_offset): distance ahead in those axes, odometry units; negative in reverse.
  double forward() const;
  /// Whether the car's kinematics can be read from it.
  bool shows_kinematics() const { return usable && dense; }
  /// Distance driven, odometry units: 0 where the step is not usable.
  double driven() const { return usable ? motion.step : 0.0; }
  /// Angle turned, rad, positive to the right: 0 where the step is not usable.
  double turned() const { return usable ? motion.psi : 0.0; }
  /// 2 sin(psi/2): the lateral displacement of a camera per metre of the lever arm (22).
  double swing() const;
  /// Odometry units per second; 0 where times are unknown.
  double speed() const { return duration > 0 ? motion.step / duration : 0.0; }
  /// Square of the speed where the step turns, (units/s)^2: negative in reverse, where the slip of the tyres has the
  /// opposite sign relative to psi.
  double signed_square_speed() const;
  /// The speed where the step turns, units/s: negative in reverse.
  double signed_speed() const;
};

/// A loss of tracking on a path.
struct PathGap {
  int pose = 0;      ///< the first pose after it
  double sigma = 0;  ///< relative standard deviation by which the unit of length may have changed across it
};

struct VehicleStepOptions {
  /// A step ends at the first pose by which the camera has turned by this much, rad (2.5 deg). Shorter steps carry more
  /// noise than signal; within longer ones the curvature changes, which the circle of (1) does not model. 0: a step
  /// from each pose to the next.
  double angle = 2.5 / kDegreesPerRadian;
  /// Or after this time, s: on straights.
  double max_duration = 0.6;
  /// Or after this many poses, where times are unknown.
  int max_poses = 6;
  /// Between two poses that are further apart than this, s, the camera may turn by max_pose_turn, rad (10 deg): where
  /// it turns more, the curvature and the speed between them are not known. Where times are unknown, by three times
  /// that.
  double max_pose_interval = 0.75;
  double max_pose_turn = 10.0 / kDegreesPerRadian;
  /// The same, rad (2 deg), between two poses that are so far apart while those before them are not: images are missing
  /// there, as likely as not where a turn begins or ends.
  double max_isolated_turn = 2.0 / kDegreesPerRadian;
  /// A step this many times as fast as four of five of the ten around it is a jump of the odometry.
  double max_speed_ratio = 3;
  /// A step that goes further off straight ahead or straight back than this is a jump, rad (60 deg).
  double max_direction = 60.0 / kDegreesPerRadian;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Whether a camera that turns by `turned` (rad) between two poses so many seconds apart (unset: unknown) shows nothing
/// of the car between them.
bool AreFarApart(std::optional<double> seconds, double turned, const VehicleStepOptions& options);

/// The step between two poses of the camera, `dt` seconds apart; `vehicle_from_camera` is the paper's Q.
///
/// The axes of Q are pitched so that the step, forward or in reverse, goes neither up nor down. A car goes along its
/// road, so each step shows the pitch of the camera, and the body's as well; Q's own pitch then does not matter.
VehicleStep LevelStep(const RigidTransform& previous_from_current, const Eigen::Quaterniond& vehicle_from_camera,
                      double dt, const VehicleStepOptions& options);

/// Cuts a path into steps, pose by pose.
class StepBuilder {
 public:
  /// `timed`: the poses' times are seconds.
  StepBuilder(const VehicleStepOptions& options, bool timed) : options_(options), timed_(timed) {}

  /// Takes the next pose, in vehicle axes: world_from_camera * camera_from_vehicle's rotation. `gap_sigma`: of a loss
  /// of tracking before it (PathGap::sigma). Gives the steps that it ends: one at most, two where a gap cuts a step
  /// short. The step leads past a pose that is not finite; a gap before such a pose is one before the next pose that
  /// is. A step that ends at a gap counts the poses passed before it as its own.
  std::vector<VehicleStep> Add(const StampedPose& pose, std::optional<double> gap_sigma = {});

  /// The vehicle's axes have changed: the poses to come are in new ones, by which the step under way is measured, too.
  void TurnAxes(const Eigen::Quaterniond& old_from_new);

  /// The path ends: what remains of it is a step, which is not usable if the car has stood still since the last one.
  std::optional<VehicleStep> Finish();

 private:
  /// What has been seen of a step that is not ended yet.
  struct StepUnderWay {
    StampedPose begin;
    StampedPose end;  ///< the latest pose that is finite
    int first = 0;    ///< index of `begin`
    // Along the poses from `begin` to `end`:
    double heading = 0;                ///< change of it, rad
    double travel = 0;                 ///< distance
    double heading_integral = 0;       ///< of `heading` over `travel`
    double square_speed_integral = 0;  ///< of the squared speed over `heading`
    bool dense = true;                 ///< VehicleStep::dense
  };

  static StepUnderWay BeginAt(const StampedPose& pose, int index) {
    return {.begin = pose, .end = pose, .first = index};
  }
  /// Whether the curvature between the latest pose and the next one, so many seconds later, is not known.
  bool AreSparse(double seconds, double turned) const;
  /// The step under way reaches the next pose.
  void GoOn(const StampedPose& pose, StepUnderWay& step);
  VehicleStep Measure(const StampedPose& from, const StampedPose& to) const;
  /// As a step that ends where it is, at the pose `last`.
  VehicleStep StepOf(const StepUnderWay& under_way, int last) const;
  bool IsLongEnough(const VehicleStep& step) const;

  VehicleStepOptions options_;
  bool timed_;
  int poses_ = 0;
  std::optional<StepUnderWay> under_way_;  ///< from the first pose on that is finite
  std::optional<double> gap_sigma_;        ///< of a gap since the latest pose that is finite
  std::deque<double> intervals_;           ///< between the latest poses, seconds
};

/// All steps of a path whose poses are in vehicle axes, jumps marked as not usable. Gaps in their order. Poses that are
/// not finite are passed over, as StepBuilder does.
std::vector<VehicleStep> CutIntoSteps(const Trajectory& path, const std::vector<PathGap>& gaps, bool timed,
                                      const VehicleStepOptions& options);

}  // namespace turnscale
