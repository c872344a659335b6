// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <vector>

#include "turnscale/mapping/calibration_check_options.h"
#include "turnscale/mapping/intrinsics_change.h"
#include "turnscale/mapping/intrinsics_prior.h"

namespace turnscale {

using IntrinsicsEntries = std::vector<IntrinsicsChange::Entry>;

/// Intrinsics of a drive as a difference from the given ones.
struct IntrinsicsEstimate {
  IntrinsicsChange::Vector change = IntrinsicsChange::Vector::Zero();
  IntrinsicsChange::Matrix covariance = IntrinsicsChange::Matrix::Zero();
  /// Left as expected. Their covariance has nothing of the images: it is that of the prior, enlarged as that of the
  /// others by the scatter of windows and errors of the model.
  IntrinsicsEntries held = {};

  bool Holds(IntrinsicsChange::Entry entry) const { return std::ranges::find(held, entry) != held.end(); }
};

/// What a window of keyframes shows of the intrinsics: a normal distribution of the change, which has what the window
/// gets wrong beyond its noise. `information` is singular where the window does not determine an entry.
struct WindowEvidence {
  IntrinsicsChange::Matrix information = IntrinsicsChange::Matrix::Zero();
  IntrinsicsChange::Vector weighted_minimum = IntrinsicsChange::Vector::Zero();  ///< information times the mean
  double aspect = 0;  ///< change of its log at which the window was linearised
};

/// The evidence of a window whose noise alone would leave this information, from where the change is 0.
WindowEvidence WithWindowErrors(const CalibrationCheckOptions& options, const Pinhole& given,
                                const IntrinsicsChange::Matrix& information,
                                const IntrinsicsChange::Vector& weighted_minimum);

/// Takes entries out of information times a minimum, or a gradient: they have the values of `at`, as seen from where
/// the vector is 0.
void HoldEntries(const IntrinsicsEntries& entries, const IntrinsicsChange::Vector& at,
                 IntrinsicsChange::Matrix& information, IntrinsicsChange::Vector& vector);

/// Takes the higher terms of the lens out if they are not estimated (CalibrationCheckOptions::higher_prior_sigma).
void HoldHigherTerms(const CalibrationCheckOptions& options, IntrinsicsChange::Matrix& information,
                     IntrinsicsChange::Vector& vector);

/// Square of the distance of the window's own minimum from `change`, in its sigmas.
double SquaredDistance(const WindowEvidence& window, const IntrinsicsChange::Vector& change);

/// Minus twice the log-likelihood of such a square: windows follow a Student distribution, as some are wrong.
double MisfitOfDistance(const CalibrationCheckOptions& options, const IntrinsicsEntries& held, double square);

/// The estimate from prior and windows, with the entries of `held` at the prior's mean. Windows that disagree with the
/// others are down-weighted; sigmas include the scatter of the windows and what all of them get wrong alike. The prior
/// itself where there is no window.
IntrinsicsEstimate CombineWindows(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                                  std::vector<WindowEvidence> windows, const IntrinsicsEntries& held);

/// Whether the pixels' aspect is estimated, and is one that occurs.
bool MayHaveAspect(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                   const IntrinsicsEstimate& estimate);

/// What an estimate has to hold: the pixels' aspect and a readout that is not known, each unless the windows contradict
/// what is expected of it.
IntrinsicsEntries EntriesToHold(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                                const std::vector<WindowEvidence>& windows);

/// CombineWindows with EntriesToHold.
IntrinsicsEstimate EstimateIntrinsics(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                                      const std::vector<WindowEvidence>& windows);

}  // namespace turnscale
