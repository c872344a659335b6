// SPDX-License-Identifier: MIT
#include "turnscale/mapping/calibration_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>

#include "turnscale/base/check_part.h"
#include "turnscale/bundle/reprojection.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/local_bundle_adjustment.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;
using Matrix = IntrinsicsChange::Matrix;

// Of the radial correction, beyond the term in r^2.
constexpr int kHigherTermsOfLens = 2;
constexpr int kIterationsAtFirst = 10;
constexpr int kIterationsAfterAStep = 5;
// A step below this many standard deviations changes nothing that is reported.
constexpr double kSmallStep = 0.3;
// Farther than this at once the linear model is not to be trusted: log of the focal length, principal point in focal
// lengths, correction.
constexpr double kLongestFocalStep = 0.1;
constexpr double kLongestCentreStep = 0.05;
constexpr double kLongestCorrectionStep = 0.04;
constexpr double kLongestHigherStep = 0.04;
constexpr double kLongestAspectStep = 0.1;  // log
// Degrees of freedom of the Student distribution that windows are taken to follow.
constexpr double kStudentDof = 4;
constexpr int kReweightings = 20;
// Standard deviation of what a distortion beyond its first radial term does to the focal length (relative), the
// principal point (in focal lengths) and the correction, as a share of the correction.
constexpr double kHigherTerms = 0.15;
// Standard deviation of what the linear model gets wrong of a change of the aspect, as a share of how far it is from
// where the windows were linearised.
constexpr double kNonlinearAspect = 0.25;
// Log of the largest aspect that occurs, twice the usual. What looks like more is something else.
constexpr double kMostAspect = 1.1;
// The latest windows, half a megabyte each, can be linearised again.
constexpr size_t kKeptWindows = 12;
// Of these, earlier ones that are read across at a time: a look is to take little longer than the others.
constexpr size_t kEarlierAtATime = 2;
// After which the rows' direction is not tested any more, if it is clear.
constexpr int kWindowsOfClearDirection = 4;
// Relative standard deviation of a focal length beyond which an error of 15 % may go unnoticed.
constexpr double kUndetermined = 0.05;
// From one look to the next, at most, in halves of a window.
constexpr int kLongestInterval = 8;

// Largest angle between the first or the last of the keyframes and another, radians.
double LargestTurn(const Map& map, int first, int last) {
  double largest = 0;
  for (int k = first; k <= last; ++k)
    for (const int end : {first, last}) largest = std::max(largest, TurnBetween(map, end, k));
  return largest;
}

// Shift of the principal point by a small angle at the camera, pixels.
Eigen::Vector2d CentreShift(const Pinhole& pinhole, double degrees) {
  const double radians = degrees / kDegreesPerRadian;
  return {pinhole.fx * radians, pinhole.fy * radians};
}

auto HigherTerms(const Vector& change) { return change.segment<kHigherTermsOfLens>(IntrinsicsChange::kCorrection4); }

// Share of a step that stays within what the linear model is good for.
double ShareOf(const Vector& step, const Pinhole& pinhole) {
  const double longest = std::max({std::abs(step[IntrinsicsChange::kLogFocal]) / kLongestFocalStep,
                                   std::abs(step[IntrinsicsChange::kCentreX]) / (kLongestCentreStep * pinhole.fx),
                                   std::abs(step[IntrinsicsChange::kCentreY]) / (kLongestCentreStep * pinhole.fy),
                                   std::abs(step[IntrinsicsChange::kCorrection]) / kLongestCorrectionStep,
                                   HigherTerms(step).cwiseAbs().maxCoeff() / kLongestHigherStep,
                                   std::abs(step[IntrinsicsChange::kLogAspect]) / kLongestAspectStep});
  return 1.0 / std::max(1.0, longest);
}

// Radius of the image's corner on the plane z = 1.
double CornerRadius(const Pinhole& pinhole) { return std::hypot(pinhole.cx / pinhole.fx, pinhole.cy / pinhole.fy); }

// The correction in r^2 alone that moves the pixels of a disc most alike, by its weights in r^2, r^4 and r^6: least
// squares of the shift c r^3 over the disc. Its radius is that of the image's corner on the plane z = 1.
Vector WeightsOfDistortion(const Pinhole& pinhole) {
  const double corner = CornerRadius(pinhole);
  Vector weights = Vector::Zero();
  weights[IntrinsicsChange::kCorrection] = 1;
  weights[IntrinsicsChange::kCorrection4] = 8.0 / 10 * std::pow(corner, 2);
  weights[IntrinsicsChange::kCorrection6] = 8.0 / 12 * std::pow(corner, 4);
  return weights;
}

// The same of the correction that is applied. CorrectRadially takes the radius without the lens's distortion.
double AppliedCorrection(const CameraModel& camera) {
  constexpr int kRadii = 64;
  if (camera.radial_correction == 0) return 0;
  const double corner = CornerRadius(camera.pinhole);
  double sum = 0;
  double weights = 0;
  for (int i = 0; i < kRadii; ++i) {
    const double radius = corner * (i + 0.5) / kRadii;
    const std::optional<UndistortedPoint> ideal = UndistortPoint(camera, {radius, 0});
    if (!ideal) break;
    sum += camera.radial_correction * ideal->point.squaredNorm() * std::pow(radius, 5);
    weights += std::pow(radius, 7);
  }
  return weights > 0 ? sum / weights : camera.radial_correction;
}

// Of what the odometry makes the map with.
bool IsOfCamera(const ParameterEstimate& estimate) { return estimate.parameter != IntrinsicsParameter::kReadout; }

// Takes entries out of information times a minimum, or a gradient: they have the values of `at`, as seen from where
// the vector is 0.
void Hold(const std::vector<IntrinsicsChange::Entry>& entries, const Vector& at, Matrix& information, Vector& vector) {
  for (const IntrinsicsChange::Entry entry : entries) {
    vector -= at[entry] * information.col(entry);
    information.row(entry).setZero();
    information.col(entry).setZero();
    vector[entry] = 0;
  }
}

}  // namespace

void CalibrationCheckOptions::Check() const {
  Require(window >= 3, "window: has to be at least 3 keyframes");
  Require(min_turn_deg > 0, "min_turn_deg: has to be positive");
  Require(max_landmarks >= 20, "max_landmarks: has to be at least 20");
  Require(max_rounds >= 1, "max_rounds: has to be at least 1");
  Require(max_windows >= 1, "max_windows: has to be at least 1");
  Require(pixel_sigma_inflation >= 1, "pixel_sigma_inflation: has to be at least 1");
  Require(huber_threshold >= 0, "huber_threshold: must not be negative");
  Require(pixel_sigma > 0, "pixel_sigma: has to be positive");
  Require(focal_prior_sigma > 0, "focal_prior_sigma: has to be positive");
  Require(centre_prior_sigma_deg > 0, "centre_prior_sigma_deg: has to be positive");
  Require(correction_prior_sigma > 0, "correction_prior_sigma: has to be positive");
  Require(higher_prior_sigma >= 0, "higher_prior_sigma: must not be negative");
  Require(aspect_prior_sigma >= 0, "aspect_prior_sigma: must not be negative");
  Require(readout_prior_sigma > 0, "readout_prior_sigma: has to be positive");
  Require(focal_window_sigma >= 0, "focal_window_sigma: must not be negative");
  Require(centre_window_sigma_deg >= 0, "centre_window_sigma_deg: must not be negative");
  Require(correction_window_sigma >= 0, "correction_window_sigma: must not be negative");
  Require(focal_model_sigma >= 0, "focal_model_sigma: must not be negative");
  Require(centre_model_sigma_deg >= 0, "centre_model_sigma_deg: must not be negative");
  Require(correction_model_sigma >= 0, "correction_model_sigma: must not be negative");
  Require(aspect_model_sigma >= 0, "aspect_model_sigma: must not be negative");
  Require(readout_model_sigma >= 0, "readout_model_sigma: must not be negative");
  Require(min_focal_error >= 0, "min_focal_error: must not be negative");
  Require(min_centre_error_deg >= 0, "min_centre_error_deg: must not be negative");
  Require(min_correction_error >= 0, "min_correction_error: must not be negative");
  Require(min_aspect_error >= 0, "min_aspect_error: must not be negative");
  Require(min_readout >= 0, "min_readout: must not be negative");
  Require(significance > 0, "significance: has to be positive");
  Require(doubt > 0, "doubt: has to be positive");
}

std::optional<GivenReadout> ReadoutOf(const CameraModel& camera) {
  if (camera.readout == 0 && camera.readout_sigma == 0) return std::nullopt;
  return GivenReadout{camera.readout, camera.readout_sigma};
}

CalibrationCheck::CalibrationCheck(const CalibrationCheckOptions& options, const Pinhole& given, const Vector& expected,
                                   const std::optional<GivenReadout>& readout)
    : options_(options),
      given_(given),
      expected_(expected),
      given_readout_(readout),
      next_keyframe_(options.window - 1) {}

std::optional<IntrinsicsProblem> CalibrationCheck::TakeWindow(const Map& map) {
  const int latest = CountKeyframes(map) - 1;
  if (!options_.enabled || IsComplete() || latest < next_keyframe_) return std::nullopt;
  const int first = StartOfMap(map, std::max(0, latest - options_.window + 1));
  if (InDegrees(LargestTurn(map, first, latest)) < options_.min_turn_deg) return std::nullopt;
  // What windows have in common is known soon: later ones come less often, and only the first overlap.
  const int read = static_cast<int>(windows_.size()) + 1;
  next_keyframe_ = latest + std::min(read, kLongestInterval) * (options_.window / 2);
  IntrinsicsWindow window;
  window.first = first;
  window.last = latest;
  window.max_landmarks = options_.max_landmarks;
  window.huber_threshold = options_.huber_threshold;
  IntrinsicsProblem problem(map, map.camera, window, options_.pixel_sigma);
  if (problem.landmarks() == 0) return std::nullopt;
  return problem;
}

bool CalibrationCheck::Read(IntrinsicsProblem& window) {
  const IntrinsicsEstimate known = EstimateFrom(windows_);
  // The first window begins with the correction that is applied.
  if (!windows_.empty()) window.Change(known.change);
  if (!Add(window, known, windows_)) return false;
  observed_radius_ = std::max(observed_radius_, window.ObservedRadius());
  read_direction_ = window.read_direction();
  is_readout_contradicted_ = given_readout_ && Contradicts(ReadoutAgainstGiven());
  if (!given_readout_) TestDirection();
  return true;
}

bool CalibrationCheck::Add(IntrinsicsProblem& window, const IntrinsicsEstimate& known, Readings& readings,
                           Place place) const {
  std::optional<Reading> reading = ReadingOf(window, known);
  if (!reading) return false;
  reading->window = std::make_shared<const IntrinsicsProblem>(window);
  readings.insert(place == Place::kFirst ? readings.begin() : readings.end(), std::move(*reading));
  if (readings.size() > kKeptWindows) {
    Reading& earlier = readings[readings.size() - 1 - kKeptWindows];
    earlier.window.reset();
    earlier.residuals.reset();
  }
  if (known.Holds(IntrinsicsChange::kLogAspect) && !EstimateFrom(readings).Holds(IntrinsicsChange::kLogAspect))
    ReadAgain(readings);
  return true;
}

void CalibrationCheck::ReadAgain(Readings& readings) const {
  const Entries held = Held(readings);
  Readings before = std::exchange(readings, {});
  for (Reading& reading : before) {
    if (reading.window) {
      IntrinsicsProblem window = *reading.window;
      const IntrinsicsEstimate known = EstimateHolding(readings, held);
      if (!readings.empty()) window.Change(known.change);
      if (std::optional<Reading> again = ReadingOf(window, known)) {
        again->window = reading.window;
        reading = std::move(*again);
      }
    }
    readings.push_back(std::move(reading));
  }
}

void CalibrationCheck::TestDirection() {
  // Without the aspect, its part of the error is taken for something else.
  if (options_.aspect_prior_sigma == 0 || is_clearly_along_) return;
  const IntrinsicsEstimate along = EstimateFrom(windows_);
  if (across_.empty() && !IsUnexpected(along)) return;
  // They stay beside one another, of the same windows.
  if (!ReadAcross(*windows_.back().window, along, Place::kLast)) {
    // Beginning anew with the next window that is unexpected.
    across_.clear();
    reads_earlier_ = false;
    direction_ = Direction::kAlong;
    return;
  }
  for (size_t read = 0; read < kEarlierAtATime && reads_earlier_ && across_.size() < windows_.size(); ++read) {
    const Reading& earlier = windows_[windows_.size() - 1 - across_.size()];
    reads_earlier_ = earlier.window && ReadAcross(*earlier.window, along, Place::kFirst);
  }
  CompareDirections();
}

bool CalibrationCheck::ReadAcross(const IntrinsicsProblem& window, const IntrinsicsEstimate& along, Place place) {
  IntrinsicsProblem turned = window;
  turned.ReadAcross();
  const IntrinsicsEstimate known = EstimateFrom(across_);
  Vector start = across_.empty() ? along.change : known.change;
  for (const IntrinsicsChange::Entry entry : known.held) start[entry] = expected_[entry];
  turned.Change(start);
  return Add(turned, known, across_, place);
}

void CalibrationCheck::CompareDirections() {
  const Readings along(windows_.end() - static_cast<std::ptrdiff_t>(across_.size()), windows_.end());
  const IntrinsicsEstimate estimate_along = EstimateFrom(along);
  const IntrinsicsEstimate estimate_across = EstimateFrom(across_);
  double gain = MisfitOfPrior(estimate_along) - MisfitOfPrior(estimate_across);
  int compared = 0;
  for (size_t i = 0; i < across_.size(); ++i) {
    if (!along[i].residuals || !across_[i].residuals) continue;
    const double sigma = std::min(along[i].pixel_sigma, across_[i].pixel_sigma);
    gain += MisfitOf(along[i], estimate_along, sigma) - MisfitOf(across_[i], estimate_across, sigma) +
            ResidualsBeyond(along[i], across_[i], sigma);
    ++compared;
  }
  const double clear = options_.significance * options_.significance;
  const bool has_none = estimate_across.Holds(IntrinsicsChange::kReadout);
  const bool is_along = has_none || gain <= -clear;
  direction_ = is_along ? Direction::kAlong : gain > clear ? Direction::kAcross : Direction::kOpen;
  is_clearly_along_ = compared >= kWindowsOfClearDirection && (has_none ? WouldShowReadout(across_) : is_along);
  if (is_clearly_along_) across_.clear();
}

bool CalibrationCheck::WouldShowReadout(const Readings& readings) const {
  constexpr int kEntry = IntrinsicsChange::kReadout;
  const IntrinsicsEstimate free = EstimateHolding(readings, {IntrinsicsChange::kLogAspect});
  return options_.significance * std::sqrt(free.covariance(kEntry, kEntry)) < options_.min_readout;
}

double CalibrationCheck::MisfitOfPrior(const IntrinsicsEstimate& estimate) const {
  const Prior prior = PresentPrior();
  const Vector off = estimate.change - prior.mean;
  return off.dot(prior.covariance.inverse() * off);
}

double CalibrationCheck::MisfitOf(const Reading& reading, const IntrinsicsEstimate& estimate,
                                  double pixel_sigma) const {
  const double rescale = std::pow(reading.pixel_sigma / pixel_sigma, 2);
  Matrix information = rescale * reading.own_information;
  Vector gradient = rescale * reading.own_gradient;
  // How far the window's own minimum lies from the common one.
  Reading widened = Widened(information, information * reading.at - gradient);
  Hold(estimate.held, expected_, widened.information, widened.weighted_minimum);
  const Vector pull = widened.weighted_minimum - widened.information * estimate.change;
  const double square = pull.dot(widened.information.ldlt().solve(pull));
  // How far the cost is from that of the window's own minimum, where entries that are held are as expected.
  Vector to_held = Vector::Zero();
  for (const IntrinsicsChange::Entry entry : estimate.held) to_held[entry] = expected_[entry] - reading.at[entry];
  const double gained = -to_held.dot(2 * gradient + information * to_held);
  Hold(estimate.held, -to_held, information, gradient);
  const double left = gained + gradient.dot(information.ldlt().solve(gradient));
  return (kStudentDof + EstimatedEntries(estimate.held)) * std::log1p(square / kStudentDof) - left;
}

double CalibrationCheck::ResidualsBeyond(const Reading& reading, const Reading& other, double pixel_sigma) const {
  const double deflation = 1.0 / (options_.pixel_sigma_inflation * options_.pixel_sigma_inflation);
  const std::vector<double>& ones = *reading.residuals;
  const std::vector<double>& others = *other.residuals;
  const auto cost = [&](double residual) {
    return HuberCost(std::pow(residual / pixel_sigma, 2), options_.huber_threshold);
  };
  double difference = 0;
  for (size_t i = 0; i < std::min(ones.size(), others.size()); ++i)
    if (std::isfinite(ones[i] + others[i])) difference += cost(ones[i]) - cost(others[i]);
  return 2 * deflation * difference;
}

bool CalibrationCheck::Observe(const Map& map) {
  std::optional<IntrinsicsProblem> window = TakeWindow(map);
  return window && Read(*window);
}

Matrix CalibrationCheck::Covariance(const Sigmas& sigmas) const {
  const Eigen::Vector2d centre = CentreShift(given_, sigmas.centre_deg);
  Vector all;
  all << sigmas.focal, centre.x(), centre.y(), sigmas.correction, sigmas.higher, sigmas.higher, sigmas.aspect,
      sigmas.readout;
  return all.array().square().matrix().asDiagonal();
}

CalibrationCheck::Reading CalibrationCheck::Widened(const Matrix& information, const Vector& weighted_minimum) const {
  const Matrix window = Covariance({.focal = options_.focal_window_sigma,
                                    .centre_deg = options_.centre_window_sigma_deg,
                                    .correction = options_.correction_window_sigma});
  // (information^-1 + window)^-1, where information may be singular.
  const Matrix share = (Matrix::Identity() + information * window).inverse();
  return {share * information, share * weighted_minimum};
}

std::optional<CalibrationCheck::Reading> CalibrationCheck::ReadingOf(IntrinsicsProblem& window,
                                                                     const IntrinsicsEstimate& known) const {
  const Matrix known_information = known.covariance.inverse();
  const double deflation = 1.0 / (options_.pixel_sigma_inflation * options_.pixel_sigma_inflation);
  for (int round = 1;; ++round) {
    if (!window.Adjust(round == 1 ? kIterationsAtFirst : kIterationsAfterAStep)) return std::nullopt;
    window.EstimatePixelSigma();
    std::optional<IntrinsicsEvidence> evidence = window.Evidence();
    if (!evidence) return std::nullopt;
    if (options_.higher_prior_sigma == 0)
      Hold({IntrinsicsChange::kCorrection4, IntrinsicsChange::kCorrection6}, Vector::Zero(), evidence->information,
           evidence->gradient);
    Matrix information = deflation * evidence->information;
    Vector gradient = deflation * evidence->gradient;
    Hold(known.held, Vector::Zero(), information, gradient);
    const Matrix total = information + known_information;
    const Vector slope = gradient + known_information * (evidence->at - known.change);
    const Vector step = -total.ldlt().solve(slope);
    if (!step.allFinite()) return std::nullopt;
    if (round == options_.max_rounds || step.dot(total * step) < kSmallStep * kSmallStep) {
      Reading reading = Widened(deflation * evidence->information, deflation * evidence->weighted_minimum());
      reading.aspect = evidence->at[IntrinsicsChange::kLogAspect];
      reading.pixel_sigma = evidence->pixel_sigma;
      reading.at = evidence->at;
      reading.own_information = deflation * evidence->information;
      reading.own_gradient = deflation * evidence->gradient;
      reading.residuals = std::make_shared<const std::vector<double>>(window.Residuals());
      return reading;
    }
    window.Follow(*evidence, evidence->at + ShareOf(step, given_) * step);
  }
}

CalibrationCheck::Entries CalibrationCheck::Held(const Readings& readings, const Prior& prior) const {
  Entries held;
  if (!Shows(IntrinsicsChange::kLogAspect, options_.min_aspect_error, readings, prior, held))
    held.push_back(IntrinsicsChange::kLogAspect);
  if (!prior.has_readout && !Shows(IntrinsicsChange::kReadout, options_.min_readout, readings, prior, held))
    held.push_back(IntrinsicsChange::kReadout);
  return held;
}

bool CalibrationCheck::Shows(IntrinsicsChange::Entry entry, double least, const Readings& readings, const Prior& prior,
                             const Entries& held) const {
  const IntrinsicsEstimate estimate = EstimateWith(prior, readings, held);
  if (entry == IntrinsicsChange::kLogAspect && !MayHaveAspect(estimate)) return false;
  const double off = std::abs(estimate.change[entry] - expected_[entry]);
  return off > least && off > options_.significance * std::sqrt(estimate.covariance(entry, entry));
}

bool CalibrationCheck::MayHaveAspect(const IntrinsicsEstimate& estimate) const {
  constexpr int kEntry = IntrinsicsChange::kLogAspect;
  return options_.aspect_prior_sigma > 0 && std::abs(estimate.change[kEntry] - expected_[kEntry]) <= kMostAspect;
}

bool CalibrationCheck::IsUnexpected(const IntrinsicsEstimate& along) const {
  const auto is_off = [&](const IntrinsicsEstimate& estimate, IntrinsicsChange::Entry entry) {
    return std::abs(estimate.change[entry] - expected_[entry]) >
           options_.doubt * std::sqrt(estimate.covariance(entry, entry));
  };
  const IntrinsicsEstimate with_all = EstimateHolding(windows_, {});
  return is_off(along, IntrinsicsChange::kLogFocal) || is_off(along, IntrinsicsChange::kCentreX) ||
         is_off(along, IntrinsicsChange::kCentreY) || is_off(with_all, IntrinsicsChange::kLogAspect) ||
         is_off(with_all, IntrinsicsChange::kReadout);
}

IntrinsicsEstimate CalibrationCheck::Estimate() const {
  IntrinsicsEstimate estimate = EstimateFrom(readings());
  if (direction_ == Direction::kOpen) AddDifference(EstimateFrom(across_), estimate);
  return estimate;
}

void CalibrationCheck::AddDifference(const IntrinsicsEstimate& across, IntrinsicsEstimate& along) const {
  Vector difference = along.change - across.change;
  difference[IntrinsicsChange::kReadout] = 0;
  along.covariance += difference.array().square().matrix().asDiagonal();
}

std::optional<ShutterReadout> CalibrationCheck::Readout(const CameraModel& camera) const {
  if (windows_.empty() || !Contradictions(camera).empty()) {
    if (!given_readout_ || given_readout_->seconds == 0) return std::nullopt;
    return ShutterReadout{given_readout_->seconds, given_readout_->sigma, camera.read_direction};
  }
  return LatestReadout();
}

std::optional<ShutterReadout> CalibrationCheck::LatestReadout() const {
  constexpr int kEntry = IntrinsicsChange::kReadout;
  if (windows_.empty() || direction_ == Direction::kOpen) return std::nullopt;
  const bool is_known = given_readout_ && !is_readout_contradicted_;
  if (is_known && given_readout_->seconds == 0) return std::nullopt;
  const IntrinsicsEstimate estimate = EstimateFrom(readings());
  if (estimate.Holds(IntrinsicsChange::kReadout)) return std::nullopt;
  const double seconds = estimate.change[kEntry];
  double sigma = std::sqrt(estimate.covariance(kEntry, kEntry));
  // What windows get wrong alike does not make it less certain than it was.
  if (is_known) sigma = std::min(sigma, given_readout_->sigma);
  if (!IsReadAcross()) return ShutterReadout{seconds, sigma, read_direction_};
  // No row is stored as the first one.
  const ReadDirection across = Across(read_direction_);
  const int sign = seconds < 0 ? -1 : 1;
  return ShutterReadout{std::abs(seconds), sigma, {sign * across.x, sign * across.y}};
}

ParameterEstimate CalibrationCheck::AspectOf(const IntrinsicsEstimate& estimate) const {
  constexpr int kEntry = IntrinsicsChange::kLogAspect;
  const double given = given_.fy / given_.fx;
  const double found = given * std::exp(estimate.change[kEntry]);
  return {IntrinsicsParameter::kPixelAspect, given, found, found * std::sqrt(estimate.covariance(kEntry, kEntry))};
}

CalibrationCheck::Prior CalibrationCheck::PriorWith(const std::optional<GivenReadout>& readout,
                                                    double sigma_if_unknown) const {
  // A sigma of 0 has no inverse.
  constexpr double kLeast = 1e-5;
  Prior prior{expected_, PriorCovariance(readout ? std::max(readout->sigma, kLeast) : sigma_if_unknown),
              readout.has_value()};
  if (readout) prior.mean[IntrinsicsChange::kReadout] = readout->seconds;
  return prior;
}

ParameterEstimate CalibrationCheck::ReadoutAgainstGiven() const {
  constexpr int kEntry = IntrinsicsChange::kReadout;
  // As wide as what is given, so that the prior alone contradicts nothing.
  const Prior prior = PriorWith(std::nullopt, std::hypot(options_.readout_prior_sigma, given_readout_->seconds));
  Entries held = Held(readings(), prior);
  std::erase(held, IntrinsicsChange::kReadout);
  const IntrinsicsEstimate alone = EstimateWith(prior, readings(), held);
  return {IntrinsicsParameter::kReadout, given_readout_->seconds, alone.change[kEntry],
          std::hypot(given_readout_->sigma, std::sqrt(alone.covariance(kEntry, kEntry)))};
}

Matrix CalibrationCheck::PriorCovariance(double readout_sigma) const {
  // Terms that are not estimated stay at zero, as nothing refers to them.
  return Covariance({.focal = options_.focal_prior_sigma,
                     .centre_deg = options_.centre_prior_sigma_deg,
                     .correction = options_.correction_prior_sigma,
                     .higher = options_.higher_prior_sigma > 0 ? options_.higher_prior_sigma : 1.0,
                     .aspect = options_.aspect_prior_sigma > 0 ? options_.aspect_prior_sigma : 1.0,
                     .readout = readout_sigma});
}

double CalibrationCheck::EstimatedEntries(const Entries& held) const {
  return IntrinsicsChange::kEntries - (options_.higher_prior_sigma == 0 ? kHigherTermsOfLens : 0) -
         static_cast<double>(held.size());
}

IntrinsicsEstimate CalibrationCheck::EstimateWith(const Prior& known, const Readings& readings,
                                                  const Entries& held) const {
  struct Evidence {
    Matrix information;
    Vector weighted_minimum;
    double aspect = 0;
  };
  std::vector<Evidence> windows;
  for (const Reading& reading : readings) {
    windows.push_back({reading.information, reading.weighted_minimum, reading.aspect});
    Hold(held, known.mean, windows.back().information, windows.back().weighted_minimum);
  }
  const Matrix prior = known.covariance.inverse();
  IntrinsicsEstimate estimate;
  estimate.change = known.mean;
  estimate.covariance = known.covariance;
  estimate.held = held;
  if (windows.empty()) return estimate;
  const double entries = EstimatedEntries(held);
  const auto count = static_cast<double>(windows.size());
  std::vector<double> weights(windows.size(), 1.0);
  double scatter = 1;
  for (int round = 0; round < kReweightings; ++round) {
    Matrix information = prior;
    Vector weighted = prior * known.mean;
    for (size_t i = 0; i < windows.size(); ++i) {
      information += weights[i] * windows[i].information;
      weighted += weights[i] * windows[i].weighted_minimum;
    }
    estimate.covariance = information.inverse();
    estimate.change = estimate.covariance * weighted;
    double sum = 0;
    for (size_t i = 0; i < windows.size(); ++i) {
      // How far the window's own minimum lies from the common one, in its sigmas.
      const Vector pull = windows[i].weighted_minimum - windows[i].information * estimate.change;
      const double square = pull.dot(windows[i].information.ldlt().solve(pull));
      sum += weights[i] * square;
      // The common minimum follows each window's own: alone, a window says nothing of how far off it is.
      if (count > 1) weights[i] = (kStudentDof + entries) / (kStudentDof + square * count / (count - 1));
    }
    if (count > 1) scatter = std::max(1.0, sum / (entries * (count - 1)));
  }
  estimate.covariance *= scatter;
  double aspect_of_windows = 0;
  double total_weight = 0;
  for (size_t i = 0; i < windows.size(); ++i) {
    aspect_of_windows += weights[i] * windows[i].aspect;
    total_weight += weights[i];
  }
  const double aspect_change = estimate.change[IntrinsicsChange::kLogAspect] - aspect_of_windows / total_weight;
  // A lens that distorts much has more to it than the first radial term.
  const double unmodelled =
      options_.higher_prior_sigma > 0 ? 0.0 : kHigherTerms * std::abs(estimate.change[IntrinsicsChange::kCorrection]);
  estimate.covariance +=
      Covariance({.focal = std::hypot(options_.focal_model_sigma, unmodelled),
                  .centre_deg = std::hypot(options_.centre_model_sigma_deg, unmodelled * kDegreesPerRadian),
                  .correction = std::hypot(options_.correction_model_sigma, unmodelled),
                  .aspect = std::hypot(options_.aspect_model_sigma, kNonlinearAspect * aspect_change),
                  .readout = options_.readout_model_sigma * estimate.change[IntrinsicsChange::kReadout]});
  return estimate;
}

std::vector<ParameterEstimate> CalibrationCheck::Parameters(const CameraModel& camera) const {
  const IntrinsicsEstimate estimate = Estimate();
  const Vector sigmas = estimate.covariance.diagonal().cwiseSqrt();
  const Pinhole found = ChangedPinhole(given_, estimate.change);
  Vector distortion = WeightsOfDistortion(given_);
  if (options_.higher_prior_sigma == 0)
    distortion[IntrinsicsChange::kCorrection4] = distortion[IntrinsicsChange::kCorrection6] = 0;
  std::vector<ParameterEstimate> parameters = {
      {IntrinsicsParameter::kFocalLength, given_.fx, found.fx, sigmas[IntrinsicsChange::kLogFocal] * found.fx},
      {IntrinsicsParameter::kCentreX, given_.cx, found.cx, sigmas[IntrinsicsChange::kCentreX]},
      {IntrinsicsParameter::kCentreY, given_.cy, found.cy, sigmas[IntrinsicsChange::kCentreY]},
      {IntrinsicsParameter::kDistortion, AppliedCorrection(camera), distortion.dot(estimate.change),
       std::sqrt(distortion.dot(estimate.covariance * distortion))}};
  const bool holds_aspect = estimate.Holds(IntrinsicsChange::kLogAspect);
  IntrinsicsEstimate with_aspect = holds_aspect ? EstimateHolding(readings(), {}) : estimate;
  if (holds_aspect && direction_ == Direction::kOpen) AddDifference(EstimateHolding(across_, {}), with_aspect);
  if (!holds_aspect || MayHaveAspect(with_aspect)) parameters.push_back(AspectOf(with_aspect));
  if (given_readout_) parameters.push_back(ReadoutAgainstGiven());
  return parameters;
}

bool CalibrationCheck::Contradicts(const ParameterEstimate& estimate) const {
  return Deviates(estimate, options_.significance);
}

bool CalibrationCheck::Deviates(const ParameterEstimate& estimate, double significance) const {
  const Eigen::Vector2d centre = CentreShift(given_, options_.min_centre_error_deg);
  const auto exceeds = [&](double error, double least, double sigma) {
    return error > least && error > significance * sigma;
  };
  const double error = std::abs(estimate.found - estimate.given);
  switch (estimate.parameter) {
    case IntrinsicsParameter::kFocalLength:
      return exceeds(error, given_.fx * options_.min_focal_error, estimate.sigma);
    case IntrinsicsParameter::kCentreX:
      return exceeds(error, centre.x(), estimate.sigma);
    case IntrinsicsParameter::kCentreY:
      return exceeds(error, centre.y(), estimate.sigma);
    case IntrinsicsParameter::kDistortion:
      return exceeds(error, options_.min_correction_error, estimate.sigma);
    case IntrinsicsParameter::kPixelAspect:
      // Of a ratio, twice is as far off as half.
      return exceeds(std::abs(std::log(estimate.found / estimate.given)), options_.min_aspect_error,
                     estimate.sigma / estimate.found);
    case IntrinsicsParameter::kReadout:
      return exceeds(error, options_.min_readout, estimate.sigma);
  }
  return false;
}

std::vector<ParameterEstimate> CalibrationCheck::Contradictions(const CameraModel& camera) const {
  if (windows_.empty()) return {};
  std::vector<ParameterEstimate> contradictions = Parameters(camera);
  std::erase_if(contradictions,
                [&](const ParameterEstimate& estimate) { return !IsOfCamera(estimate) || !Contradicts(estimate); });
  return contradictions;
}

std::optional<ParameterEstimate> CalibrationCheck::ContradictedReadout(const CameraModel& camera) const {
  if (!is_readout_contradicted_ || !Contradictions(camera).empty()) return std::nullopt;
  return ReadoutAgainstGiven();
}

std::vector<ParameterEstimate> CalibrationCheck::Doubts(const CameraModel& camera) const {
  if (windows_.empty()) return {};
  std::vector<ParameterEstimate> doubts = Parameters(camera);
  std::erase_if(doubts, [&](const ParameterEstimate& estimate) {
    return estimate.parameter == IntrinsicsParameter::kPixelAspect || !IsOfCamera(estimate) || Contradicts(estimate) ||
           !Deviates(estimate, options_.doubt);
  });
  return doubts;
}

bool CalibrationCheck::DeterminesFocalLength() const {
  constexpr int kEntry = IntrinsicsChange::kLogFocal;
  return std::sqrt(Estimate().covariance(kEntry, kEntry)) <= kUndetermined;
}

CalibrationVerdict CalibrationCheck::Verdict(const CameraModel& camera) const {
  if (windows_.empty()) return CalibrationVerdict::kNotContradicted;
  const std::vector<ParameterEstimate> parameters = Parameters(camera);
  const auto contradicts = [&](const ParameterEstimate& estimate) {
    return IsOfCamera(estimate) && Contradicts(estimate);
  };
  if (std::ranges::any_of(parameters, contradicts)) return CalibrationVerdict::kContradicted;
  if (!DeterminesFocalLength()) return CalibrationVerdict::kInDoubt;
  // A turn shows little of the aspect.
  const auto is_in_doubt = [&](const ParameterEstimate& estimate) {
    return estimate.parameter != IntrinsicsParameter::kPixelAspect && IsOfCamera(estimate) &&
           std::abs(estimate.found - estimate.given) > options_.doubt * estimate.sigma;
  };
  return std::ranges::any_of(parameters, is_in_doubt) ? CalibrationVerdict::kInDoubt
                                                      : CalibrationVerdict::kNotContradicted;
}

}  // namespace turnscale
