// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/geometry/angle.h"

namespace turnscale {

struct TurnDetectorOptions {
  /// psi_th of Algorithm 1: least turning angle of a keyframe step, rad (1.5 deg). High enough to leave out the bends
  /// of a straight road, low enough for the gentle turns of a car whose keyframes are 0.1 s apart.
  double min_step_angle = 1.5 / kDegreesPerRadian;
  /// n_th: least number of such steps in a region.
  int min_steps = 4;
  /// Least angle of the whole region, rad (15 deg): less than that is a bend of the road, which has little
  /// information for the line fit.
  double min_region_angle = 15.0 / kDegreesPerRadian;
  /// A turn continues over this many consecutive weaker steps. The paper has 0: one weak step between strong ones then
  /// divides a street corner in two.
  int max_weak_steps = 1;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Keyframe steps first..last, counted from 0 in the order they were added: the paper's F_t.
struct TurningRegion {
  int first = 0;
  int last = 0;
  double angle = 0;  ///< sum of psi, rad, positive to the right

  bool operator==(const TurningRegion&) const = default;
};

/// Algorithm 1 with its counter corrected (it is read before it is reset), over a stream of keyframe steps. All strong
/// steps of a region turn the same way: an S gives two regions.
class TurnDetector {
 public:
  explicit TurnDetector(const TurnDetectorOptions& options);

  /// Takes the turning angle (rad) of the next keyframe step. Gives the region that this step closes.
  std::optional<TurningRegion> Add(double psi);

  /// The next keyframe step was not measured (tracking was lost): it counts, and no region goes on across it.
  std::optional<TurningRegion> AddUnmeasured();

  /// The current region, up to its latest strong step; empty if there is none long enough.
  std::optional<TurningRegion> open() const;

  /// The first step that a future region may contain: that of the current run, however short, or the next step.
  int first_undecided() const { return strong_steps_ > 0 ? candidate_.first : steps_; }

  /// Closes the region that is still open, at the end of the drive or where the caller wants it to end.
  std::optional<TurningRegion> Finish();

 private:
  TurnDetectorOptions options_;
  int steps_ = 0;
  int strong_steps_ = 0;
  bool to_right_ = false;  ///< the way the strong steps turn
  int weak_steps_ = 0;     ///< since the last strong step
  double weak_angle_ = 0;
  TurningRegion candidate_;
};

}  // namespace turnscale
