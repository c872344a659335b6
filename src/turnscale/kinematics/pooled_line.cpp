// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/pooled_line.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <iterator>
#include <utility>

#include <Eigen/Core>

#include "turnscale/base/check_part.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/base/robust_weights.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr int kMaxIterations = 100;
constexpr double kRelativeTolerance = 1e-14;

// The slope that minimises the sum of absolute residuals.
double MedianSlope(const std::vector<LinePoint>& points) {
  std::vector<std::pair<double, double>> slopes;
  for (const LinePoint& point : points)
    if (point.x != 0) slopes.emplace_back(point.y / point.x, std::abs(point.x));
  return WeightedMedian(std::move(slopes));
}

// Robust standard deviation of the residuals. One parameter was fitted to them: the factor keeps three or four points
// from looking better than they are.
double ResidualSpread(const std::vector<LinePoint>& points, double slope) {
  std::vector<double> residuals;
  residuals.reserve(points.size());
  for (const LinePoint& point : points) residuals.push_back(point.y - slope * point.x);
  const double n = static_cast<double>(points.size());
  return RobustSigma(std::move(residuals)) * std::sqrt(n / std::max(n - 1.0, 1.0));
}

double SigmaOfSlope(const std::vector<LinePoint>& points, const RobustLine& line, double noise_floor) {
  double weights = 0;
  double scatter = 0;
  double leverage = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double w = line.weight[i];
    const double residual = points[i].y - line.slope * points[i].x;
    weights += w;
    scatter += w * residual * residual;
    leverage += w * points[i].x * points[i].x;
  }
  const double variance = weights > 1.0 ? scatter / (weights - 1.0) : 0.0;
  return std::max(std::sqrt(variance), noise_floor) / std::sqrt(leverage);
}

/// Where a weight falls below this the step disagrees rather than scatters.
constexpr double kInlierWeight = 0.1;

PooledLineResult NoLine(std::string reason) { return {std::nullopt, std::move(reason)}; }

std::string Text(const char* format, double a, double b) {
  char text[200];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

// Least length that acts in a turn, over the lever arm.
constexpr double kLeastLength = 0.1;
// Greatest height above the axis of roll, over the lever arm.
constexpr double kMostRollHeight = 4;

// The lever arm with what the roll of the body adds to it in this turn, metres.
double LengthIn(const PooledLine& line, const LeverArm& lever_arm) {
  return std::max(lever_arm.length + line.by_roll_height * lever_arm.roll_height, kLeastLength * lever_arm.length);
}

bool IsFinite(const VehicleStep& step) {
  const TurningMotion& motion = step.motion;
  return std::isfinite(motion.psi) && std::isfinite(step.lateral()) && std::isfinite(step.roll) &&
         std::isfinite(step.square_speed_ratio) && motion.step >= 0;
}

std::vector<VehicleStep> Usable(std::span<const VehicleStep> steps) {
  std::vector<VehicleStep> usable;
  std::ranges::copy_if(steps, std::back_inserter(usable), &VehicleStep::shows_kinematics);
  return usable;
}

// Height above the axis of roll (odometry units) that fits the residuals of the line best.
double RollHeight(const std::vector<VehicleStep>& steps, const std::vector<LinePoint>& points, const RobustLine& fit) {
  double xx = 0;
  double xr = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    xx += fit.weight[i] * points[i].x * points[i].x;
    xr += fit.weight[i] * points[i].x * steps[i].roll;
  }
  double ry = 0;
  double rr = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    // What of the roll the turning does not explain.
    const double roll = steps[i].roll - xr / xx * points[i].x;
    ry += fit.weight[i] * roll * (points[i].y - fit.slope * points[i].x);
    rr += fit.weight[i] * roll * roll;
  }
  return rr > 0 ? std::clamp(ry / rr, 0.0, kMostRollHeight * std::abs(fit.slope)) : 0.0;
}

constexpr int kDirectionReweightings = 20;
constexpr double kDirectionHuber = 1.5;  // robust standard deviations

// What of a vector is orthogonal to another.
Eigen::VectorXd Orthogonal(const Eigen::VectorXd& vector, const Eigen::VectorXd& other) {
  const double square = other.squaredNorm();
  return square > 0 ? Eigen::VectorXd(vector - vector.dot(other) / square * other) : vector;
}

// Columns: x, roll, way forward; and the lateral displacements.
struct TurnColumns {
  Eigen::Matrix<double, Eigen::Dynamic, 3> explained;
  Eigen::VectorXd lateral;
  Eigen::VectorXd slip;
  Eigen::VectorXd lag;
};

TurnColumns ColumnsOf(const std::vector<VehicleStep>& steps) {
  const auto n = static_cast<Eigen::Index>(steps.size());
  TurnColumns columns{Eigen::Matrix<double, Eigen::Dynamic, 3>(n, 3), Eigen::VectorXd(n), Eigen::VectorXd(n),
                      Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const VehicleStep& step = steps[i];
    columns.explained.row(i) << step.swing(), step.roll, step.forward();
    columns.lateral[i] = step.lateral();
    columns.slip[i] = step.swing() * step.signed_square_speed();
    columns.lag[i] = step.swing() * step.signed_speed();
  }
  return columns;
}

PooledLine Describe(const std::vector<VehicleStep>& steps, const RobustLine& fit, double roll_height) {
  PooledLine line;
  line.sigma = fit.sigma;
  line.steps = static_cast<int>(steps.size());
  double xx = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double x = steps[i].swing();
    xx += fit.weight[i] * x * x;
    line.by_direction += fit.weight[i] * x * steps[i].forward();
    line.by_roll_height += fit.weight[i] * x * steps[i].roll;
    line.mean_square_speed += fit.weight[i] * x * x * steps[i].signed_square_speed();
    line.mean_speed += fit.weight[i] * x * x * steps[i].signed_speed();
    line.angle += steps[i].motion.psi;
    if (fit.weight[i] >= kInlierWeight) ++line.inliers;
  }
  line.by_direction /= xx;
  line.by_roll_height /= xx;
  line.mean_square_speed /= xx;
  line.mean_speed /= xx;
  line.lever_arm = fit.slope + roll_height * line.by_roll_height;
  return line;
}

}  // namespace

RobustLine FitRobustLine(const std::vector<LinePoint>& points, double noise_floor, double threshold) {
  RobustLine line;
  line.weight.assign(points.size(), 0.0);
  line.slope = MedianSlope(points);
  // The width stays as the start gives it: with it fixed, the iteration goes down to one minimum.
  const double width = threshold * std::max(ResidualSpread(points, line.slope), noise_floor);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    double xy = 0;
    double xx = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto& [x, y] = points[i];
      line.weight[i] = TukeyWeight(y - line.slope * x, width);
      xy += line.weight[i] * x * y;
      xx += line.weight[i] * x * x;
    }
    const double previous = std::exchange(line.slope, xy / xx);
    if (std::abs(line.slope - previous) <= kRelativeTolerance * std::abs(previous)) break;
  }
  line.sigma = SigmaOfSlope(points, line, noise_floor);
  return line;
}

void PooledLineOptions::Check() const {
  Require(std::isfinite(sigma_theta) && sigma_theta > 0, "sigma_theta_deg: has to be positive");
  Require(std::isfinite(robust_threshold) && robust_threshold > 0, "robust_threshold: has to be positive");
  Require(min_inliers >= 1, "min_inliers: has to be at least 1");
  Require(std::isfinite(sigma_psi) && sigma_psi >= 0, "sigma_psi_deg: must not be negative");
  Require(min_forward_share > 0 && min_forward_share < 1, "min_forward_share: has to be above 0 and below 1");
  Require(std::isfinite(min_angle) && min_angle >= 0, "min_angle_deg: must not be negative");
}

double LateralNoise(std::span<const VehicleStep> steps, double sigma_theta) {
  double sum = 0;
  for (const VehicleStep& step : steps) sum += step.motion.step * step.motion.step;
  return sigma_theta * std::sqrt(sum / static_cast<double>(steps.size()));
}

PooledLineResult PoolTurn(std::span<const VehicleStep> all_steps, const PooledLineOptions& options) {
  options.Check();
  if (!std::ranges::all_of(all_steps, IsFinite)) return NoLine("a step is not a number");
  const std::vector<VehicleStep> steps = Usable(all_steps);
  if (steps.empty())
    return NoLine(std::ranges::any_of(all_steps, &VehicleStep::usable) ? "its poses are too far apart" : "no steps");
  const double noise_floor = LateralNoise(steps, options.sigma_theta);
  if (noise_floor == 0) return NoLine("the camera stands still");
  std::vector<LinePoint> points;
  points.reserve(steps.size());
  for (const VehicleStep& step : steps) points.push_back({step.swing(), step.lateral()});
  if (std::ranges::all_of(points, [](const LinePoint& point) { return point.x == 0; })) return NoLine("no turning");
  RobustLine fit = FitRobustLine(points, noise_floor, options.robust_threshold);
  if (!std::isfinite(fit.slope)) return NoLine("the steps are inconsistent");
  const double roll_height = RollHeight(steps, points, fit);
  for (std::size_t i = 0; i < steps.size(); ++i) points[i].y -= roll_height * steps[i].roll;
  fit = FitRobustLine(points, noise_floor, options.robust_threshold);
  if (!std::isfinite(fit.slope)) return NoLine("the steps are inconsistent");

  const PooledLine line = Describe(steps, fit, roll_height);
  if (line.inliers < std::max(options.min_inliers, (line.steps + 1) / 2)) {
    return NoLine(Text("only %.0f of %.0f steps are inliers", line.inliers, line.steps));
  }
  double inlier_angle = 0;
  for (std::size_t i = 0; i < steps.size(); ++i)
    if (fit.weight[i] >= kInlierWeight) inlier_angle += std::abs(steps[i].motion.psi);
  if (inlier_angle < options.min_angle) {
    return NoLine(Text("the inlier steps turn by %.1f deg, less than %.1f", inlier_angle * kDegreesPerRadian,
                       options.min_angle * kDegreesPerRadian));
  }
  return {line, {}};
}

// Least squares in which x and the roll are taken out of both sides first. The weights are its own: with a wrong
// direction, the long steps at the ends of the turn, which show it, are the outliers of the line without it.
std::optional<DirectionInTurn> FitDirectionInTurn(std::span<const VehicleStep> all_steps,
                                                  const PooledLineOptions& options) {
  const std::vector<VehicleStep> steps = Usable(all_steps);
  const auto freedom = static_cast<double>(steps.size()) - 3;
  if (!(freedom > 0)) return std::nullopt;
  const double noise_floor = LateralNoise(steps, options.sigma_theta);
  const TurnColumns columns = ColumnsOf(steps);
  Eigen::ArrayXd root_weights = Eigen::ArrayXd::Ones(columns.lateral.size());
  DirectionInTurn direction;
  for (int i = 0; i < kDirectionReweightings; ++i) {
    const auto weighted = [&](const auto& column) -> Eigen::VectorXd { return column.array() * root_weights; };
    const Eigen::VectorXd swing = weighted(columns.explained.col(0));
    const Eigen::VectorXd roll = Orthogonal(weighted(columns.explained.col(1)), swing);
    const auto unexplained = [&](const auto& column) { return Orthogonal(Orthogonal(weighted(column), swing), roll); };
    const Eigen::VectorXd whole_way = weighted(columns.explained.col(2));
    const Eigen::VectorXd forward = unexplained(columns.explained.col(2));
    const Eigen::VectorXd lateral = unexplained(columns.lateral);
    const double square = forward.squaredNorm();
    const double share = square / whole_way.squaredNorm();
    if (!(share > options.min_forward_share)) return std::nullopt;
    direction.angle = forward.dot(lateral) / square;
    direction.by_slip = forward.dot(unexplained(columns.slip)) / square;
    direction.by_lag = forward.dot(unexplained(columns.lag)) / square;
    const Eigen::ArrayXd off = (lateral - direction.angle * forward).array();
    const double spread = std::max(off.matrix().norm() / std::sqrt(freedom), noise_floor);
    // The noise of psi moves x, and with it the part of the way that x does not explain, towards the mean direction of
    // travel in the turn.
    const double psi_noise = options.sigma_psi * std::sqrt(root_weights.square().sum()) / swing.norm();
    const double travel = weighted(columns.lateral).dot(whole_way) / whole_way.squaredNorm() - direction.angle;
    direction.sigma = std::hypot(spread / std::sqrt(square), travel * psi_noise * psi_noise / share);
    std::vector<double> residuals(off.size());
    Eigen::ArrayXd::Map(residuals.data(), off.size()) = off / root_weights;
    const double width = kDirectionHuber * std::max(RobustSigma(residuals), noise_floor);
    for (Eigen::Index k = 0; k < off.size(); ++k) root_weights[k] = std::sqrt(HuberWeight(residuals[k] / width, 1));
  }
  return direction;
}

double MetresPerUnit(const PooledLine& line, const LeverArm& lever_arm, double direction) {
  // Solved for 1/lambda, which passes through 0 where lambda passes through infinity.
  const double linear = line.lever_arm - direction * line.by_direction;
  const double slip = lever_arm.side_slip * line.mean_square_speed;
  const double length = LengthIn(line, lever_arm);
  const double root = std::sqrt(linear * linear + 4.0 * slip * length);
  // No cancellation where the camera swings the wrong way.
  const double inverse = linear >= 0 ? (linear + root) / (2.0 * length) : 2.0 * slip / (root - linear);
  return inverse > 0 ? 1.0 / inverse : std::numeric_limits<double>::infinity();
}

double LeverArmRatio(const PooledLine& line, const LeverArm& lever_arm, double metres_per_unit) {
  return 1.0 - lever_arm.side_slip * line.mean_square_speed * metres_per_unit * metres_per_unit / lever_arm.length;
}

MedianScale MedianOfSteps(const std::vector<VehicleStep>& steps, const LeverArm& lever_arm) {
  std::vector<std::pair<double, double>> inverse_scales;
  for (const VehicleStep& step : steps) {
    if (!step.usable || step.swing() == 0) continue;
    const PooledLine alone{.lever_arm = step.lateral() / step.swing(), .mean_square_speed = step.signed_square_speed()};
    inverse_scales.emplace_back(1.0 / MetresPerUnit(alone, lever_arm), 1.0);
  }
  MedianScale scale;
  if (inverse_scales.empty()) return scale;
  const double median = WeightedMedian(inverse_scales);
  scale.metres_per_unit = 1.0 / median;
  for (auto& [value, weight] : inverse_scales) value = std::abs(value - median);
  const double spread = kSigmaPerMad * WeightedMedian(std::move(inverse_scales));
  scale.spread = std::abs(spread / median);
  return scale;
}

}  // namespace turnscale
