// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/pinhole.h"
#include "turnscale/mapping/calibration_check_options.h"
#include "turnscale/mapping/calibration_verdict.h"
#include "turnscale/mapping/intrinsics_estimate.h"
#include "turnscale/mapping/intrinsics_evidence.h"
#include "turnscale/mapping/intrinsics_prior.h"
#include "turnscale/mapping/map.h"
#include "turnscale/mapping/parameter_estimate.h"
#include "turnscale/mapping/row_direction.h"
#include "turnscale/mapping/shutter_readout.h"
#include "turnscale/mapping/window_reading.h"

namespace turnscale {

/// Consistency test of a calibration. Windows of keyframes in which the camera turns determine the intrinsics
/// (IntrinsicsProblem); what they show is combined (EstimateIntrinsics) and compared with what is given (VerdictOn).
/// Also the estimator of unknown intrinsics, with wide priors (CalibrateFromDrive).
///
/// Reads the map and changes nothing. Works with any lens: the correction is a function of the distorted radius, which
/// is bounded (Correct).
class CalibrationCheck {
 public:
  /// Of maps whose camera has the pinhole `given`. `expected`: mean of the prior of the change, but for a readout that
  /// is known. That is estimated along with the others, with its own prior until the windows contradict it.
  CalibrationCheck(const CalibrationCheckOptions& options, const Pinhole& given,
                   const IntrinsicsChange::Vector& expected = IntrinsicsChange::Vector::Zero(),
                   const std::optional<GivenReadout>& readout = std::nullopt);

  /// A copy of the window that ends at the latest keyframe; nothing if none is due, or the camera turns too little in
  /// it. The next one is due some keyframes later. Call it when a keyframe has come.
  std::optional<IntrinsicsProblem> TakeWindow(const Map& map);
  /// Takes in a window. False where it does not determine the intrinsics.
  bool Read(IntrinsicsProblem& window);
  /// Both. True when a window was read.
  bool Observe(const Map& map);

  /// Windows that were read.
  int windows() const { return static_cast<int>(along_.size()); }
  /// Largest IntrinsicsProblem::ObservedRadius of the windows, pixels; 0 before the first.
  double observed_radius() const { return observed_radius_; }
  /// Whether as many windows were read as there may be: no more are.
  bool IsComplete() const { return windows() >= options_.max_windows; }
  /// Whether a readout along the columns was tested, and explains the turns clearly better than one along the rows.
  bool IsReadAcross() const { return direction_.direction() == RowDirection::kAcross; }
  /// Whether it was tested, and neither explains them clearly better.
  bool IsDirectionOpen() const { return direction_.direction() == RowDirection::kOpen; }

  /// The estimate from drive and prior (EstimateIntrinsics). While it is open in which direction the image is read,
  /// sigmas include the difference, too.
  IntrinsicsEstimate Estimate() const;
  /// All parameters, in the order of IntrinsicsParameter; those of the prior while no window was read. Without the
  /// pixels' aspect where it is not estimated, or is none that occurs, and without a readout that is not known
  /// (ReadoutWithoutPrior). `camera`: that of the windows, with the radial correction that the map's pixels have now.
  std::vector<ParameterEstimate> Parameters(const CameraModel& camera) const;

  /// ContradictionsAmong the parameters; none while no window was read.
  std::vector<ParameterEstimate> Contradictions(const CameraModel& camera) const;
  /// DoubtsAmong the parameters; none while no window was read.
  std::vector<ParameterEstimate> Doubts(const CameraModel& camera) const;
  /// Whether the images of turns, or else the prior, show the focal length well enough for a test.
  bool DeterminesFocalLength() const { return IsFocalLengthDetermined(Estimate()); }
  /// A readout that the windows contradict does not count: theirs takes its place. kNotContradicted while no window was
  /// read.
  CalibrationVerdict Verdict(const CameraModel& camera) const;
  /// The readout that is known, if the windows contradict it and nothing else: theirs takes its place.
  std::optional<ParameterEstimate> ContradictedReadout(const CameraModel& camera) const;

  /// Of what is known and what the images show. Empty if neither is anything, and while it is open in which direction
  /// the image is read. If the images contradict the calibration, only what is known: a wrong camera may look like a
  /// rolling shutter.
  std::optional<ShutterReadout> Readout(const CameraModel& camera) const;
  /// The same of intrinsics that are estimated: whether they contradict the ones to start with does not matter. Of
  /// windows that were read.
  std::optional<ShutterReadout> LatestReadout() const;

 private:
  /// Without the readout that is known if the windows contradict it.
  IntrinsicsPrior Prior() const;
  /// Of the windows in the direction that counts.
  std::vector<WindowEvidence> Evidence() const { return EvidenceOf(IsReadAcross() ? direction_.across() : along_); }
  /// What `estimate` gives of that evidence, with the difference between directions while it is open which one counts.
  IntrinsicsEstimate WithOpenDirection(
      const std::function<IntrinsicsEstimate(const std::vector<WindowEvidence>&)>& estimate) const;
  /// Of the readout that is known.
  ParameterEstimate KnownReadout() const;

  CalibrationCheckOptions options_;
  Pinhole given_;
  IntrinsicsChange::Vector expected_;
  std::optional<GivenReadout> given_readout_;
  bool is_readout_contradicted_ = false;
  WindowReadings along_;          ///< with rows as in the camera
  RowDirectionChoice direction_;  ///< of them
  ReadDirection read_direction_;  ///< of the camera
  double observed_radius_ = 0;
  int next_keyframe_ = 0;
};

}  // namespace turnscale
