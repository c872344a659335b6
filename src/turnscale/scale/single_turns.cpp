// SPDX-License-Identifier: MIT
#include "turnscale/scale/single_turns.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

// Marks the turns that are used with single-turn scales: not those whose sigma is much larger than the smallest.
void MarkUsed(double max_sigma_ratio, std::vector<TurnEstimate>& turns) {
  const auto has_scale = [](const TurnEstimate& turn) { return turn.used && std::isfinite(turn.as_given); };
  double best_sigma = std::numeric_limits<double>::infinity();
  for (const TurnEstimate& turn : turns)
    if (has_scale(turn)) best_sigma = std::min(best_sigma, turn.as_given_relative_sigma);
  for (TurnEstimate& turn : turns)
    turn.used_singly = has_scale(turn) && turn.as_given_relative_sigma <= max_sigma_ratio * best_sigma;
}

// A turn that is used.
struct Node {
  std::size_t piece;  // of the drive, between losses of tracking
  double place;       // along the path
  double difference;  // ln(as given / smoothed)
};

// Between nodes of the same piece in proportion to the way, beyond them as at the next one; 0 in a piece without any.
double DifferenceAt(const std::vector<Node>& nodes, std::size_t piece, double place) {
  const auto after = std::ranges::lower_bound(nodes, std::pair(piece, place), {},
                                              [](const Node& node) { return std::pair(node.piece, node.place); });
  const bool has_after = after != nodes.end() && after->piece == piece;
  const bool has_before = after != nodes.begin() && (after - 1)->piece == piece;
  if (!has_after) return has_before ? (after - 1)->difference : 0.0;
  if (!has_before) return after->difference;
  const Node& before = *(after - 1);
  const double share = (place - before.place) / (after->place - before.place);
  return (1 - share) * before.difference + share * after->difference;
}

double SpreadAbout(double centre, const std::vector<std::pair<double, double>>& weighted) {
  double squares = 0;
  double weights = 0;
  for (const auto& [value, weight] : weighted) {
    squares += weight * (value - centre) * (value - centre);
    weights += weight;
  }
  return std::sqrt(squares / weights);
}

}  // namespace

bool UseSingleTurns(double max_sigma_ratio, ScaleEstimate& estimate) {
  MarkUsed(max_sigma_ratio, estimate.turns);
  std::vector<std::size_t> pieces;
  for (const PathSegment& segment : estimate.segments)
    pieces.push_back((pieces.empty() ? 0 : pieces.back()) + (segment.gap_sigma > 0 ? 1 : 0));
  std::vector<Node> nodes;
  std::vector<std::pair<double, double>> differences;
  for (const TurnEstimate& turn : estimate.turns) {
    if (!turn.used_singly) continue;
    const double difference = std::log(turn.as_given) - estimate.smoothed[turn.segment].mean[kLogScale];
    nodes.push_back({pieces[turn.segment], estimate.segments[turn.segment].middle, difference});
    differences.emplace_back(difference, std::abs(turn.angle));
  }
  if (nodes.empty()) return false;
  const double centre = WeightedMedian(differences);
  const double spread = std::hypot(SpreadAbout(centre, differences), estimate.test.disagreement);
  for (std::size_t i = 0; i < estimate.segments.size(); ++i) {
    const double difference = DifferenceAt(nodes, pieces[i], estimate.segments[i].middle);
    const double sigma = std::max(spread, std::abs(difference - centre));
    estimate.smoothed[i].mean[kLogScale] += difference;
    estimate.smoothed[i].covariance(kLogScale, kLogScale) += sigma * sigma;
  }
  estimate.single_turn_spread = spread;
  estimate.single_turn_offset = centre;
  estimate.length_sigma = std::hypot(estimate.length_sigma, spread);
  return true;
}

}  // namespace turnscale
