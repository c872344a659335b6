// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "turnscale/mapping/map.h"
#include "turnscale/mapping/map_archive.h"
#include "turnscale/odometry/background.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/readjustment.h"

namespace turnscale {

/// What a readjustment has changed in the map, and what it has found beside it.
struct AppliedReadjustment {
  ReadjustedKeyframes keyframes;
  std::vector<double> factors;  ///< of lengths at keyframes `keyframes.first`...latest
  MountCalibration mount;       ///< has learned from the readjusted keyframes
  bool failed = false;          ///< the keyframes are not adjusted, as the window contains NaN
};

/// Keeps the map accurate and small during a drive: adjusts its latest keyframes once more in a large window, in the
/// background, at the end of a turn and every half a window; then moves the observations of keyframes that no
/// adjustment can change any more to the archive.
class MapUpkeep {
 public:
  explicit MapUpkeep(const OdometryOptions& options) : options_(options) {}

  /// Judges how well landmarks determine the unit of length at keyframes that enough others follow by now.
  void JudgeUnits(Map& map);

  /// Starts to adjust a copy of the keyframes that are not readjusted under the present radial correction, if the
  /// latest keyframe has ended a turn, many keyframes have not been readjusted, or that has been due before. Waits with
  /// it while another copy is being adjusted or keyframes are still to be archived.
  void StartReadjustmentIfDue(const Map& map, const MountCalibration& mount, bool turn_ended);

  /// A readjustment that is pending is due now.
  void Hurry() { readjustment_.Hurry(); }

  /// Writes the readjustment to the map that is due at the latest keyframe; waits for it. Empty if none is.
  std::optional<AppliedReadjustment> ApplyIfDue(Map& map);

  /// Readjusts the keyframes that are not, at once. None may be pending.
  AppliedReadjustment ReadjustNow(const MountCalibration& mount, Map& map);

  /// Archives a part of the keyframes that are due, so that no frame waits for all of them. Returns the new index of
  /// each landmark, -1 for those that left the map; empty if no keyframe is due.
  std::optional<std::vector<int>> ArchiveNextPart(Map& map);
  /// The same with all keyframes. No readjustment may be pending.
  std::vector<int> ArchiveAll(Map& map);

  const MapArchive& archive() const { return archive_; }
  MapArchive& archive() { return archive_; }

 private:
  /// The first keyframe of the map within a window that has not been readjusted, or was under a radial correction that
  /// is out of date.
  int FirstToReadjust(const Map& map) const;
  AppliedReadjustment Apply(ReadjustmentResult result, Map& map);
  std::vector<int> Archive(int last, Map& map);

  OdometryOptions options_;
  MapArchive archive_;
  int archive_due_ = 0;  ///< keyframes before this one go to the archive, part by part
  int unit_judged_ = 0;  ///< keyframes before this one have their pixel_unit_variance
  /// Radial correction under which each keyframe was readjusted; NaN for those that were left out.
  std::vector<double> readjusted_under_;
  bool readjustment_is_due_ = false;
  DueResult<ReadjustmentResult> readjustment_;
};

}  // namespace turnscale
