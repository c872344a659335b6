// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "turnscale/calibration/calibration.h"
#include "turnscale/calibration/linear_calibration.h"
#include "turnscale/geometry/angle.h"

namespace turnscale {

struct OnlineCalibrationOptions {
  CalibrationOptions calibration;
  /// A direction of the camera's that is less than 90 deg from the car's forward, so that a drive that begins with
  /// backing up is known for what it is. Zero: forward is where the car has gone most.
  Eigen::Vector3d forward = Eigen::Vector3d::Zero();
  /// Latest steps that are refined anew with each step, at least 50; older ones live on as one rotation and its
  /// covariance.
  int window = 60;
  /// The drift of a mount and of a car's load that old knowledge is allowed, rad for each time steps are handed over
  /// (0.02 deg).
  double drift = 0.02 / kDegreesPerRadian;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The online estimate of the camera-to-vehicle rotation.
struct OnlineState {
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();  ///< the paper's Q
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();                     ///< rad^2, about vehicle axes
  YawPitchRoll angles;                                                      ///< rad
  YawPitchRoll sigma;                                                       ///< rad
  Eigen::Vector4d singular_values = Eigen::Vector4d::Zero();  ///< of (14) since the start or the last move
  double turning = 0;                                         ///< sum of |psi| since then, rad
  int steps = 0;                                              ///< since then
  /// A turn was seen. Before, the rotation only says which way the car goes, with the camera taken as upright, and the
  /// sigmas are infinite.
  bool estimated = false;
  bool usable = false;  ///< a turn was seen, and yaw and roll are known well enough
  bool moved = false;   ///< this very step showed that the camera was moved: all before the move is forgotten
  int moves = 0;        ///< so far
  /// The latest move: when, seconds, and by how much.
  double move_time = 0;
  YawPitchRoll move;  ///< rad; yaw and pitch only
  /// Without the steps between the move and its discovery.
  Eigen::Quaterniond vehicle_from_camera_before_move = Eigen::Quaterniond::Identity();
  YawPitchRoll sigma_before_move;  ///< rad
};

/// Online calibration, with bounded time and memory per step. Detects a camera that was moved, from a change of the
/// direction of travel. A move about that very direction (roll) hides in the road's bank, and is only
/// learned slowly.
class OnlineCalibration {
 public:
  /// Throws InputError when an option makes no sense.
  explicit OnlineCalibration(const OnlineCalibrationOptions& options = {});

  /// Takes the next step of the odometry, of any unit of length; steps that stand still do not belong here (see
  /// StepGatherer). What Calibrate assumes is assumed here.
  const OnlineState& Add(const CameraStep& step);

  const OnlineState& state() const { return state_; }

 private:
  void Learn(const CameraStep& step);
  void Retire();
  void Refine();
  /// The rotation that the first steps of the window and those before them give; empty where the turns contradict it.
  std::optional<Refinement> RefineSteps(int steps, const Eigen::Quaterniond& start) const;
  bool HasTurned(int steps) const;  ///< in the first steps of the window, by CalibrationOptions::min_turn
  /// The rotation of the latest steps, this many, and that of all before them.
  struct Change {
    Refinement before;
    Refinement after;

    Eigen::Vector2d angles() const;  ///< pitch and yaw from before to after, rad
  };
  /// Empty where the two agree.
  std::optional<Change> ChangeOver(int steps) const;
  /// The first step of the window that belongs after the change.
  int PlaceOf(const Change& change) const;
  std::optional<Change> FindMove();
  void Restart(const Change& change);
  /// Of a refinement, with what a drive's own motion may be off by (CalibrationOptions::motion_bias).
  Eigen::Matrix3d StatedCovariance(const Refinement& refinement) const;
  void Report();

  OnlineCalibrationOptions options_;
  std::deque<CameraStep> window_;
  Eigen::Vector3d way_ = Eigen::Vector3d::Zero();  ///< sum of the translations, those of backing up turned round
  TurningAxis axis_;
  LinearCalibration linear_;
  double turning_ = 0;
  bool turned_ = false;          ///< by CalibrationOptions::min_turn within the window
  std::deque<double> headings_;  ///< after each step of the window, rad
  int steps_ = 0;
  int kept_ = 0;                         ///< steps from before the latest move was noticed
  std::optional<RotationPrior> before_;  ///< from the steps before the window
  std::optional<Refinement> refinement_;
  int disagreements_ = 0;  ///< in a row
  OnlineState state_;
};

}  // namespace turnscale
