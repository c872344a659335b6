// SPDX-License-Identifier: MIT
#include "turnscale/calibration/refinement.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/calibration/camera_axes.h"
#include "turnscale/calibration/step_residual.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/pooled_line.h"

namespace turnscale {
namespace {

// A piece of the drive gets a lever arm of its own once its heading has swept so much, rad.
constexpr double kTurnPerLeverArm = 60 / kDegreesPerRadian;
// Fewer steps do not determine their spread.
constexpr size_t kStepsForSpread = 20;
// No odometry is better than this, rad (0.001 deg): keeps weights finite on exact input.
constexpr double kLeastNoise = 1e-3 / kDegreesPerRadian;
// After so many iterations the weights stay what they are: quantiles of residuals jump, and would keep the last digits
// from settling.
constexpr int kIterationsWithNewWeights = 10;
// A piece's lever arm is within this share of the drive's, unless it shows otherwise.
constexpr double kLeverArmSpread = 0.5;
// And within this share of a step's way, where the drive's own is not known yet.
constexpr double kLeastLeverArmSpread = 0.1;
// Of this spread, in an iteration. Where the camera swings out by more than it goes forward, as in a bus, full steps
// diverge if few steps turn: the lever arm grows without bound, and straights are explained as turns.
constexpr double kMostLeverArmStep = 0.5;
// Relative; the last update of the lever arms.
constexpr double kLeverArmTolerance = 1e-3;
// In smaller turns, which take less time, the grade changes in proportion to the angle, rad.
constexpr double kAngleOfGradeChange = 12 / kDegreesPerRadian;

// Steps first...last - 1 share a lever arm.
struct Piece {
  size_t first = 0;
  size_t last = 0;
  double lever_arm = 0;
};

struct NormalEquations {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

class Refiner {
 public:
  Refiner(const std::vector<StepMeasurement>& steps, const Eigen::Quaterniond& start, const RefinementOptions& options,
          const std::optional<RotationPrior>& prior)
      : steps_(steps), options_(options), prior_(prior), states_(steps.size()) {
    result_.vehicle_from_camera = start;
    if (!options.weigh_by_spread) result_.noise = {1, 1, 1};
    SplitIntoPieces();
    StartLeverArms();
  }

  Refinement Run() && {
    while (!result_.converged && result_.iterations < options_.max_iterations) Iterate();
    FitSteps();
    Weigh();
    const NormalEquations equations = Reduce();
    result_.information = equations.hessian;
    result_.covariance = Covariance();
    for (const Piece& piece : pieces_) result_.lever_arms.push_back(piece.lever_arm);
    for (const StepState& state : states_) result_.psi.push_back(state.psi);
    return std::move(result_);
  }

 private:
  bool steady() const { return options_.travel == TravelModel::kSteady; }

  void SplitIntoPieces() {
    if (!steady()) return;
    Piece piece;
    double heading = 0;
    double least = 0;
    double most = 0;
    for (size_t i = 0; i < steps_.size(); ++i) {
      heading += steps_[i].frames * (result_.vehicle_from_camera * VectorFromRotation(steps_[i].rotation)).y();
      least = std::min(least, heading);
      most = std::max(most, heading);
      if (most - least < kTurnPerLeverArm) continue;
      piece.last = i + 1;
      pieces_.push_back(piece);
      piece.first = i + 1;
      heading = least = most = 0;
    }
    // What is left of the drive has turned too little to stand alone.
    if (pieces_.empty()) pieces_.push_back(piece);
    pieces_.back().last = steps_.size();
  }

  // The pooled line of the whole drive, at the rotation so far.
  void StartLeverArms() {
    if (!steady()) return;
    std::vector<VehicleStep> line;
    for (const StepMeasurement& step : steps_) {
      line.push_back({TurningMotionOf({step.rotation, step.direction * step.length}, result_.vehicle_from_camera), 0});
    }
    const PooledLineResult pooled = PoolTurn(line, {.min_inliers = 1, .min_angle = 0});
    usual_lever_arm_ = pooled.line ? std::max(pooled.line->lever_arm, 0.0) : 0.0;
    std::vector<double> ways;
    for (const StepMeasurement& step : steps_) ways.push_back(step.frames * step.length);
    least_lever_arm_sigma_ = std::max(kLeastLeverArmSpread * Median(std::move(ways)), 1e-9);
    for (Piece& piece : pieces_) piece.lever_arm = usual_lever_arm_;
  }

  void Iterate() {
    ++result_.iterations;
    FitSteps();
    if (result_.iterations <= kIterationsWithNewWeights) MeasureNoise();
    Weigh();
    const NormalEquations equations = Reduce();
    const Eigen::Vector3d update = -Solve(equations);
    result_.vehicle_from_camera = (RotationFromVector(update) * result_.vehicle_from_camera).normalized();
    MoveLeverArms(update);
    result_.converged = update.norm() < options_.tolerance && lever_arm_change_ < kLeverArmTolerance;
  }

  // Least change where the steps leave a direction open (no turn yet).
  static Eigen::Vector3d Solve(const NormalEquations& equations) {
    const double damping = 1e-9 * equations.hessian.trace();
    const Eigen::Matrix3d damped = equations.hessian + damping * Eigen::Matrix3d::Identity();
    Eigen::Vector3d update = damped.ldlt().solve(equations.gradient);
    constexpr double kMaxUpdate = 0.3;
    if (update.norm() > kMaxUpdate) update *= kMaxUpdate / update.norm();
    return update;
  }

  void FitSteps() {
    const StepWeights weights = Weights();
    for (size_t i = 0; i < steps_.size(); ++i) {
      if (!steady()) FitFreeStep(steps_[i], result_.vehicle_from_camera, weights, states_[i]);
    }
    for (const Piece& piece : pieces_) {
      for (size_t i = piece.first; i < piece.last; ++i) {
        states_[i].lever_ratio = steps_[i].length > 0 ? piece.lever_arm / steps_[i].length : 0;
        FitTurningAngle(steps_[i], result_.vehicle_from_camera, weights, states_[i]);
      }
    }
  }

  StepWeights Weights() const {
    StepWeights weights;
    weights.head<3>().setConstant(1 / result_.noise.rotation);
    weights.tail<3>() << 1 / result_.noise.horizontal, 1 / result_.noise.vertical, 1 / result_.noise.horizontal;
    return weights;
  }

  // Spread of each kind of residual. Horizontally, the noise of psi comes on top of that of the direction, and has to
  // be taken away again.
  void MeasureNoise() {
    if (!options_.weigh_by_spread || steps_.size() < kStepsForSpread) return;
    std::vector<double> rotation;
    std::vector<double> vertical;
    std::vector<double> horizontal;
    double psi_share = 0;
    for (size_t i = 0; i < steps_.size(); ++i) {
      const ModelResidual off = ResidualOfModel(steps_[i], result_.vehicle_from_camera, states_[i].lever_ratio);
      rotation.push_back(off.roll);
      rotation.push_back(off.pitch);
      vertical.push_back(off.vertical);
      horizontal.push_back(off.horizontal);
      psi_share += off.by_psi * off.by_psi;
    }
    psi_share /= static_cast<double>(steps_.size());
    StepNoise& noise = result_.noise;
    const double sqrt2 = std::sqrt(2.0);
    const double rotation_spread = std::max(RobustSigma(std::move(rotation)), kLeastNoise);
    noise.vertical = std::max(RobustSigma(std::move(vertical)), kLeastNoise);
    const double both = steady() ? RobustSigma(std::move(horizontal)) : noise.vertical;
    const double of_psi = psi_share * rotation_spread * rotation_spread;
    // A quarter of the variance is left to the direction at the least.
    noise.horizontal = std::max({std::sqrt(std::max(both * both - of_psi, 0.25 * both * both)), kLeastNoise});
    if (!steady()) noise.horizontal = noise.vertical;
    // The rotation's residual is sqrt(2) times the angle.
    noise.rotation = sqrt2 * rotation_spread;
  }

  // (16), over whole steps.
  void Weigh() {
    const StepWeights weights = Weights();
    std::vector<double> norms;
    for (size_t i = 0; i < steps_.size(); ++i) {
      StepState& state = states_[i];
      state.residual = EvaluateStep(steps_[i], result_.vehicle_from_camera, state.psi, state.lever_ratio);
      Whiten(weights, state.residual);
      norms.push_back(state.residual.value.norm());
    }
    if (result_.iterations <= kIterationsWithNewWeights) {
      huber_threshold_ = std::max(Quantile(norms, options_.huber_share), 1e-12);
    }
    const double threshold = huber_threshold_;
    for (size_t i = 0; i < steps_.size(); ++i) states_[i].huber = norms[i] > threshold ? threshold / norms[i] : 1;
  }

  NormalEquations Reduce() {
    NormalEquations equations;
    if (prior_) {
      const Eigen::Vector3d off =
          VectorFromRotation(result_.vehicle_from_camera * prior_->vehicle_from_camera.conjugate());
      equations.hessian += prior_->information;
      equations.gradient += prior_->information * off;
    }
    blocks_.clear();
    for (const StepState& state : states_) {
      if (steady()) break;
      const EliminatedStep step = EliminateFreeStep(state, false);
      equations.hessian += step.hessian.topLeftCorner<3, 3>();
      equations.gradient += step.gradient.head<3>();
    }
    for (const Piece& piece : pieces_) {
      const EliminatedStep block = ReducePiece(piece, false);
      blocks_.push_back(block);
      const Eigen::Vector3d cross = block.hessian.topRightCorner<3, 1>();
      equations.hessian += block.hessian.topLeftCorner<3, 3>() - cross * cross.transpose() / block.hessian(3, 3);
      equations.gradient += block.gradient.head<3>() - cross * (block.gradient[3] / block.hessian(3, 3));
    }
    return equations;
  }

  double LeverArmSigma() const { return std::max(kLeverArmSpread * usual_lever_arm_, least_lever_arm_sigma_); }

  // Of Q and the piece's lever arm.
  EliminatedStep ReducePiece(const Piece& piece, bool curvature) const {
    EliminatedStep block;
    const double sigma = LeverArmSigma();
    block.hessian(3, 3) = 1 / (sigma * sigma);
    block.gradient[3] = (piece.lever_arm - usual_lever_arm_) / (sigma * sigma);
    for (size_t i = piece.first; i < piece.last; ++i) {
      if (steps_[i].length > 0) block += EliminateTurningAngle(states_[i], 1 / steps_[i].length, curvature);
    }
    return block;
  }

  void MoveLeverArms(const Eigen::Vector3d& update) {
    lever_arm_change_ = 0;
    for (size_t i = 0; i < pieces_.size(); ++i) {
      const EliminatedStep& block = blocks_[i];
      const double newton =
          -(block.gradient[3] + block.hessian.topRightCorner<3, 1>().dot(update)) / block.hessian(3, 3);
      const double change =
          std::clamp(newton, -kMostLeverArmStep * LeverArmSigma(), kMostLeverArmStep * LeverArmSigma());
      pieces_[i].lever_arm += change;
      lever_arm_change_ =
          std::max(lever_arm_change_, std::abs(change) / std::max(std::abs(pieces_[i].lever_arm), 1e-9));
    }
    // The drive's own lever arm follows its pieces.
    if (result_.iterations > kIterationsWithNewWeights) return;
    std::vector<double> lengths;
    for (const Piece& piece : pieces_) lengths.push_back(piece.lever_arm);
    if (!lengths.empty()) usual_lever_arm_ = std::max(Median(lengths), 0.0);
  }

  // Variance of the tilt of the turning axis in a turn by `angle`, rad^2.
  double TiltVariance(double angle) const {
    const double by_grade = options_.grade_change / std::hypot(angle, kAngleOfGradeChange);
    return options_.road_bank * options_.road_bank + by_grade * by_grade;
  }

  // Squared scores of what the turns have in common with nothing else: the road and the body's lean tilt the turning
  // axis sideways, by another angle in each turn.
  double TiltScore() const {
    // Also in wide bends the road tilts all steps together.
    constexpr double kLeastPsi = 0.5 / kDegreesPerRadian;
    double sum = 0;
    double turn = 0;
    double angle = 0;
    bool right = false;
    for (size_t i = 0; i < states_.size(); ++i) {
      const StepState& state = states_[i];
      const double turned = std::abs(state.psi) * steps_[i].frames;
      const bool turning = turned > kLeastPsi;
      if (!turning || right != (state.psi > 0)) {
        sum += turn * turn * TiltVariance(angle);
        turn = angle = 0;
      }
      right = state.psi > 0;
      if (!turning) continue;
      turn += state.huber * state.residual.by_rotation.col(2).head<3>().squaredNorm();
      angle += turned;
    }
    return sum + turn * turn * TiltVariance(angle);
  }

  // H^-1 (sum of squared scores) H^-1, the curvature of Huber's norm in H: right for whatever size the noise has.
  Eigen::Matrix3d Covariance() const {
    Eigen::Matrix3d hessian = prior_ ? prior_->information : Eigen::Matrix3d(Eigen::Matrix3d::Zero());
    Eigen::Matrix3d scores = hessian;
    scores(2, 2) += TiltScore();
    for (const StepState& state : states_) {
      if (steady()) break;
      const EliminatedStep step = EliminateFreeStep(state, true);
      hessian += step.hessian.topLeftCorner<3, 3>();
      scores += step.gradient.head<3>() * step.gradient.head<3>().transpose();
    }
    for (const Piece& piece : pieces_) {
      const EliminatedStep block = ReducePiece(piece, true);
      const Eigen::Vector3d share = block.hessian.topRightCorner<3, 1>() / block.hessian(3, 3);
      hessian += block.hessian.topLeftCorner<3, 3>() - share * block.hessian.bottomLeftCorner<1, 3>();
      // The prior of the lever arm is uncertain, too.
      scores += share * share.transpose() / (LeverArmSigma() * LeverArmSigma());
      for (size_t i = piece.first; i < piece.last; ++i) {
        if (steps_[i].length <= 0) continue;
        const EliminatedStep step = EliminateTurningAngle(states_[i], 1 / steps_[i].length, true);
        const Eigen::Vector3d score = step.gradient.head<3>() - share * step.gradient[3];
        scores += score * score.transpose();
      }
    }
    const Eigen::FullPivLU<Eigen::Matrix3d> lu(hessian);
    if (!lu.isInvertible()) return UnknownRotation();
    const Eigen::Matrix3d inverse = lu.inverse();
    return inverse * scores * inverse.transpose();
  }

  const std::vector<StepMeasurement>& steps_;
  const RefinementOptions& options_;
  const std::optional<RotationPrior>& prior_;
  std::vector<Piece> pieces_;
  double usual_lever_arm_ = 0;
  double least_lever_arm_sigma_ = 0;
  double lever_arm_change_ = 0;
  double huber_threshold_ = 0;
  std::vector<StepState> states_;
  std::vector<EliminatedStep> blocks_;
  Refinement result_;
};

}  // namespace

void RefinementOptions::Check() const {
  if (!(huber_share > 0 && huber_share <= 1)) throw InputError("huber_share: must lie in (0, 1]");
  if (!(road_bank >= 0)) throw InputError("road_bank: must not be negative");
  if (!(grade_change >= 0)) throw InputError("grade_change: must not be negative");
  if (max_iterations < 1) throw InputError("max_iterations: must be at least 1");
  if (!(tolerance > 0)) throw InputError("tolerance: must be above 0 rad");
}

StepMeasurement MeasurementOf(const CameraStep& step) {
  StepMeasurement measurement;
  measurement.frames = step.frames;
  measurement.rotation = step.previous_from_current.rotation;
  measurement.length = step.previous_from_current.translation.norm();
  if (measurement.length > 0) measurement.direction = step.previous_from_current.translation / measurement.length;
  return measurement;
}

Refinement RefineRotation(const std::vector<StepMeasurement>& steps, const Eigen::Quaterniond& start,
                          const RefinementOptions& options, const std::optional<RotationPrior>& prior) {
  options.Check();
  return Refiner(steps, start, options, prior).Run();
}

RotationPrior WithSameRoll(const RefinementOptions& options, const std::optional<RotationPrior>& prior,
                           const Eigen::Quaterniond& vehicle_from_camera) {
  RotationPrior same_roll = prior.value_or(RotationPrior{vehicle_from_camera, Eigen::Matrix3d::Zero()});
  same_roll.information(2, 2) += 1 / (options.road_bank * options.road_bank + 1e-6);
  return same_roll;
}

bool ContradictsAxis(const Eigen::Vector3d& turning_axis, const Eigen::Quaterniond& vehicle_from_camera) {
  constexpr double kOneAxis = 0.94;  // cosine of 20 deg
  return (vehicle_from_camera * turning_axis).y() < kOneAxis;
}

std::optional<Refinement> RefineRotationAbout(const Eigen::Vector3d& turning_axis,
                                              const std::vector<StepMeasurement>& steps,
                                              const Eigen::Quaterniond& start, const RefinementOptions& options,
                                              const std::optional<RotationPrior>& prior) {
  Refinement refinement = RefineRotation(steps, start, options, prior);
  if (!ContradictsAxis(turning_axis, refinement.vehicle_from_camera)) return refinement;
  refinement = RefineRotation(steps, start, options, WithSameRoll(options, prior, start));
  if (!ContradictsAxis(turning_axis, refinement.vehicle_from_camera)) return refinement;
  return std::nullopt;
}

}  // namespace turnscale
