// SPDX-License-Identifier: MIT
#include "turnscale/odometry/map_upkeep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/mapping/local_bundle_adjustment.h"
#include "turnscale/mapping/map_scaling.h"
#include "turnscale/mapping/unit_variance.h"

namespace turnscale {
namespace {

// A change of the lens correction by which a turn's scale changes by some per cent: poses adjusted under another one
// are adjusted anew when the next turn ends.
constexpr double kStaleLensChange = 2e-3;

// Keyframes that go to the archive together, at least.
constexpr int kLeastArchived = 20;

// Keyframes that follow one before it is judged how well landmarks determine the unit of length there.
constexpr int kKeyframesOfUnit = 10;

// Keyframes that are added between the start of a readjustment and the use of its result. In a turn, where they are
// close to one another, a large window takes about as long as four of them.
constexpr int kKeyframesOfReadjustment = 6;

}  // namespace

void MapUpkeep::JudgeUnits(Map& map) {
  for (; unit_judged_ + kKeyframesOfUnit < CountKeyframes(map); ++unit_judged_)
    map.keyframes[unit_judged_].pixel_unit_variance = UnitVariance(map, unit_judged_, kKeyframesOfUnit).value_or(0.0);
}

void MapUpkeep::StartReadjustmentIfDue(const Map& map, const MountCalibration& mount, bool turn_ended) {
  const int not_readjusted = CountKeyframes(map) - static_cast<int>(readjusted_under_.size());
  const bool many = !readjustment_.pending() && not_readjusted >= options_.turn_bundle.window / 2;
  readjustment_is_due_ = readjustment_is_due_ || turn_ended || many;
  // The archive takes its keyframes first: it renumbers the landmarks, by whose numbers the window is written back.
  if (!readjustment_is_due_ || readjustment_.pending() || archive_due_ > archive_.end()) return;
  readjustment_is_due_ = false;
  readjustment_.Start(CountKeyframes(map) + kKeyframesOfReadjustment,
                      [options = options_.turn_bundle,
                       work = WorkToReadjust(options_.turn_bundle, map, mount, FirstToReadjust(map))]() mutable {
                        return Readjusted(options, std::move(work));
                      });
}

std::optional<AppliedReadjustment> MapUpkeep::ApplyIfDue(Map& map) {
  std::optional<ReadjustmentResult> result = readjustment_.TakeIfDue(CountKeyframes(map));
  if (!result) return std::nullopt;
  return Apply(*std::move(result), map);
}

AppliedReadjustment MapUpkeep::ReadjustNow(const MountCalibration& mount, Map& map) {
  Ensure(!readjustment_.pending(), "a readjustment that is pending comes first");
  readjustment_is_due_ = false;
  const LocalBundleOptions& options = options_.turn_bundle;
  return Apply(Readjusted(options, WorkToReadjust(options, map, mount, FirstToReadjust(map))), map);
}

int MapUpkeep::FirstToReadjust(const Map& map) const {
  const auto is_up_to_date = [&](double correction) {
    return std::abs(correction - map.camera.radial_correction) < kStaleLensChange;
  };
  const int oldest = std::max(archive_.end(), CountKeyframes(map) - options_.turn_bundle.window);
  const int readjusted = static_cast<int>(readjusted_under_.size());
  if (oldest >= readjusted) return oldest;
  const auto first = std::find_if_not(readjusted_under_.begin() + oldest, readjusted_under_.end(), is_up_to_date);
  return static_cast<int>(first - readjusted_under_.begin());
}

AppliedReadjustment MapUpkeep::Apply(ReadjustmentResult result, Map& map) {
  const int first = result.first;
  readjusted_under_.resize(result.end, std::numeric_limits<double>::quiet_NaN());
  std::fill(readjusted_under_.begin() + first, readjusted_under_.end(), result.radial_correction);
  const std::vector<Eigen::Vector3d> before = KeyframeCentres(map, first);
  if (result.window) WriteBack(*result.window, map);
  std::vector<double> factors =
      KeyframeFactors(before, KeyframeCentres(map, first), 0, std::vector(before.size(), 1.0));
  const auto reach = [](const LocalBundleOptions& window) { return window.window + window.anchors; };
  const int last =
      CountKeyframes(map) - std::max({reach(options_.turn_bundle), reach(options_.local_bundle), options_.lens.window,
                                      options_.calibration_check.window, kKeyframesOfUnit});
  if (last - archive_.end() >= kLeastArchived) archive_due_ = last;
  return {.keyframes = {.first = first, .end = result.end, .final_before = last},
          .factors = std::move(factors),
          .mount = std::move(result.mount),
          .failed = !result.window};
}

std::optional<std::vector<int>> MapUpkeep::ArchiveNextPart(Map& map) {
  const int due = archive_due_ - archive_.end();
  if (due <= 0) return std::nullopt;
  const int parts = (due + MapArchive::kMostKeyframes - 1) / MapArchive::kMostKeyframes;
  return Archive(archive_.end() + due / parts, map);
}

std::vector<int> MapUpkeep::ArchiveAll(Map& map) { return Archive(CountKeyframes(map), map); }

std::vector<int> MapUpkeep::Archive(int last, Map& map) {
  Ensure(!readjustment_.pending(), "landmarks are renumbered while a window is adjusted");
  return archive_.Retire(last, map);
}

}  // namespace turnscale
