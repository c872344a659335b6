// SPDX-License-Identifier: MIT
#include "turnscale/scale/car_conflicts.h"

#include <cmath>

#include <Eigen/Cholesky>

namespace turnscale {
namespace {

// The given height as a measurement: the part of ln(H) that is independent of the other unknowns in the prior. With
// their own prior, it is the joint prior.
Measurement GivenHeight(const ScaleBelief& prior) {
  const DriveState information = prior.covariance.llt().solve(DriveState::Unit(kLogHeight));
  Measurement given;
  given.variance = 1 / information[kLogHeight];
  given.by_state = given.variance * information.transpose();
  return given;
}

}  // namespace

std::optional<HeightConflict> CompareHeight(const ScaleBelief& posterior, const CarPrior& car, double max_deviation) {
  if (!car.knows_height() || !(car.camera_height_sigma > 0)) return std::nullopt;
  const ScaleBelief prior = PriorBelief(car, 0);
  const Measurement given = GivenHeight(prior);
  const double variance = given.by_state.dot(posterior.covariance * given.by_state.transpose());
  constexpr double kLeastShare = 1e-3;  // of the information, below which what the drive adds is rounding
  if (!((1 + kLeastShare) * variance < given.variance)) return std::nullopt;
  Measurement taken_out = given;
  taken_out.variance = -given.variance;
  const ScaleBelief without = Updated(posterior, taken_out, 1, prior.mean);
  if (!(ChiSquared(without, given, 1, prior.mean) > max_deviation * max_deviation)) return std::nullopt;
  const double found = std::exp(without.mean[kLogHeight]);
  return HeightConflict{car.camera_height, car.camera_height_sigma, found, without.Sigma(kLogHeight) * found};
}

bool TurnsContradictYaw(std::span<const WeightedDirection> directions, const ScaleBelief& posterior,
                        double shared_sigma, double max_deviation) {
  // Relative to the posterior's mean: information and weighted sum of all that the posterior has but the turns, and of
  // the turns with unit weights.
  double others = 1 / posterior.covariance(kDirection, kDirection);
  double others_sum = 0;
  double turns = 0;
  double turns_sum = 0;
  for (const WeightedDirection& direction : directions) {
    const Measurement& measurement = direction.measurement;
    others -= direction.weight / measurement.variance;
    others_sum -= direction.weight / measurement.variance * measurement.innovation;
    const double own = 1 / (measurement.variance - shared_sigma * shared_sigma);
    turns += own;
    turns_sum += own * measurement.innovation;
  }
  if (!(others > 0 && turns > 0)) return false;
  const double variance = 1 / turns + shared_sigma * shared_sigma + 1 / others;
  return std::abs(turns_sum / turns - others_sum / others) > max_deviation * std::sqrt(variance);
}

bool ContradictsYaw(const ScaleBelief& posterior, double prior_sigma, double max_deviation) {
  const double difference = posterior.mean[kDirection];
  const double variance = prior_sigma * prior_sigma - posterior.covariance(kDirection, kDirection);
  return variance > 0 && difference * difference > max_deviation * max_deviation * variance;
}

}  // namespace turnscale
