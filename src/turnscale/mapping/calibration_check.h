// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/pinhole.h"
#include "turnscale/mapping/intrinsics_evidence.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

struct CalibrationCheckOptions {
  /// Test the given intrinsics against the images of turns. A focal length that is 15 % off biases the scale
  /// by tens of per cent, and no other test detects it.
  bool enabled = true;
  /// Keyframes that each look takes in.
  int window = 20;
  /// Least angle between two of a window's keyframes, degrees. Without turning, a longer focal length is the same as a
  /// deeper scene.
  double min_turn_deg = 25.0;
  /// Landmarks that take part (IntrinsicsWindow); the time of a look is linear in it.
  int max_landmarks = 300;
  /// Times that poses, points and intrinsics are brought to agree in a window; with a right calibration one is enough.
  int max_rounds = 15;
  /// Windows after which no more are read: what is left of the errors then is what all windows have in common.
  int max_windows = 60;
  /// Errors of a track's pixels go together, so that each counts as if it were so many times its sigma.
  double pixel_sigma_inflation = 3.0;
  /// Where bundle adjustment starts to weigh residuals linearly, in sigmas.
  double huber_threshold = 2.0;
  /// Standard deviation of a tracked pixel until estimated from residuals, pixels.
  double pixel_sigma = kTrackedPixelSigma;

  // Priors, standard deviations.
  double focal_prior_sigma = 0.1;       ///< relative
  double centre_prior_sigma_deg = 2.0;  ///< principal point, as an angle at the camera, degrees
  double correction_prior_sigma = 0.3;  ///< radial correction: the whole distortion may be missing
  /// Its terms in r^4 and r^6; 0: not estimated. If they are not, their errors are mistaken for a focal
  /// length.
  double higher_prior_sigma = 0.1;
  /// Width of a pixel over its height, relative: anamorphic video without its tag. Counts as expected unless it is off
  /// by more than `min_aspect_error` and `significance`, as level turns do not determine it. 0: not estimated.
  double aspect_prior_sigma = 0.3;
  /// Seconds in which a rolling shutter reads the image. In turns it shears the image, which looks like another
  /// principal point. Counts as 0 unless it exceeds `min_readout` and `significance`.
  double readout_prior_sigma = 0.02;

  // What the images of one window get wrong beyond their noise (moving things, what the lens has besides a radial
  // distortion), standard deviations. Windows of KITTI scatter by as much.
  double focal_window_sigma = 0.01;       ///< relative
  double centre_window_sigma_deg = 0.25;  ///< degrees
  double correction_window_sigma = 0.004;

  // The same of what all windows of a drive get wrong alike.
  double focal_model_sigma = 0.007;     ///< relative
  double centre_model_sigma_deg = 0.2;  ///< degrees
  double correction_model_sigma = 0.003;
  double aspect_model_sigma = 0.02;   ///< relative; as recorded drives show that were squeezed
  double readout_model_sigma = 0.07;  ///< relative; as rendered drives show

  // A contradiction is reported from these errors on, when it also exceeds `significance` standard deviations.
  double min_focal_error = 0.03;      ///< relative
  double min_centre_error_deg = 0.8;  ///< degrees
  double min_correction_error = 0.01;
  double min_aspect_error = 0.05;  ///< relative
  double min_readout = 0.004;      ///< seconds
  double significance = 3.0;
  /// Least deviation that leaves the calibration in doubt, standard deviations: too little for a report, but what a
  /// wrong calibration may look like is not taken for something else.
  double doubt = 2.0;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

enum class IntrinsicsParameter { kFocalLength, kCentreX, kCentreY, kDistortion, kPixelAspect, kReadout };

/// One parameter as given and as estimated from the drive: focal length fx and principal point in pixels, the
/// distortion as the radial correction that the calibration lacks, with one term in r^2: the one that is closest to the
/// estimated correction over the image. What counts as given of it is the correction that is applied. The aspect is the
/// width of a pixel over its height, fy / fx. The readout of a rolling shutter is in seconds.
struct ParameterEstimate {
  IntrinsicsParameter parameter = IntrinsicsParameter::kFocalLength;
  double given = 0;
  double found = 0;
  double sigma = 0;
};

/// How long a rolling shutter takes from the first row of the image as it was stored to the last one, seconds; below 0
/// if it begins with the last one.
struct ShutterReadout {
  double seconds = 0;
  double sigma = 0;
  ReadDirection direction = {};  ///< from the first row to the last one, in the image as it is used
  bool is_corrected = false;     ///< in the poses that go with it
};

/// The readout that a camera is known to have (CameraModel), if it is known; seconds.
struct GivenReadout {
  double seconds = 0;
  double sigma = 0;
};
std::optional<GivenReadout> ReadoutOf(const CameraModel& camera);

/// How a calibration has passed its test.
enum class CalibrationVerdict { kNotContradicted, kInDoubt, kContradicted };

/// Intrinsics of a drive as a difference from the given ones.
struct IntrinsicsEstimate {
  IntrinsicsChange::Vector change = IntrinsicsChange::Vector::Zero();
  IntrinsicsChange::Matrix covariance = IntrinsicsChange::Matrix::Zero();
  /// Left as expected. Their covariance has nothing of the images: it is that of the prior, enlarged as that of the
  /// others by the scatter of windows and errors of the model.
  std::vector<IntrinsicsChange::Entry> held = {};

  bool Holds(IntrinsicsChange::Entry entry) const { return std::ranges::find(held, entry) != held.end(); }
};

/// Consistency test of a calibration. Windows of keyframes in which the camera turns determine the intrinsics
/// (IntrinsicsProblem); their evidence is summed, windows that disagree with the others are down-weighted, and their
/// scatter widens the sigmas. Also the estimator of unknown intrinsics, with wide priors (CalibrateFromDrive).
///
/// Where the windows leave what is expected in doubt, they are read once more with a readout along the columns of the
/// image, as of a video that was rotated and encoded anew: the direction that explains them clearly better counts.
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
  int windows() const { return static_cast<int>(windows_.size()); }
  /// Largest IntrinsicsProblem::ObservedRadius of the windows, pixels; 0 before the first.
  double observed_radius() const { return observed_radius_; }
  /// Whether as many windows were read as there may be: no more are.
  bool IsComplete() const { return windows() >= options_.max_windows; }
  /// The estimate from drive and prior; sigmas include the scatter of windows and their common error. The pixels'
  /// aspect and the readout are as expected unless the windows contradict that. While it is open in which direction the
  /// image is read, they include the difference, too.
  IntrinsicsEstimate Estimate() const;
  /// Of what is known and what the images show. Empty if neither is anything, and while it is open in which direction
  /// the image is read. If the images contradict the calibration, only what is known: a wrong camera may look like a
  /// rolling shutter.
  std::optional<ShutterReadout> Readout(const CameraModel& camera) const;
  /// The same of intrinsics that are estimated: whether they contradict the ones to start with does not matter. Of
  /// windows that were read.
  std::optional<ShutterReadout> LatestReadout() const;
  /// All parameters, in the order of IntrinsicsParameter; those of the prior while no window was read. Without the
  /// pixels' aspect where it is not estimated, or is none that occurs, and without a readout that is not known; that is
  /// compared with what the windows alone say, and its sigma is that of the difference. `camera`: that of the windows,
  /// with the radial correction that the map's pixels have now.
  std::vector<ParameterEstimate> Parameters(const CameraModel& camera) const;
  /// Whether what was found is worth a report, and significant.
  bool Contradicts(const ParameterEstimate& estimate) const;
  /// Whether a readout along the columns was tested, and explains the turns clearly better than one along the rows.
  bool IsReadAcross() const { return direction_ == Direction::kAcross; }
  /// Whether it was tested, and neither explains them clearly better.
  bool IsDirectionOpen() const { return direction_ == Direction::kOpen; }
  /// Those inconsistent with what is used, the readout apart; empty if the drive agrees or does not determine them.
  std::vector<ParameterEstimate> Contradictions(const CameraModel& camera) const;
  /// The readout that is known, if the windows contradict it and nothing else: theirs takes its place.
  std::optional<ParameterEstimate> ContradictedReadout(const CameraModel& camera) const;
  /// Those that deviate by as much, but only by more than `doubt` standard deviations; without the pixels' aspect and
  /// the readout.
  std::vector<ParameterEstimate> Doubts(const CameraModel& camera) const;
  /// Whether the images of turns show the focal length well enough for a test.
  bool DeterminesFocalLength() const;
  /// A readout that the windows contradict does not count: theirs takes its place. In doubt if focal length, principal
  /// point or distortion deviate by more than `doubt` standard deviations, or the focal length is not determined.
  CalibrationVerdict Verdict(const CameraModel& camera) const;

 private:
  /// Whether an error is worth a report, and more than so many standard deviations.
  bool Deviates(const ParameterEstimate& estimate, double significance) const;

  using Entries = std::vector<IntrinsicsChange::Entry>;
  /// The evidence of a window.
  struct Reading {
    IntrinsicsChange::Matrix information;
    IntrinsicsChange::Vector weighted_minimum;
    double aspect = 0;       ///< change of its log at which the window was linearised
    double pixel_sigma = 0;  ///< pixels
    // The parabola of the window without what it gets wrong beyond its noise, where the reading ended:
    IntrinsicsChange::Vector at = IntrinsicsChange::Vector::Zero();
    IntrinsicsChange::Matrix own_information = IntrinsicsChange::Matrix::Zero();
    IntrinsicsChange::Vector own_gradient = IntrinsicsChange::Vector::Zero();
    // Of the latest ones:
    std::shared_ptr<const std::vector<double>> residuals = nullptr;  ///< there (IntrinsicsProblem::Residuals)
    std::shared_ptr<const IntrinsicsProblem> window = nullptr;
  };
  using Readings = std::vector<Reading>;
  /// In which rows follow one another: as in the camera, across it (Across), or one of the two.
  enum class Direction { kAlong, kAcross, kOpen };
  /// What is known of the intrinsics without the windows.
  struct Prior {
    IntrinsicsChange::Vector mean;
    IntrinsicsChange::Matrix covariance;
    bool has_readout = false;  ///< one that is known
  };
  /// Those that count.
  const Readings& readings() const { return IsReadAcross() ? across_ : windows_; }
  /// What the estimate leaves as expected.
  Entries Held(const Readings& readings, const Prior& prior) const;
  Entries Held(const Readings& readings) const { return Held(readings, PresentPrior()); }
  /// Whether an entry is off what is expected, by more than `least` and significantly.
  bool Shows(IntrinsicsChange::Entry entry, double least, const Readings& readings, const Prior& prior,
             const Entries& held) const;
  /// Whether the windows leave what is expected in doubt, the distortion apart. `along`: their estimate.
  bool IsUnexpected(const IntrinsicsEstimate& along) const;
  /// Whether the pixels' aspect is estimated, and is one that occurs.
  bool MayHaveAspect(const IntrinsicsEstimate& estimate) const;
  /// From these readings, those of `held` as expected.
  IntrinsicsEstimate EstimateHolding(const Readings& readings, const Entries& held) const {
    return EstimateWith(PresentPrior(), readings, held);
  }
  IntrinsicsEstimate EstimateWith(const Prior& prior, const Readings& readings, const Entries& held) const;
  /// The readout that is known, compared with that of the windows alone.
  ParameterEstimate ReadoutAgainstGiven() const;
  Prior PriorWith(const std::optional<GivenReadout>& readout, double sigma_if_unknown) const;
  /// Without the readout that is known if the windows contradict it.
  Prior PresentPrior() const {
    return PriorWith(is_readout_contradicted_ ? std::nullopt : given_readout_, options_.readout_prior_sigma);
  }
  IntrinsicsEstimate EstimateFrom(const Readings& readings) const { return EstimateHolding(readings, Held(readings)); }
  ParameterEstimate AspectOf(const IntrinsicsEstimate& estimate) const;
  /// Standard deviations, as in the options.
  struct Sigmas {
    double focal = 0;
    double centre_deg = 0;
    double correction = 0;
    double higher = 0;
    double aspect = 0;
    double readout = 0;
  };
  IntrinsicsChange::Matrix Covariance(const Sigmas& sigmas) const;
  IntrinsicsChange::Matrix PriorCovariance(double readout_sigma) const;
  double EstimatedEntries(const Entries& held) const;  ///< how many there are
  /// With what one window gets wrong beyond its noise.
  Reading Widened(const IntrinsicsChange::Matrix& information, const IntrinsicsChange::Vector& weighted_minimum) const;
  /// `known`: what is known without the window, which guides the way, and is taken off again.
  std::optional<Reading> ReadingOf(IntrinsicsProblem& window, const IntrinsicsEstimate& known) const;
  enum class Place { kFirst, kLast };
  /// Adds a reading, and linearises the others anew if the pixels' aspect is free from now on. False where the window
  /// does not determine the intrinsics.
  bool Add(IntrinsicsProblem& window, const IntrinsicsEstimate& known, Readings& readings,
           Place place = Place::kLast) const;
  /// Linearises windows anew, with the pixels' aspect free.
  void ReadAgain(Readings& readings) const;
  /// Reads windows with rows across the camera's read direction, if there is reason to: the latest one, and a few of
  /// those before that were not.
  void TestDirection();
  bool ReadAcross(const IntrinsicsProblem& window, const IntrinsicsEstimate& along, Place place);
  /// Sets the direction to what is likely with these readings.
  void CompareDirections();
  /// Whether the least readout that is reported would be significant.
  bool WouldShowReadout(const Readings& readings) const;
  /// Minus twice the log-likelihood of what the prior and a window have left, but for the residuals. `pixel_sigma`: in
  /// whose units, pixels.
  double MisfitOfPrior(const IntrinsicsEstimate& estimate) const;
  double MisfitOf(const Reading& reading, const IntrinsicsEstimate& estimate, double pixel_sigma) const;
  /// The same of the residuals of one reading less those of another.
  double ResidualsBeyond(const Reading& reading, const Reading& other, double pixel_sigma) const;
  /// Adds what else the intrinsics may be where the rows follow one another in the other direction.
  void AddDifference(const IntrinsicsEstimate& across, IntrinsicsEstimate& along) const;

  CalibrationCheckOptions options_;
  Pinhole given_;
  IntrinsicsChange::Vector expected_;
  std::optional<GivenReadout> given_readout_;
  bool is_readout_contradicted_ = false;
  Readings windows_;
  Readings across_;  ///< the latest ones of `windows_`, with rows across; empty while there is no reason
  Direction direction_ = Direction::kAlong;
  bool is_clearly_along_ = false;  ///< no more windows are read across
  bool reads_earlier_ = true;      ///< ones across
  ReadDirection read_direction_;   ///< of the camera
  double observed_radius_ = 0;
  int next_keyframe_ = 0;
};

}  // namespace turnscale
