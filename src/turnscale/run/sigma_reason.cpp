// SPDX-License-Identifier: MIT
#include "turnscale/run/sigma_reason.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include <fmt/format.h>

#include "turnscale/base/quantiles.h"
#include "turnscale/geometry/angle.h"
#include "turnscale/run/impossible_direction.h"
#include "turnscale/run/impossible_motion.h"
#include "turnscale/run/missing_path.h"

namespace turnscale {
namespace {

// Of the variance, from which on a contribution is named.
constexpr double kNamedShare = 0.2;

struct Contribution {
  double sigma = 0;  // relative
  std::string text;
};

std::string CauseInImages(const DriveFacts& drive, const RefinedScale& scale) {
  if (!scale.contradicted_calibration.empty()) return "the images contradict the calibration";
  // By more than half of the variance.
  if (2 * scale.doubt_sigma * scale.doubt_sigma > scale.calibration_sigma * scale.calibration_sigma)
    return "the images leave the calibration in doubt";
  if (drive.images.blending) return "the images are blended";
  return "the focal length is not known exactly";
}

// What the turns, or without one the height of the camera, tell by themselves.
std::string EvidenceText(const RefinedScale& scale) {
  double angle = 0;
  std::vector<double> sigmas;
  for (const TurnResult& turn : scale.turns) {
    if (!turn.used) continue;
    angle += std::abs(turn.angle);
    if (turn.own > 0) sigmas.push_back(turn.own_sigma / turn.own);
  }
  const auto used = std::ranges::count_if(scale.turns, &TurnResult::used);
  if (used == 0) return "no turn is used, and the height of the camera alone tells the scale";
  const std::string alone = sigmas.empty() ? std::string() : fmt::format(", +-{:.0f} % alone", 100 * Median(sigmas));
  if (used == 1) return fmt::format("only one turn is used, of {:.0f} deg{}", InDegrees(angle), alone);
  return fmt::format("few turns: {} are used, of {:.0f} deg in all{}", used, InDegrees(angle),
                     sigmas.empty() ? std::string() : fmt::format(" (each{} in the median)", alone.substr(1)));
}

std::vector<Contribution> Contributions(const DriveFacts& drive, const RefinedScale& scale, const PathSummary& path) {
  const ScaleEstimate& estimate = *scale.estimate;
  const double length = std::max(path.distance, 1e-9);
  std::vector<Contribution> parts;
  parts.push_back({scale.calibration_sigma, CauseInImages(drive, scale)});
  if (estimate.uses_single_turns)
    parts.push_back({std::max(estimate.single_turn_spread, estimate.test.disagreement),
                     fmt::format("the turns disagree by {:.0f} %",
                                 100 * std::max(estimate.single_turn_spread, estimate.test.disagreement))});
  else if (estimate.slip_conflict)
    parts.push_back({estimate.test.disagreement, "the turns show an unusual side slip"});
  if (estimate.height_conflict)
    parts.push_back({estimate.height_conflict->scale_sigma(), "lever arm and camera height disagree"});
  if (scale.unusual_height)
    parts.push_back(
        {scale.unusual_height->scale_error, fmt::format("the estimated height of the camera is unusually {}",
                                                        scale.unusual_height->is_low ? "low" : "high")});
  if (estimate.image_lag)
    parts.push_back(
        {estimate.image_lag->scale_error, "the images may be stabilised, or the principal point a little off"});
  if (estimate.image_smoothing)
    parts.push_back({estimate.image_smoothing->scale_error, "the images seem to be stabilised"});
  parts.push_back(
      {scale.gap_sigma / length, fmt::format("{:.1f} s of the path are not measured", TotalSeconds(path.missing))});
  if (path.beginning) parts.push_back({path.beginning->length / length, "the path begins late"});
  if (path.uncertain)
    parts.push_back({path.uncertain->length_error() / length,
                     fmt::format("the scale is hardly known for {:.1f} s", path.uncertain->seconds)});
  parts.push_back({std::hypot(LengthErrorOf(path.impossible), LengthErrorOf(path.impossible_directions)) / length,
                   "parts of the path are as no car drives"});
  return parts;
}

// Where the scale is known worst along the drive: between turns it drifts.
std::string FarText(const RefinedScale& scale, const std::vector<FrameResult>& frames, double worst_time,
                    double first_time) {
  double nearest = HUGE_VAL;
  const auto time_of = [&](int number) -> std::optional<double> {
    const auto frame = std::ranges::lower_bound(frames, number, {}, &FrameResult::frame);
    return frame == frames.end() ? std::nullopt : std::optional(frame->time);
  };
  for (const TurnResult& turn : scale.turns) {
    const std::optional<double> first = time_of(turn.first_frame);
    const std::optional<double> last = time_of(turn.last_frame);
    if (turn.used && first && last)
      nearest = std::min(nearest, std::max({0.0, *first - worst_time, worst_time - *last}));
  }
  if (!std::isfinite(nearest)) return "no turn is used, and the scale drifts along the drive";
  if (nearest == 0)
    return fmt::format("at {:.1f} s it follows from one turn, which tells little", worst_time - first_time);
  return fmt::format("at {:.1f} s the nearest turn that is used is {:.0f} s away, and the scale drifts between turns",
                     worst_time - first_time, nearest);
}

}  // namespace

std::string SigmaReason(const DriveFacts& drive, const std::vector<FrameResult>& frames, const RefinedScale& scale,
                        const PathSummary& path, const ScaleSummary& summary) {
  if (!scale.estimate || std::max(summary.path_sigma, summary.worst_sigma) <= kExplainedSigma) return {};
  std::vector<Contribution> parts = Contributions(drive, scale, path);
  double rest = summary.path_sigma * summary.path_sigma;
  const double least = kNamedShare * rest;
  for (const Contribution& part : parts) rest -= part.sigma * part.sigma;
  parts.push_back({std::sqrt(std::max(rest, 0.0)), EvidenceText(scale)});
  std::ranges::stable_sort(parts, std::ranges::greater(), &Contribution::sigma);
  parts.erase(std::find_if(parts.begin() + 1, parts.end(),
                           [&](const Contribution& part) { return part.sigma * part.sigma < least; }),
              parts.end());
  if (summary.path_sigma <= kExplainedSigma) parts.clear();
  // The scale of a part of the path may be known much worse than the whole length.
  constexpr double kMuchLarger = 1.5;
  if (parts.empty() || summary.worst_sigma > kMuchLarger * summary.path_sigma)
    parts.push_back({summary.worst_sigma, FarText(scale, frames, summary.worst_sigma_time, drive.given.first_time)});
  std::string text;
  for (const Contribution& part : parts) text += (text.empty() ? "" : "; ") + part.text;
  return text;
}

}  // namespace turnscale
