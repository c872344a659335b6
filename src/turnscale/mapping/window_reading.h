// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "turnscale/geometry/pinhole.h"
#include "turnscale/mapping/calibration_check_options.h"
#include "turnscale/mapping/intrinsics_change.h"
#include "turnscale/mapping/intrinsics_estimate.h"
#include "turnscale/mapping/intrinsics_evidence.h"
#include "turnscale/mapping/intrinsics_prior.h"

namespace turnscale {

/// A window of keyframes whose poses, points and intrinsics were brought to agree.
struct WindowReading {
  WindowEvidence evidence;
  double pixel_sigma = 0;  ///< as the residuals show it, pixels
  // The parabola of the window's cost (IntrinsicsEvidence) where the reading ended, without what the window gets wrong
  // beyond its noise; its pixels count as `pixel_sigma_inflation` asks for.
  IntrinsicsChange::Vector at = IntrinsicsChange::Vector::Zero();
  IntrinsicsChange::Matrix own_information = IntrinsicsChange::Matrix::Zero();
  IntrinsicsChange::Vector own_gradient = IntrinsicsChange::Vector::Zero();
  // Of the latest windows:
  std::shared_ptr<const std::vector<double>> residuals = nullptr;  ///< there (IntrinsicsProblem::Residuals)
  std::shared_ptr<const IntrinsicsProblem> window = nullptr;       ///< as it was left, to be linearised again
};
using WindowReadings = std::vector<WindowReading>;

/// What the readings tell of the intrinsics.
std::vector<WindowEvidence> EvidenceOf(const WindowReadings& readings);

/// Factor of the information of pixels whose errors go together.
double Deflation(const CalibrationCheckOptions& options);

/// Changes a window, from where it is, until its cost and what is `known` without it are at their minimum; what is
/// known guides the way, and is no part of the reading. Intrinsics are changes of the pinhole `given`. Nothing where
/// the window does not determine them. The reading has no copy of the window.
std::optional<WindowReading> ReadWindow(const CalibrationCheckOptions& options, const Pinhole& given,
                                        const IntrinsicsEstimate& known, IntrinsicsProblem& window);

enum class ReadingPlace { kFirst, kLast };

/// Reads a window and adds it to the others; only the latest of them keep their windows. Where it is the one that frees
/// the pixels' aspect, these are linearised anew. `known`: what it is read with. False, and the others stay, where it
/// does not determine the intrinsics.
bool AddReading(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior, const IntrinsicsEstimate& known,
                ReadingPlace place, IntrinsicsProblem& window, WindowReadings& readings);

}  // namespace turnscale
