// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// How long a measured motion is extrapolated. Times and sigmas are from KITTI's ground truth (22,000 frames).
struct MotionModelOptions {
  /// Speed and turning rate are constant for this time, seconds.
  double steady_seconds = 0.5;
  /// After that the turning rate decays with this time constant, seconds: turns end. In all, a turn goes on for at most
  /// the two together, 2 s at the last rate.
  double turn_seconds = 1.5;
  /// What the camera turns about other axes than the car's vertical goes on for this time, seconds, or for that of one
  /// image: the body swings back.
  double swing_seconds = 0.15;
  /// And the speed with this one, seconds. Cars keep their speed for longer than most gaps last; it bounds what a
  /// drive that is interrupted can be given.
  double travel_seconds = 60;
  /// Change of the turning rate per second that alternative predictions allow for, rad/s^2: that of a car at 4 m/s
  /// whose wheels turn by 45 degrees per second. 0: there are no such predictions.
  double turn_acceleration = 1.2;
  /// Relative standard deviation of a speed at the time it was measured.
  double speed_sigma = 0.05;
  /// Its growth per second: cars accelerate.
  double speed_sigma_per_second = 0.15;
  /// The same for a slow car, whose acceleration is large beside its speed: standard deviation of the acceleration as a
  /// share of the depth of the nearest quarter of the scene, 1/s^2. 1.2 m/s^2 where that is 12 m away.
  double acceleration_in_depths = 0.1;
  /// Usual error of the turn that PredictAcross predicts for a gap, over the length of the gap squared: a standard
  /// deviation on straights, rad/s^2, and one in proportion to the larger turning rate on both sides of the gap, 1/s^2.
  /// From gaps of 0.5 to 30 s.
  double gap_turn_on_straights = 0.01;
  double gap_turn_in_turns = 0.11;
  /// Standard deviation that allows for a corner which the car turns within the gap, over the length of the gap
  /// squared, rad/s^2: half of the largest error in gaps of 1 to 4 s. The turn is predicted only where the images
  /// before and after the gap do not show it, mostly because the car has turned out of what it saw: then the error is
  /// far above the usual one (docs/gaps.md).
  double gap_corner = 0.1;
  /// Speed before the gap, m/s, up to which gap_corner holds; above, it falls with the speed squared. A speed that is
  /// not known counts as low.
  double gap_corner_speed = 8;
  /// Largest values of the usual standard deviation, rad, with which any direction is possible, and of that of a
  /// corner, with which a right angle may or may not have been turned.
  double max_gap_turn = 1.8;
  double max_gap_corner = 0.8;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Standard deviation of the angle by which a car turns in so many seconds that the images do not show, if it is
/// predicted by the turning rates before and after (MotionModel::PredictAcross), rad; the larger one is `rate`, rad/s.
/// `speed`: before them, m/s, if it is known. From KITTI's ground truth (docs/gaps.md).
double GapTurnSigma(const MotionModelOptions& options, double seconds, double rate, std::optional<double> speed);

/// A speed that was measured once.
struct PastSpeed {
  double speed = 0;  ///< units of length per second
  double time = 0;   ///< seconds
};

/// Predicts the camera's pose from its previous motion: constant velocity and turning rate, which decay when nothing
/// has been measured for some time. Up to the time that one image takes, they are those of the last step, then means
/// over the last fifth of a second.
class MotionModel {
 public:
  explicit MotionModel(const MotionModelOptions& options = {}) : options_(options) {}

  /// Pose expected at `time` (seconds).
  RigidTransform Predict(double time) const;

  /// The car's vertical in camera axes, of either sign; the camera's y axis until it is known better.
  void SetVertical(const Eigen::Vector3d& vertical) { vertical_ = vertical.normalized(); }

  /// Alternative predictions if tracking from the expected pose fails: the camera stands still; it moves as before an
  /// abrupt stop; the car turns more or less than before. At a few images per second the turning rate changes by much
  /// from one to the next.
  std::vector<RigidTransform> OtherPredictions(double time) const;

  /// How far a turn may be from the expected one until `time`, radians.
  double TurnReach(double time) const;

  /// Pose at `time` if the car turns by `turn` radians more than expected, at this share of the expected speed.
  RigidTransform PredictOtherwise(double time, double turn, double speed_share) const;

  /// Pose at `time`, after a gap in the tracking. The turning rate before it and the one after it (`rate`, rad/s about
  /// vertical()) each go on to the middle of the gap, and decay towards it. `turn`: the angle turned about vertical()
  /// in all, radians, if it is known. If it is smaller, the rates last for less time; what is more is spread evenly.
  /// The speed is the last one.
  RigidTransform PredictAcross(double time, double rate, std::optional<double> turn) const;

  /// Standard deviation of the angle about vertical() by which PredictAcross is off where `turn` is not known, rad.
  /// `metres_per_unit`: of the speed before the gap, if it is known.
  double TurnSigmaAcross(double time, double rate, std::optional<double> metres_per_unit) const;

  /// The car's vertical as SetVertical has it.
  const Eigen::Vector3d& vertical() const { return vertical_; }

  /// Over the last fifth of a second at least, rad/s about vertical(); 0 before two poses are known.
  double turning_rate() const { return step_ ? vertical_.dot(step_->mean.turn) : 0.0; }

  /// Takes a measured pose; the velocity is the one from the measured pose before. `after_repeats`: the images between
  /// the two showed once more what the first one does.
  void Update(double time, const RigidTransform& camera_from_world, bool after_repeats = false);

  /// Takes a pose that was not measured: predictions keep the last velocities; speed() and PastSpeeds() start anew.
  void Restart(double time, const RigidTransform& camera_from_world);

  /// The camera stands still.
  void Stop();
  /// The camera has gone on as it did before StoppedAtOnce().
  void GoOn();

  /// The last pose turned out to be this one, and lengths are `factor` times what they were.
  void Correct(const RigidTransform& camera_from_world, double factor);

  const RigidTransform& last() const { return camera_from_world_; }
  /// When the last pose was measured, seconds.
  double last_measured_time() const { return last_measured_time_; }
  /// Over the last fifth of a second at least; units of length per second; 0 before two poses are known.
  double speed() const;
  /// When the camera was measured last before it came to a standstill from one image to the next, as no car does;
  /// empty where it did not, or moves again. What stands still is the image then, if not the estimate.
  std::optional<double> StoppedAtOnce() const;
  /// The speed now, and the one before it broke off where it did.
  std::vector<PastSpeed> PastSpeeds() const;
  /// Relative standard deviation of a past speed as one for `time`; `depth` is that of the
  /// nearest quarter of the scene, units of length; 0 where it is not known.
  double SpeedSigma(const PastSpeed& past, double time, double depth) const;

 private:
  struct Rates {
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();      ///< rad/s
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< units of length per second
  };
  struct Step {
    RigidTransform current_from_previous;
    double seconds = 0;  ///< that it spans
    Rates mean;          ///< over the last steps

    double speed() const { return current_from_previous.translation.norm() / seconds; }
    void Scale(double factor) {
      current_from_previous.translation *= factor;
      mean.velocity *= factor;
    }
  };
  struct Travel {
    double length = 0;
    double seconds = 0;
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  };
  struct BrokenOff {
    Step step;
    PastSpeed past;
    bool at_once = false;  ///< to nothing; it had hardly fallen before, and images were repeated in between
  };

  void Remember(const Travel& travel);
  Travel Recent() const;
  Step Turning(Step step, double rate) const;
  RigidTransform Extrapolate(const Step& step, double seconds) const;

  MotionModelOptions options_;
  double last_measured_time_ = 0;
  RigidTransform camera_from_world_;
  Eigen::Vector3d vertical_ = Eigen::Vector3d::UnitY();
  std::optional<Step> step_;
  std::deque<Travel> recent_;            ///< of the last steps, the latest at the back
  double peak_speed_ = 0;                ///< of the last seconds, decaying; units of length per second
  std::optional<BrokenOff> broken_off_;  ///< before the speed fell at once
  bool started_ = false;
};

}  // namespace turnscale
