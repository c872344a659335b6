// SPDX-License-Identifier: MIT
#include "turnscale/scale/scale_evidence.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "turnscale/base/check_part.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/base/robust_weights.h"
#include "turnscale/base/square.h"
#include "turnscale/kinematics/pooled_line.h"
#include "turnscale/scale/road_parts.h"

namespace turnscale {
namespace {

// Fewer steps of a straight show no direction of travel.
constexpr int kFewestStraightSteps = 3;
// The lever arm with which the bends of a straight are taken out before the scale is known, over that of the turns:
// faster bends slip more.
constexpr double kBendRatio = 0.9;
// Of the steps of a segment that show the road.
constexpr int kRoadReweightings = 5;
constexpr double kRoadHuber = 1.5;

LeverArm LeverArmOf(const DriveState& state) {
  return {std::exp(state[kLogLeverArm]), std::max(state[kSlip], 0.0), state[kRollHeight]};
}

// The turn as it would be without a lag of the camera's orientation.
PooledLine WithoutLag(PooledLine turn, const DriveState& state) {
  turn.lever_arm -= state[kLag] * turn.mean_speed;
  return turn;
}

double MedianLeverArm(const std::vector<SegmentEvidence>& evidence) {
  std::vector<std::pair<double, double>> lever_arms;
  for (const SegmentEvidence& segment : evidence)
    if (segment.turn) lever_arms.emplace_back(segment.turn->lever_arm, std::abs(segment.turn->angle));
  return lever_arms.empty() ? 0.0 : std::max(WeightedMedian(std::move(lever_arms)), 0.0);
}

// Standard deviation of the mean of an exponentially correlated error of 1 over so many correlation lengths. Chosen so
// that the mean over many equal segments, each with one such value and correlated by the distance of their middles, has
// the variance of the mean of the error itself.
double MeanErrorSigma(double lengths) {
  if (!(lengths > 1e-3)) return 1;
  const double persistence = std::exp(-lengths);
  return std::sqrt(2 / lengths * (1 - persistence) / (1 + persistence));
}

}  // namespace

void CarPrior::Check() const {
  Require(
      lever_arm <= kLongestLeverArm && (lever_arm > 0 || (lever_arm == 0 && knows_height())),
      "car.lever_arm: has to be the distance from the rear axle forward to the camera in metres, above 0 and up to " +
          NumberText(kLongestLeverArm));
  Require(!knows_lever_arm() || (lever_arm_sigma >= 0 && lever_arm_sigma < lever_arm),
          "car.lever_arm_sigma: has to be from 0 to below the lever arm, metres");
  Require(camera_height >= 0 && camera_height <= kHighestCamera,
          "car.camera_height: has to be the height of the camera above the road in metres, up to " +
              NumberText(kHighestCamera) + ", or 0 if it is not known");
  Require(!knows_height() || (camera_height_sigma >= 0 && camera_height_sigma < camera_height),
          "car.camera_height_sigma: has to be from 0 to below the height, metres");
  Require(side_slip >= 0 && side_slip < 1, "car.side_slip: has to be from 0 to below 1 s^2/m");
  Require(side_slip_sigma >= 0 && side_slip_sigma < 1, "car.side_slip_sigma: has to be from 0 to below 1 s^2/m");
  Require(
      CanCorrelate(height_correlation, height_slip_correlation, lever_arm_slip_correlation),
      "car.height_correlation, car.height_slip_correlation, car.lever_arm_slip_correlation: errors cannot correlate "
      "like this");
  Require(yaw_sigma > 0 && yaw_sigma < 1, "car.yaw_sigma: has to be above 0 and below 1 rad");
  Require(std::abs(image_lag) < 10 && (image_lag == 0 || image_lag_sigma > 0),
          "car.image_lag: has to be below 10 s, and needs a standard deviation");
  Require(image_lag_sigma >= 0 && image_lag_sigma < 10, "car.image_lag_sigma: has to be from 0 to below 10 s");
  Require(roll_height >= 0 && roll_height < 10, "car.roll_height: has to be from 0 to below 10 m");
  Require(roll_height_sigma >= 0 && roll_height_sigma < 10, "car.roll_height_sigma: has to be from 0 to below 10 m");
}

void RoadEvidenceOptions::Check() const {
  Require(sigma > 0 && sigma < 1, "sigma: has to be above 0 and below 1");
  Require(correlation_length > 0, "correlation_length: has to be a positive number of metres");
  Require(step_sigma > 0 && step_sigma < 1, "step_sigma: has to be above 0 and below 1");
  Require(min_steps >= 1, "min_steps: has to be at least 1");
}

void EvidenceOptions::Check() const {
  CheckPart("line.", line);
  CheckPart("evidence.road_", road);
  Require(turn_sigma > 0 && turn_sigma < 1, "evidence.turn_sigma: has to be above 0 and below 1");
  Require(slip_sigma >= 0 && slip_sigma < 10, "evidence.slip_sigma: has to be from 0 to below 10");
  Require(turn_direction_sigma >= 0 && turn_direction_sigma < 1,
          "evidence.turn_direction_sigma_deg: has to be from 0 to below 57.3");
  Require(direction_in_turn_sigma > 0 && direction_in_turn_sigma < 1,
          "evidence.direction_in_turn_sigma_deg: has to be above 0 and below 57.3");
  Require(straight_direction_sigma > 0 && straight_direction_sigma < 1,
          "evidence.straight_direction_sigma_deg: has to be above 0 and below 57.3");
  Require(bend_sigma >= 0 && bend_sigma < 10, "evidence.bend_sigma: has to be from 0 to below 10");
  Require(min_lever_arm_ratio >= 0 && min_lever_arm_ratio < 1,
          "evidence.min_lever_arm_ratio: has to be from 0 to below 1");
}

SegmentEvidence EvidenceOfTurn(std::span<const VehicleStep> steps, const EvidenceOptions& options) {
  SegmentEvidence evidence;
  PooledLineResult pooled = PoolTurn(steps, options.line);
  evidence.turn = pooled.line;
  if (pooled.line) evidence.direction_in_turn = FitDirectionInTurn(steps, options.line);
  evidence.why_no_turn = std::move(pooled.reason);
  return evidence;
}

std::optional<StraightDirection> DirectionOnStraight(std::span<const VehicleStep> steps, double lever_arm,
                                                     const EvidenceOptions& options) {
  std::vector<VehicleStep> used;
  std::ranges::copy_if(steps, std::back_inserter(used), [](const VehicleStep& step) {
    return step.shows_kinematics() && std::isfinite(step.lateral()) && std::isfinite(step.signed_square_speed());
  });
  if (static_cast<int>(used.size()) < kFewestStraightSteps) return std::nullopt;
  const double noise = LateralNoise(used, options.line.sigma_theta);
  if (!(noise > 0)) return std::nullopt;
  StraightDirection straight;
  straight.bend_lever_arm = kBendRatio * lever_arm;
  std::vector<LinePoint> points;
  points.reserve(used.size());
  for (const VehicleStep& step : used)
    points.push_back({step.forward(), step.lateral() - straight.bend_lever_arm * step.swing()});
  const RobustLine line = FitRobustLine(points, noise, options.line.robust_threshold);
  straight.angle = line.slope;
  double weights = 0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const double weight = line.weight[i] * points[i].x;
    weights += weight * points[i].x;
    straight.bend += weight * used[i].swing();
    straight.bend_square_speed += weight * used[i].swing() * used[i].signed_square_speed();
    straight.bend_speed += weight * used[i].swing() * used[i].signed_speed();
  }
  straight.bend /= weights;
  straight.bend_square_speed /= weights;
  straight.bend_speed /= weights;
  straight.sigma = std::hypot(line.sigma, options.bend_sigma * lever_arm * straight.bend);
  const bool is_known = std::isfinite(straight.angle) && std::isfinite(straight.sigma);
  return is_known ? std::optional(straight) : std::nullopt;
}

std::vector<SegmentEvidence> GatherEvidence(std::span<const VehicleStep> steps,
                                            const std::vector<PathSegment>& segments, const EvidenceOptions& options) {
  std::vector<SegmentEvidence> evidence;
  for (const PathSegment& segment : segments)
    evidence.push_back(segment.turning ? EvidenceOfTurn(StepsOf(steps, segment.first, segment.last), options)
                                       : SegmentEvidence{});
  const double lever_arm = MedianLeverArm(evidence);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const std::span<const VehicleStep> of_segment = StepsOf(steps, segments[i].first, segments[i].last);
    evidence[i].road = EvidenceOfRoad(of_segment, options.road);
    if (segments[i].turning) continue;
    evidence[i].straight = DirectionOnStraight(of_segment, lever_arm, options);
    if (evidence[i].straight && segments[i].road_part) ShareDirection(options, *evidence[i].straight);
  }
  return evidence;
}

std::optional<RoadEvidence> EvidenceOfRoad(std::span<const VehicleStep> steps, const RoadEvidenceOptions& options) {
  RoadEvidence road;
  std::vector<double> log_heights;
  std::vector<double> sigmas;
  for (const VehicleStep& step : steps) {
    if (!(step.height > 0)) continue;
    log_heights.push_back(std::log(step.height));
    sigmas.push_back(std::hypot(step.height_sigma, options.step_sigma));
    road.length += step.motion.step;
  }
  if (static_cast<int>(log_heights.size()) < options.min_steps) return std::nullopt;
  road.log_height = Median(log_heights);
  double information = 0;
  double spread = 1;
  for (int round = 0; round < kRoadReweightings; ++round) {
    std::vector<double> deviations;
    for (std::size_t i = 0; i < log_heights.size(); ++i)
      deviations.push_back((log_heights[i] - road.log_height) / sigmas[i]);
    spread = std::max(1.0, RobustSigma(deviations));
    information = 0;
    double sum = 0;
    for (std::size_t i = 0; i < log_heights.size(); ++i) {
      const double weight = HuberWeight(deviations[i], kRoadHuber * spread) / (sigmas[i] * sigmas[i]);
      information += weight;
      sum += weight * (log_heights[i] - road.log_height);
    }
    road.log_height += sum / information;
  }
  road.sigma = spread / std::sqrt(information);
  return road;
}

Measurement LinearizeRoad(const RoadEvidence& road, const DriveState& state, const RoadEvidenceOptions& options) {
  const double lengths = road.length * std::exp(state[kLogScale]) / options.correlation_length;
  const double mean = MeanErrorSigma(lengths);
  Measurement measurement;
  measurement.by_state[kLogHeight] = 1;
  measurement.by_state[kLogScale] = -1;
  measurement.by_state[kRoadError] = options.sigma * mean;
  measurement.innovation = road.log_height - measurement.by_state.dot(state);
  measurement.variance = road.sigma * road.sigma;
  return measurement;
}

Measurement LinearizeTurn(const PooledLine& turn, const DriveState& state, const EvidenceOptions& options) {
  const double scale = std::exp(state[kLogScale]);
  const double lever_arm = std::exp(state[kLogLeverArm]) / scale;
  const double roll = state[kRollHeight] * turn.by_roll_height / scale;
  const double slip = state[kSlip] * scale * turn.mean_square_speed;
  Measurement measurement;
  measurement.innovation = turn.lever_arm - (lever_arm + roll - slip + state[kLag] * turn.mean_speed +
                                             state[kDirection] * turn.by_direction);
  measurement.by_state[kLogScale] = -lever_arm - roll - slip;
  measurement.by_state[kDirection] = turn.by_direction;
  measurement.by_state[kSlip] = -scale * turn.mean_square_speed;
  measurement.by_state[kLag] = turn.mean_speed;
  measurement.by_state[kLogLeverArm] = lever_arm;
  measurement.by_state[kRollHeight] = turn.by_roll_height / scale;
  measurement.variance = Square(turn.sigma) + Square(options.turn_sigma * lever_arm) +
                         Square(options.slip_sigma * slip) + Square(options.turn_direction_sigma * turn.by_direction);
  return measurement;
}

Measurement LinearizeDirectionInTurn(const DirectionInTurn& turn, const DriveState& state,
                                     const EvidenceOptions& options) {
  const double scale = std::exp(state[kLogScale]);
  const double slip = state[kSlip] * scale * turn.by_slip;
  Measurement measurement;
  measurement.innovation = turn.angle - (state[kDirection] - slip + state[kLag] * turn.by_lag);
  measurement.by_state[kDirection] = 1;
  measurement.by_state[kLogScale] = -slip;
  measurement.by_state[kSlip] = -scale * turn.by_slip;
  measurement.by_state[kLag] = turn.by_lag;
  measurement.variance =
      Square(turn.sigma) + Square(options.direction_in_turn_sigma) + Square(options.slip_sigma * slip);
  return measurement;
}

Measurement LinearizeStraight(const StraightDirection& straight, const DriveState& state,
                              const EvidenceOptions& options) {
  const double scale = std::exp(state[kLogScale]);
  const double swing = straight.bend * (std::exp(state[kLogLeverArm]) / scale - straight.bend_lever_arm);
  const double slip = state[kSlip] * scale * straight.bend_square_speed;
  Measurement measurement;
  measurement.innovation = straight.angle - (state[kDirection] + swing - slip + state[kLag] * straight.bend_speed);
  measurement.by_state[kDirection] = 1;
  measurement.variance =
      Square(straight.sigma) + Square(options.straight_direction_sigma) + Square(options.bend_sigma * slip);
  return measurement;
}

std::vector<SegmentMeasurement> MeasurementsOf(const SegmentEvidence& evidence, const DriveState& state,
                                               const EvidenceOptions& options) {
  std::vector<SegmentMeasurement> measurements;
  if (evidence.road) measurements.push_back({kRoadHeight, LinearizeRoad(*evidence.road, state, options.road)});
  if (evidence.direction_in_turn)
    measurements.push_back({kDirectionInTurn, LinearizeDirectionInTurn(*evidence.direction_in_turn, state, options)});
  if (evidence.turn) measurements.push_back({kLeverArmOfTurn, LinearizeTurn(*evidence.turn, state, options)});
  if (evidence.straight)
    measurements.push_back({kDirectionOfStraight, LinearizeStraight(*evidence.straight, state, options)});
  return measurements;
}

bool SwingsInward(const PooledLine& turn, const DriveState& state) {
  return WithoutLag(turn, state).lever_arm < state[kDirection] * turn.by_direction;
}

std::string WhyUnusable(const PooledLine& turn, const DriveState& state, const EvidenceOptions& options) {
  if (SwingsInward(turn, state))
    return "the camera swings to the inside of the turn: too fast, or not ahead of the rear axle";
  const double scale = OwnScale(turn, state);
  if (!std::isfinite(scale)) return "the camera does not move outwards as the lever arm requires";
  if (LeverArmRatio(turn, LeverArmOf(state), scale) < options.min_lever_arm_ratio)
    return "too fast: side slip leaves too little of the lever arm";
  return {};
}

double OwnScale(const PooledLine& turn, const DriveState& state) {
  return MetresPerUnit(WithoutLag(turn, state), LeverArmOf(state), state[kDirection]);
}

}  // namespace turnscale
