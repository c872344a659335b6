// SPDX-License-Identifier: MIT
#include "turnscale/mapping/intrinsics_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <map>
#include <utility>

#include "turnscale/base/quantiles.h"
#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/bundle/parts.h"
#include "turnscale/bundle/reprojection.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/rolling_shutter.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;

// Pixels are not measured better than this, whatever the residuals of a made-up map.
constexpr double kLeastPixelSigma = 0.02;

// Side of a grid cell from which tracks are taken evenly, in x or y of the unit ray.
constexpr double kCell = 0.15;

// Points whose rows are in memory together.
constexpr size_t kPointsTogether = 400;

// What the window's keyframes see of a landmark, in their order.
struct Track {
  int landmark = 0;
  std::vector<LandmarkObservation> observations;
};

// Column and row of the cell in which the track lies on average, in a grid over x and y of the unit ray. Computed from
// the distorted pixel, so that the radial correction does not change it.
std::pair<int, int> CellOf(const CameraModel& camera, const Track& track) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const LandmarkObservation& seen : track.observations) {
    const Eigen::Vector2d distorted = camera.Project(camera.pinhole.Ray(seen.pixel)).value_or(seen.pixel);
    sum += camera.pinhole.Ray(distorted).normalized().head<2>();
  }
  const Eigen::Vector2d cell = sum / (kCell * static_cast<double>(track.observations.size()));
  if (!cell.allFinite()) return {0, 0};
  return {static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y()))};
}

// The longest tracks of each cell, in equal numbers as far as there are enough. `tracks` is sorted, longest first, and
// has at least `count`.
std::vector<Track> SpreadOverView(const CameraModel& camera, std::vector<Track> tracks, int count) {
  std::map<std::pair<int, int>, int> taken;
  std::vector<std::pair<int, size_t>> ranks;  // place within the cell, and in `tracks`
  for (size_t i = 0; i < tracks.size(); ++i) ranks.emplace_back(taken[CellOf(camera, tracks[i])]++, i);
  std::ranges::sort(ranks);
  std::vector<Track> spread;
  for (int i = 0; i < count; ++i) spread.push_back(std::move(tracks[ranks[i].second]));
  return spread;
}

std::vector<Track> ChooseTracks(const Map& map, const CameraModel& camera, const IntrinsicsWindow& window) {
  std::vector<Track> tracks;
  for (const int landmark : LandmarksSeen(map, window.first, window.last)) {
    Track track{landmark, {}};
    for (const LandmarkObservation& observation : map.landmarks[landmark].observations)
      if (observation.keyframe >= window.first && observation.keyframe <= window.last)
        track.observations.push_back(observation);
    if (track.observations.size() < IntrinsicsRow::kFewestOfPoint) continue;
    std::ranges::sort(track.observations, {}, &LandmarkObservation::keyframe);
    tracks.push_back(std::move(track));
  }
  std::ranges::stable_sort(tracks, std::ranges::greater(),
                           [](const Track& track) { return track.observations.size(); });
  if (static_cast<int>(tracks.size()) <= window.max_landmarks) return tracks;
  return SpreadOverView(camera, std::move(tracks), window.max_landmarks);
}

// The distorted pixel of an ideal one.
struct Prediction {
  Eigen::Vector2d distorted;  // pixels of the image
  CorrectedPixel corrected;   // of it
  Eigen::Matrix2d jacobian;   // derivative of the distorted pixel by the ideal one
};

Eigen::Matrix2d DistortedByIdeal(const Pinhole& pinhole, const CorrectedPixel& corrected) {
  const Eigen::DiagonalMatrix<double, 2> focal(pinhole.fx, pinhole.fy);
  return focal * corrected.jacobian.inverse() * focal.inverse();
}

// Whether the correction is far from folding the image.
bool IsRegular(const CorrectedPixel& corrected) {
  constexpr double kLeastShare = 0.1;
  const double half_trace = 0.5 * corrected.jacobian.trace();
  return corrected.jacobian.determinant() > kLeastShare * half_trace * half_trace;
}

// Newton's method from `begin`, a distorted pixel whose correction is `begin_corrected`.
std::optional<Prediction> Predict(const CameraModel& camera, const Vector& change, const Pinhole& pinhole,
                                  const Eigen::Vector2d& ideal, const Eigen::Vector2d& begin,
                                  const CorrectedPixel& begin_corrected) {
  constexpr int kMostSteps = 5;
  constexpr double kNegligible = 0.01;  // pixels; its square is what is left
  Prediction at{begin, begin_corrected, Eigen::Matrix2d::Zero()};
  for (int step = 0; step < kMostSteps; ++step) {
    if (!IsRegular(at.corrected)) return std::nullopt;
    const Eigen::Vector2d move = DistortedByIdeal(pinhole, at.corrected) * (ideal - at.corrected.pixel);
    at.distorted += move;
    const std::optional<CorrectedPixel> corrected = Correct(camera, change, at.distorted);
    if (!corrected) return std::nullopt;
    at.corrected = *corrected;
    if (!(move.norm() < kNegligible)) continue;
    if (!IsRegular(at.corrected)) return std::nullopt;
    at.jacobian = DistortedByIdeal(pinhole, at.corrected);
    return at;
  }
  return std::nullopt;
}

// The row of a landmark at `x` in the camera's frame. Residuals are those of the distorted image: the correction does
// not scale their noise. Derivatives are taken at the predicted pixel: those at the measured one are correlated with
// its noise, which biases the correction.
IntrinsicsRow MakeRow(const Pinhole& pinhole, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& x,
                      const Prediction& predicted, const Eigen::Vector2d& distorted, const Eigen::Vector2d& row_motion,
                      double pixel_sigma, double huber_threshold) {
  const double weight = 1 / pixel_sigma;
  IntrinsicsRow row;
  row.residual = weight * (predicted.distorted - distorted);
  const double length = row.residual.norm();
  const double root_weight =
      huber_threshold > 0 && length > huber_threshold ? std::sqrt(huber_threshold / length) : 1.0;
  const Eigen::Matrix<double, 2, 3> by_x = ProjectionJacobian(pinhole, x);
  row.pose << -by_x * Skew(x), by_x * rotation;
  const Eigen::Vector2d distorted_point = pinhole.Ray(predicted.distorted).head<2>();
  row.intrinsics = IntrinsicsJacobian(pinhole, x, distorted_point, predicted.corrected, row_motion);
  row.residual *= root_weight;
  const Eigen::Matrix2d by_ideal = root_weight * weight * predicted.jacobian;
  row.pose = by_ideal * row.pose;
  row.intrinsics = by_ideal * row.intrinsics;
  return row;
}

}  // namespace

IntrinsicsProblem::IntrinsicsProblem(const Map& map, const CameraModel& camera, const IntrinsicsWindow& window,
                                     double pixel_sigma)
    : camera_(camera), huber_threshold_(window.huber_threshold), pixel_sigma_(pixel_sigma) {
  const std::vector<Track> tracks = ChooseTracks(map, camera, window);

  for (int k = window.first; k <= window.last; ++k) {
    bundle_.camera_from_world.push_back(map.keyframes[k].camera_from_world);
    bundle_.camera_is_fixed.push_back(k == window.first ? 1 : 0);
  }
  for (const Track& track : tracks) {
    const int point = static_cast<int>(bundle_.points.size());
    bundle_.points.push_back(map.landmarks[track.landmark].position);
    first_observation_.push_back(static_cast<int>(distorted_.size()));
    for (const LandmarkObservation& seen : track.observations) {
      const std::optional<Eigen::Vector2d> distorted = camera.Project(camera.pinhole.Ray(seen.pixel));
      if (!distorted || !UndistortPoint(camera, camera.pinhole.Ray(*distorted).head<2>())) continue;
      bundle_.observations.push_back({seen.keyframe - window.first, point, seen.pixel, pixel_sigma});
      distorted_.push_back(*distorted);
      const Eigen::Vector3d& position = map.landmarks[track.landmark].position;
      const ReadDirection direction = map.camera.read_direction;
      row_motion_.push_back(RowMotion(map, seen.keyframe, position, *distorted, direction));
      across_motion_.push_back(RowMotion(map, seen.keyframe, position, *distorted, Across(direction)));
      stretch_.push_back(1);
    }
  }
  first_observation_.push_back(static_cast<int>(distorted_.size()));
  Vector change = Vector::Zero();
  change[IntrinsicsChange::kCorrection] = camera.radial_correction;
  Change(change);
}

double IntrinsicsProblem::ObservedRadius() const {
  constexpr double kNearlyAll = 0.99;
  const Eigen::Vector2d centre(bundle_.pinhole.cx, bundle_.pinhole.cy);
  std::vector<double> radii;
  for (size_t i = 0; i < distorted_.size(); ++i)
    if (corrected_[i]) radii.push_back((distorted_[i] - centre).norm());
  return Quantile(std::move(radii), kNearlyAll);
}

void IntrinsicsProblem::ReadAcross() {
  std::swap(row_motion_, across_motion_);
  camera_.read_direction = Across(camera_.read_direction);
  Change(change_);
}

void IntrinsicsProblem::Change(const Vector& change) {
  change_ = change;
  bundle_.pinhole = ChangedPinhole(camera_.pinhole, change);
  corrected_.resize(distorted_.size());
  ForEachPart(PartsOf(distorted_.size()), [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const std::optional<CorrectedPixel>& corrected = corrected_[i] = Correct(camera_, change, distorted_[i]);
      // A pixel that this lens cannot show stays distorted: bundle adjustment gives it little weight.
      const Eigen::Vector2d waited = change[IntrinsicsChange::kReadout] * row_motion_[i];
      bundle_.observations[i].pixel = corrected ? corrected->pixel - waited : distorted_[i];
      // Root mean square over all directions.
      if (corrected) stretch_[i] = std::sqrt(0.5 * corrected->jacobian.squaredNorm());
      bundle_.observations[i].sigma = stretch_[i] * pixel_sigma_;
    }
  });
}

bool IntrinsicsProblem::Adjust(int max_iterations) {
  BundleOptions options;
  options.huber_threshold = huber_threshold_;
  options.max_iterations = max_iterations;
  options.relative_cost_tolerance = 1e-4;
  return TryAdjustBundle(options, bundle_).has_value();
}

std::vector<double> IntrinsicsProblem::Residuals() const {
  std::vector<double> lengths(bundle_.observations.size(), HUGE_VAL);
  for (size_t i = 0; i < lengths.size(); ++i) {
    const BundleObservation& seen = bundle_.observations[i];
    const Eigen::Vector3d x = bundle_.camera_from_world[seen.camera] * bundle_.points[seen.point];
    if (IsInFront(x) && corrected_[i]) lengths[i] = (bundle_.pinhole.Project(x) - seen.pixel).norm() / stretch_[i];
  }
  return lengths;
}

void IntrinsicsProblem::EstimatePixelSigma() {
  std::vector<double> lengths;
  for (size_t i = 0; i < bundle_.observations.size(); ++i) {
    const BundleObservation& seen = bundle_.observations[i];
    const Eigen::Vector3d x = bundle_.camera_from_world[seen.camera] * bundle_.points[seen.point];
    if (IsInFront(x)) lengths.push_back((bundle_.pinhole.Project(x) - seen.pixel).norm() / stretch_[i]);
  }
  const double measured = 2.0 * static_cast<double>(lengths.size());
  const double fitted = 3.0 * static_cast<double>(bundle_.points.size()) +
                        IntrinsicsRow::kPoseDof * static_cast<double>(bundle_.camera_from_world.size() - 1);
  if (!(measured > fitted)) return;
  const double sigma = Median(std::move(lengths)) / kMedianLengthInPlane * std::sqrt(measured / (measured - fitted));
  pixel_sigma_ = std::max(sigma, kLeastPixelSigma);
  for (size_t i = 0; i < bundle_.observations.size(); ++i) bundle_.observations[i].sigma = stretch_[i] * pixel_sigma_;
}

std::optional<IntrinsicsEvidence> IntrinsicsProblem::Evidence() const {
  const int cameras = static_cast<int>(bundle_.camera_from_world.size());
  if (cameras < 2 || bundle_.observations.empty()) return std::nullopt;
  std::vector<Eigen::Matrix3d> rotations;
  for (const RigidTransform& pose : bundle_.camera_from_world) rotations.push_back(pose.rotation.toRotationMatrix());

  IntrinsicsEvidence evidence;
  evidence.at = change_;
  evidence.pixel_sigma = pixel_sigma_;
  ReducedSystem system(cameras);
  std::vector<std::optional<EliminatedPoint>> points;
  const auto fill_rows = [&](size_t p, std::vector<IntrinsicsRow>& rows) {
    rows.clear();
    for (int i = first_observation_[p]; i < first_observation_[p + 1]; ++i) {
      const BundleObservation& seen = bundle_.observations[i];
      const Eigen::Vector3d x = bundle_.camera_from_world[seen.camera] * bundle_.points[p];
      if (!IsInFront(x) || !corrected_[i]) continue;
      const std::optional<Prediction> predicted =
          Predict(camera_, change_, bundle_.pinhole,
                  bundle_.pinhole.Project(x) + change_[IntrinsicsChange::kReadout] * row_motion_[i], distorted_[i],
                  *corrected_[i]);
      if (!predicted) continue;
      rows.push_back(MakeRow(bundle_.pinhole, rotations[seen.camera], x, *predicted, distorted_[i], row_motion_[i],
                             pixel_sigma_, huber_threshold_));
      rows.back().column = IntrinsicsRow::kPoseDof * (seen.camera - 1);
    }
  };
  // Rows are filled on several threads, and added up in the order of the points.
  std::array<std::vector<IntrinsicsRow>, kPointsTogether> rows;
  for (size_t first = 0; first < bundle_.points.size(); first += kPointsTogether) {
    const size_t count = std::min(kPointsTogether, bundle_.points.size() - first);
    ForEachPart(PartsOf(count), [&](size_t, size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) fill_rows(first + i, rows[i]);
    });
    for (size_t i = 0; i < count; ++i) {
      points.push_back(Eliminate(rows[i], system));
      if (!points.back()) continue;
      ++evidence.landmarks;
      evidence.observations += static_cast<int>(rows[i].size());
    }
  }

  std::optional<MarginalIntrinsics> marginal = Marginalize(system, points, bundle_.camera_from_world);
  if (!marginal) return std::nullopt;
  evidence.information = marginal->information;
  evidence.gradient = marginal->gradient;
  evidence.response = std::move(marginal->response);
  return evidence;
}

void IntrinsicsProblem::Follow(const IntrinsicsEvidence& evidence, const Vector& change) {
  const IntrinsicsResponse& response = evidence.response;
  const Vector step = change - evidence.at;
  const Eigen::VectorXd poses = response.poses * step + response.pose_step;
  for (size_t k = 1; k < bundle_.camera_from_world.size(); ++k) {
    RigidTransform& pose = bundle_.camera_from_world[k];
    const auto move =
        poses.segment<IntrinsicsRow::kPoseDof>(IntrinsicsRow::kPoseDof * (static_cast<Eigen::Index>(k) - 1));
    const Eigen::Vector3d centre = pose.inverse().translation - move.tail<3>();
    pose.rotation = (RotationFromVector(move.head<3>()) * pose.rotation).normalized();
    pose.translation = -(pose.rotation * centre);
  }
  for (size_t p = 0; p < bundle_.points.size(); ++p) {
    const Eigen::Vector3d moved = bundle_.points[p] + response.points[p] * step + response.point_step[p];
    // To first order, a point that is nearly at infinity may come to lie behind its cameras.
    const auto begin = bundle_.observations.begin();
    if (std::all_of(
            begin + first_observation_[p], begin + first_observation_[p + 1],
            [&](const BundleObservation& seen) { return IsInFront(bundle_.camera_from_world[seen.camera] * moved); }))
      bundle_.points[p] = moved;
  }
  Change(change);
}

}  // namespace turnscale
