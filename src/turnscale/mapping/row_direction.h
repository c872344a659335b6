// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/mapping/calibration_check_options.h"
#include "turnscale/mapping/intrinsics_estimate.h"
#include "turnscale/mapping/intrinsics_evidence.h"
#include "turnscale/mapping/intrinsics_prior.h"
#include "turnscale/mapping/window_reading.h"

namespace turnscale {

/// In which rows follow one another: as in the camera, across that (Across), or either.
enum class RowDirection { kAlong, kAcross, kOpen };

/// Test of the direction in which the sensor reads its rows, for a video that was rotated and encoded anew. Where
/// windows leave what is expected of the intrinsics in doubt, they are read once more with rows across the camera's
/// read direction, each direction with an estimate of its own. The one that explains residuals, windows and prior
/// clearly better counts: by the square of CalibrationCheckOptions::significance in twice the log-likelihood.
class RowDirectionChoice {
 public:
  /// After a window was added to those read as in the camera, `along`; always with the same prior. Reads that one
  /// across if there is reason to, and a few of those before that were not.
  void Update(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior, const WindowReadings& along);

  /// Along, until windows show another.
  RowDirection direction() const { return direction_; }
  /// The latest of the windows with rows across, in their order; empty while there is no reason to read them.
  const WindowReadings& across() const { return across_; }

 private:
  bool ReadAcross(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior, const IntrinsicsEstimate& along,
                  ReadingPlace place, const IntrinsicsProblem& window);
  void Compare(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior, const WindowReadings& along);

  WindowReadings across_;
  RowDirection direction_ = RowDirection::kAlong;
  bool is_clearly_along_ = false;  ///< no more windows are read across
  bool reads_earlier_ = true;      ///< ones across
};

}  // namespace turnscale
