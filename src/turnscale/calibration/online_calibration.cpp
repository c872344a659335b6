// SPDX-License-Identifier: MIT
#include "turnscale/calibration/online_calibration.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/base/square.h"
#include "turnscale/calibration/camera_axes.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {
namespace {

constexpr int kLeastSteps = 3;
// What is known from so many steps with a turn, 13 s of driving, can be held against later ones.
constexpr int kLearned = 20;
// So many of the oldest steps are handed over at a time.
constexpr int kRetiredTogether = 20;
// The latest steps are held against all before them over this many steps: 8 s and 20 s of driving.
constexpr int kShortMemory = 12;
constexpr int kLongMemory = 30;
// Braking, load and the grade of the road move yaw and pitch by this much over such times, rad.
constexpr double kSway = 0.4 / kDegreesPerRadian;
// A camera was moved when the yaw and pitch of the latest steps disagree by so many standard deviations and by at least
// this angle (rad), several times in a row.
constexpr double kMovedSigmas = 4;
constexpr double kMovedAngle = 1.2 / kDegreesPerRadian;
constexpr int kMovedConfirmations = 3;
// The latest steps, which are after the move in any case.
constexpr int kLeastAfterMove = 5;
// Of one step, in variances, when the move is dated: a step may be off for other reasons.
constexpr double kMostMisfit = 9;
// By this share of the move, the directions after it may be off.
constexpr double kShareOfMove = 0.25;
// Q is used below this standard deviation of its yaw, rad (CalibrationOptions::motion_bias included): half of that of a
// camera mounted by eye. What is left is estimated with the scale.
constexpr double kUsableYawSigma = 1.5 / kDegreesPerRadian;
// And below this one of its roll, rad: that of a camera mounted by eye. The scale does not estimate it.
constexpr double kUsableRollSigma = 4 / kDegreesPerRadian;

std::vector<StepMeasurement> Measurements(const std::deque<CameraStep>& steps, int first, int last) {
  std::vector<StepMeasurement> measurements;
  for (int i = first; i < last; ++i) measurements.push_back(MeasurementOf(steps[i]));
  return measurements;
}

// Exact steps leave a covariance of rank one, which has no inverse.
Eigen::Matrix3d FiniteCovariance(const Refinement& refinement) {
  return refinement.covariance.allFinite() ? refinement.covariance : refinement.information.inverse();
}

}  // namespace

void OnlineCalibrationOptions::Check() const {
  calibration.Check();
  if (window < kLongMemory + kRetiredTogether)
    throw InputError("window: must be at least " + std::to_string(kLongMemory + kRetiredTogether) + " steps");
  if (!(drift > 0)) throw InputError("drift: must be above 0 rad");
}

OnlineCalibration::OnlineCalibration(const OnlineCalibrationOptions& options) : options_(options) { options_.Check(); }

const OnlineState& OnlineCalibration::Add(const CameraStep& step) {
  const Eigen::Vector3d& forward = options_.forward.isZero() ? way_ : options_.forward;
  const bool backs_up = forward.dot(step.previous_from_current.translation) < 0;
  window_.push_back(backs_up ? Reversed(step) : step);
  Learn(window_.back());
  if (static_cast<int>(window_.size()) > options_.window) Retire();
  if (turned_) Refine();
  const std::optional<Change> move = FindMove();
  state_.moved = move.has_value();
  if (move) Restart(*move);
  Report();
  return state_;
}

void OnlineCalibration::Learn(const CameraStep& step) {
  ++steps_;
  way_ += step.previous_from_current.translation;
  const RigidTransform motion = WholeMotion(step);
  axis_.Add(motion.rotation);
  const double psi = TurningAngle(motion.rotation, axis_.direction());
  linear_.Add(motion, psi);
  turning_ += std::abs(psi);
  headings_.push_back(headings_.empty() ? psi : headings_.back() + psi);
  if (static_cast<int>(headings_.size()) > options_.window) headings_.pop_front();
  turned_ = turned_ || HasTurned(static_cast<int>(headings_.size()));
}

void OnlineCalibration::Retire() {
  if (!refinement_) {
    // No turn yet: the roll from these steps would be noise.
    window_.pop_front();
    return;
  }
  const std::optional<Refinement> past = RefineSteps(kRetiredTogether, refinement_->vehicle_from_camera);
  window_.erase(window_.begin(), window_.begin() + kRetiredTogether);
  if (!past) return;
  const Eigen::Matrix3d covariance =
      FiniteCovariance(*past) + options_.drift * options_.drift * Eigen::Matrix3d::Identity();
  before_ = RotationPrior{past->vehicle_from_camera, covariance.inverse()};
}

void OnlineCalibration::Refine() {
  // A rotation that the car's turns contradict came from too little turning: it is forgotten.
  if (refinement_ && ContradictsAxis(axis_.direction(), refinement_->vehicle_from_camera)) {
    refinement_.reset();
    before_.reset();
  }
  const Eigen::Quaterniond start =
      refinement_ ? refinement_->vehicle_from_camera : RotationFromForwardAndDown(way_, axis_.direction());
  if (const auto refined = RefineSteps(static_cast<int>(window_.size()), start)) refinement_ = refined;
}

std::optional<Refinement> OnlineCalibration::RefineSteps(int steps, const Eigen::Quaterniond& start) const {
  return RefineRotationAbout(axis_.direction(), Measurements(window_, 0, steps), start, options_.calibration.refinement,
                             before_);
}

bool OnlineCalibration::HasTurned(int steps) const {
  const auto [least, most] = std::minmax_element(headings_.begin(), headings_.begin() + steps);
  return *most - *least > options_.calibration.min_turn;
}

Eigen::Vector2d OnlineCalibration::Change::angles() const {
  return VectorFromRotation(after.vehicle_from_camera * before.vehicle_from_camera.conjugate()).head<2>();
}

// The latest steps by themselves against all steps before them.
std::optional<OnlineCalibration::Change> OnlineCalibration::ChangeOver(int steps) const {
  const int size = static_cast<int>(window_.size());
  const int split = size - steps;
  if (split < (before_ ? kLeastSteps : kLearned + kept_) || (!before_ && !HasTurned(split))) return std::nullopt;
  const RefinementOptions& options = options_.calibration.refinement;
  const Eigen::Quaterniond start = refinement_->vehicle_from_camera;
  const Refinement before = RefineRotation(Measurements(window_, 0, split), start, options, before_);
  // The roll of a few steps is noise, and would drag yaw and pitch along.
  const RotationPrior same_roll = WithSameRoll(options, {}, before.vehicle_from_camera);
  const Refinement after = RefineRotation(Measurements(window_, split, size), start, options, same_roll);
  if (!before.covariance.allFinite() || !after.covariance.allFinite()) return std::nullopt;
  Change change{before, after};
  const Eigen::Vector2d moved = change.angles();
  // So few steps that four unknowns and three spreads take a good part of their scatter away.
  const double few = steps / std::max(steps - 6.0, 1.0);
  const Eigen::Matrix2d covariance =
      (before.covariance + few * after.covariance).topLeftCorner<2, 2>() + kSway * kSway * Eigen::Matrix2d::Identity();
  const bool differs = moved.norm() > kMovedAngle && moved.dot(covariance.inverse() * moved) > Square(kMovedSigmas);
  return differs ? std::optional(std::move(change)) : std::nullopt;
}

std::optional<OnlineCalibration::Change> OnlineCalibration::FindMove() {
  if (!refinement_) return std::nullopt;
  std::optional<Change> change = ChangeOver(kShortMemory);
  if (!change) change = ChangeOver(kLongMemory);
  disagreements_ = change ? disagreements_ + 1 : 0;
  return disagreements_ >= kMovedConfirmations ? change : std::nullopt;
}

// Where the directions of travel fit best, before it with one rotation and from it on with the other.
int OnlineCalibration::PlaceOf(const Change& change) const {
  // `after` may include steps from before the move, and is then off by a share of it.
  const double share = kShareOfMove * change.angles().norm();
  const double vertical = std::max(change.before.noise.vertical, share);
  const double horizontal = std::max(change.before.noise.horizontal, share);
  const double lever_arm = change.before.lever_arms.empty() ? 0 : Median(change.before.lever_arms);
  const auto misfit = [&](const StepMeasurement& step, const Refinement& refinement) {
    if (step.length <= 0) return 0.0;
    const ModelResidual off = ResidualOfModel(step, refinement.vehicle_from_camera, lever_arm / step.length);
    return std::min(Square(off.vertical / vertical) + Square(off.horizontal / horizontal), kMostMisfit);
  };
  const int size = static_cast<int>(window_.size());
  int place = size - kLeastAfterMove;
  double least = 0;
  double sum = 0;
  for (int i = place - 1; i >= 0; --i) {
    const StepMeasurement step = MeasurementOf(window_[i]);
    sum += misfit(step, change.after) - misfit(step, change.before);
    if (sum >= least) continue;
    least = sum;
    place = i;
  }
  return place;
}

void OnlineCalibration::Restart(const Change& change) {
  const int place = PlaceOf(change);
  const Eigen::Vector2d moved = change.angles();
  const std::optional<Refinement> until_move =
      place >= kLeastSteps ? RefineSteps(place, change.before.vehicle_from_camera) : std::nullopt;
  const Refinement& before = until_move ? *until_move : change.before;
  state_.vehicle_from_camera_before_move = before.vehicle_from_camera;
  state_.sigma_before_move = SigmaOfAngles(before.vehicle_from_camera, StatedCovariance(before));
  state_.move_time = window_[place].begin;
  state_.move = {moved.y(), moved.x(), 0};
  window_.erase(window_.begin(), window_.begin() + place);
  way_.setZero();
  axis_ = TurningAxis();
  linear_ = LinearCalibration();
  turning_ = 0;
  turned_ = false;
  headings_.clear();
  steps_ = 0;
  kept_ = static_cast<int>(window_.size());
  for (const CameraStep& step : window_) Learn(step);
  before_.reset();
  refinement_.reset();
  disagreements_ = 0;
  ++state_.moves;
  if (turned_) Refine();
}

Eigen::Matrix3d OnlineCalibration::StatedCovariance(const Refinement& refinement) const {
  Eigen::Matrix3d covariance = refinement.covariance;
  const double bias = options_.calibration.motion_bias;
  covariance.diagonal().head<2>().array() += bias * bias;
  return covariance;
}

void OnlineCalibration::Report() {
  state_.steps = steps_;
  state_.turning = turning_;
  state_.singular_values = linear_.Solve().singular_values;
  state_.estimated = refinement_.has_value();
  if (!refinement_) {
    state_.vehicle_from_camera = RotationFromForwardAndDown(way_, Eigen::Vector3d::UnitY());
    state_.angles = YawPitchRollFromRotation(state_.vehicle_from_camera);
    state_.usable = false;
    state_.covariance = UnknownRotation();
    state_.sigma = SigmaOfAngles(state_.vehicle_from_camera, state_.covariance);
    return;
  }
  state_.vehicle_from_camera = refinement_->vehicle_from_camera;
  state_.covariance = StatedCovariance(*refinement_);
  state_.angles = YawPitchRollFromRotation(state_.vehicle_from_camera);
  state_.sigma = SigmaOfAngles(state_.vehicle_from_camera, state_.covariance);
  state_.usable = state_.sigma.yaw < kUsableYawSigma && state_.sigma.roll < kUsableRollSigma;
}

}  // namespace turnscale
