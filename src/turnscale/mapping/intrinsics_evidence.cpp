// SPDX-License-Identifier: MIT
#include "turnscale/mapping/intrinsics_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <map>
#include <utility>

#include <Eigen/Cholesky>

#include "turnscale/base/quantiles.h"
#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/bundle/parts.h"
#include "turnscale/bundle/reprojection.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr int kEntries = IntrinsicsChange::kEntries;
using Vector = IntrinsicsChange::Vector;
using Matrix = IntrinsicsChange::Matrix;

constexpr size_t kFewestInTrack = 3;  // of a landmark: two fit a point whatever the camera
constexpr int kPoseDof = 6;
// Median length of a two-dimensional normal error of sigma 1.
constexpr double kMedianLength = 1.17741;
// Share of the largest pivot below which a point's depth is not determined.
constexpr double kLeastPivot = 1e-7;
// Relative; keeps a factorization from stopping at rounding errors.
constexpr double kRounding = 1e-13;
// Pixels are not measured better than this, whatever the residuals of a made-up map.
constexpr double kLeastPixelSigma = 0.02;

// Side of a grid cell from which tracks are taken evenly, in x or y of the unit ray.
constexpr double kCell = 0.15;

// Points whose rows are in memory together.
constexpr size_t kPointsTogether = 400;

using PoseBlock = Eigen::Matrix<double, 3, kPoseDof>;
using IntrinsicsBlock = Eigen::Matrix<double, 3, kEntries>;

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
    if (track.observations.size() < kFewestInTrack) continue;
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

// Derivatives of one residual, over sigma and with the root of Huber's weight. Pose unknowns are (phi, delta):
// x_in_camera = Exp(phi) R (X - c + delta), so that the point's derivatives are those of delta.
struct Row {
  int column = -1;  // first of the pose's in the reduced system; -1: it holds still
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, kPoseDof> pose;
  Eigen::Matrix<double, 2, kEntries> intrinsics;

  auto point() const { return pose.rightCols<3>(); }
};

// The window of keyframes without its points: poses but the first, then the intrinsics. Upper triangle.
struct ReducedSystem {
  explicit ReducedSystem(int cameras)
      : poses(kPoseDof * (cameras - 1)),
        hessian(Eigen::MatrixXd::Zero(poses + kEntries, poses + kEntries)),
        gradient(Eigen::VectorXd::Zero(poses + kEntries)) {}

  int poses;
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
};

// One point's normal equations, solved for the point: it moves by -(step + by_intrinsics * intrinsics + the sum of
// edge blocks times their poses).
struct EliminatedPoint {
  struct Edge {
    int column;
    PoseBlock block;
  };
  Eigen::Vector3d step;
  IntrinsicsBlock by_intrinsics;
  std::vector<Edge> edges;
};

// The row of a landmark at `x` in the camera's frame. Residuals are those of the distorted image: the correction does
// not scale their noise. Derivatives are taken at the predicted pixel: those at the measured one are correlated with
// its noise, which biases the correction.
Row MakeRow(const Pinhole& pinhole, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& x,
            const Prediction& predicted, const Eigen::Vector2d& distorted, double pixel_sigma, double huber_threshold) {
  const double weight = 1 / pixel_sigma;
  Row row;
  row.residual = weight * (predicted.distorted - distorted);
  const double length = row.residual.norm();
  const double root_weight =
      huber_threshold > 0 && length > huber_threshold ? std::sqrt(huber_threshold / length) : 1.0;
  Eigen::Matrix<double, 2, 3> by_x;
  by_x << pinhole.fx / x.z(), 0, -pinhole.fx * x.x() / (x.z() * x.z()),  //
      0, pinhole.fy / x.z(), -pinhole.fy * x.y() / (x.z() * x.z());
  row.pose << -by_x * Skew(x), by_x * rotation;
  const Eigen::Vector2d distorted_point = pinhole.Ray(predicted.distorted).head<2>();
  row.intrinsics = IntrinsicsJacobian(pinhole, x, distorted_point, predicted.corrected);
  row.residual *= root_weight;
  const Eigen::Matrix2d by_ideal = root_weight * weight * predicted.jacobian;
  row.pose = by_ideal * row.pose;
  row.intrinsics = by_ideal * row.intrinsics;
  return row;
}

// Adds the rows of one point to the system and takes the point out. Nothing where they do not determine it.
std::optional<EliminatedPoint> Eliminate(const std::vector<Row>& rows, ReducedSystem& system) {
  if (rows.size() < kFewestInTrack) return std::nullopt;
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  IntrinsicsBlock by_intrinsics = IntrinsicsBlock::Zero();
  for (const Row& row : rows) {
    hessian += row.point().transpose() * row.point();
    gradient += row.point().transpose() * row.residual;
    by_intrinsics += row.point().transpose() * row.intrinsics;
  }
  const Eigen::LLT<Eigen::Matrix3d> factor(hessian);
  const Eigen::Vector3d pivots = factor.matrixLLT().diagonal();
  if (factor.info() != Eigen::Success || !(pivots.minCoeff() > kLeastPivot * pivots.maxCoeff())) return std::nullopt;
  // Solved by the lower factor alone, so that products of two halves are what elimination takes off.
  by_intrinsics = factor.matrixL().solve(by_intrinsics).eval();
  gradient = factor.matrixL().solve(gradient).eval();
  std::vector<EliminatedPoint::Edge> halves;
  const int last = system.poses;
  for (const Row& row : rows) {
    system.hessian.bottomRightCorner<kEntries, kEntries>() += row.intrinsics.transpose() * row.intrinsics;
    system.gradient.tail<kEntries>() += row.intrinsics.transpose() * row.residual;
    if (row.column < 0) continue;
    const PoseBlock block = row.point().transpose() * row.pose;
    halves.push_back({row.column, factor.matrixL().solve(block)});
    const PoseBlock& half = halves.back().block;
    system.hessian.block<kPoseDof, kPoseDof>(row.column, row.column) += row.pose.transpose() * row.pose;
    system.hessian.block<kPoseDof, kEntries>(row.column, last) +=
        row.pose.transpose() * row.intrinsics - half.transpose() * by_intrinsics;
    system.gradient.segment<kPoseDof>(row.column) += row.pose.transpose() * row.residual - half.transpose() * gradient;
  }
  system.hessian.bottomRightCorner<kEntries, kEntries>() -= by_intrinsics.transpose() * by_intrinsics;
  system.gradient.tail<kEntries>() -= by_intrinsics.transpose() * gradient;
  // Rows come in the order of keyframes; two of the same keyframe share a block, which wants both their products.
  for (size_t i = 0; i < halves.size(); ++i)
    for (size_t j = 0; j < halves.size(); ++j)
      if (halves[i].column <= halves[j].column)
        system.hessian.block<kPoseDof, kPoseDof>(halves[i].column, halves[j].column) -=
            halves[i].block.transpose() * halves[j].block;
  EliminatedPoint point{factor.matrixU().solve(gradient), factor.matrixU().solve(by_intrinsics), std::move(halves)};
  for (EliminatedPoint::Edge& edge : point.edges) edge.block = factor.matrixU().solve(edge.block).eval();
  return point;
}

// How much each pose's unknowns change when the window grows about its first camera: along it nothing else changes.
Eigen::VectorXd Growth(const std::vector<RigidTransform>& camera_from_world) {
  Eigen::VectorXd growth = Eigen::VectorXd::Zero(kPoseDof * (static_cast<Eigen::Index>(camera_from_world.size()) - 1));
  const Eigen::Vector3d origin = camera_from_world.front().inverse().translation;
  for (size_t k = 1; k < camera_from_world.size(); ++k)
    growth.segment<3>(kPoseDof * (static_cast<Eigen::Index>(k) - 1) + 3) =
        origin - camera_from_world[k].inverse().translation;
  return growth;
}

// Solves for the poses with the unit of length held. Nothing where the points do not determine them.
class PoseSolver {
 public:
  PoseSolver(const ReducedSystem& system, const Eigen::VectorXd& growth) {
    Eigen::MatrixXd hessian = system.hessian.topLeftCorner(system.poses, system.poses).selfadjointView<Eigen::Upper>();
    const double travel = growth.squaredNorm();
    // As stiff as the others; what the gauge is held with changes nothing else.
    const double stiffness = growth.cwiseAbs2().dot(hessian.diagonal()) / travel;
    hessian += stiffness / travel * growth * growth.transpose();
    // Rotations and centres have different units.
    unit_ = hessian.diagonal().cwiseSqrt().cwiseInverse();
    hessian = unit_.asDiagonal() * hessian * unit_.asDiagonal();
    hessian.diagonal().array() += kRounding;
    if (travel > 0 && unit_.allFinite()) factor_.compute(hessian);
    solves_ = travel > 0 && unit_.allFinite() && factor_.info() == Eigen::Success;
  }

  bool solves() const { return solves_; }
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const {
    return unit_.asDiagonal() * factor_.solve(unit_.asDiagonal() * right);
  }

 private:
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd unit_;
  bool solves_ = false;
};

}  // namespace

Pinhole ChangedPinhole(const Pinhole& given, const Vector& change) {
  const double ratio = std::exp(change[IntrinsicsChange::kLogFocal]);
  return {ratio * given.fx, ratio * given.fy, given.cx + change[IntrinsicsChange::kCentreX],
          given.cy + change[IntrinsicsChange::kCentreY]};
}

std::optional<CorrectedPixel> Correct(const CameraModel& camera, const Vector& change,
                                      const Eigen::Vector2d& distorted) {
  const Pinhole pinhole = ChangedPinhole(camera.pinhole, change);
  const Eigen::Vector2d point = pinhole.Ray(distorted).head<2>();
  const std::optional<UndistortedPoint> ideal = UndistortPoint(camera, point);
  if (!ideal) return std::nullopt;
  const double square = point.squaredNorm();
  const auto terms = change.tail<3>();
  const double share = square * (terms[0] + square * (terms[1] + square * terms[2]));
  const double share_by_square = terms[0] + square * (2 * terms[1] + square * 3 * terms[2]);
  const Eigen::RowVector2d share_by_point = 2 * share_by_square * point.transpose();
  const Eigen::Vector2d ray = (1 + share) * ideal->point;
  return CorrectedPixel{pinhole.Project(ray.homogeneous()), ideal->point,
                        (1 + share) * ideal->jacobian + ideal->point * share_by_point};
}

Eigen::Matrix<double, 2, kEntries> IntrinsicsJacobian(const Pinhole& pinhole, const Eigen::Vector3d& x_in_camera,
                                                      const Eigen::Vector2d& distorted,
                                                      const CorrectedPixel& corrected) {
  const Eigen::DiagonalMatrix<double, 2> focal(pinhole.fx, pinhole.fy);
  const Eigen::Matrix2d by_pixel = focal * corrected.jacobian * focal.inverse();
  const double square = distorted.squaredNorm();
  const Eigen::Vector2d outward = focal * corrected.lens_point;
  Eigen::Matrix<double, 2, kEntries> J;
  J.col(IntrinsicsChange::kLogFocal) =
      pinhole.Project(x_in_camera) - corrected.pixel + focal * (corrected.jacobian * distorted);
  J.middleCols<2>(IntrinsicsChange::kCentreX) = by_pixel;
  J.col(IntrinsicsChange::kCorrection) = -square * outward;
  J.col(IntrinsicsChange::kCorrection4) = -square * square * outward;
  J.col(IntrinsicsChange::kCorrection6) = -square * square * square * outward;
  return J;
}

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

void IntrinsicsProblem::Change(const Vector& change) {
  change_ = change;
  bundle_.pinhole = ChangedPinhole(camera_.pinhole, change);
  corrected_.resize(distorted_.size());
  ForEachPart(PartsOf(distorted_.size()), [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const std::optional<CorrectedPixel>& corrected = corrected_[i] = Correct(camera_, change, distorted_[i]);
      // A pixel that this lens cannot show stays distorted: bundle adjustment gives it little weight.
      bundle_.observations[i].pixel = corrected ? corrected->pixel : distorted_[i];
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

void IntrinsicsProblem::EstimatePixelSigma() {
  std::vector<double> lengths;
  for (size_t i = 0; i < bundle_.observations.size(); ++i) {
    const BundleObservation& seen = bundle_.observations[i];
    const Eigen::Vector3d x = bundle_.camera_from_world[seen.camera] * bundle_.points[seen.point];
    if (IsInFront(x)) lengths.push_back((bundle_.pinhole.Project(x) - seen.pixel).norm() / stretch_[i]);
  }
  const double measured = 2.0 * static_cast<double>(lengths.size());
  const double fitted = 3.0 * static_cast<double>(bundle_.points.size()) +
                        kPoseDof * static_cast<double>(bundle_.camera_from_world.size() - 1);
  if (!(measured > fitted)) return;
  const double sigma = Median(std::move(lengths)) / kMedianLength * std::sqrt(measured / (measured - fitted));
  pixel_sigma_ = std::max(sigma, kLeastPixelSigma);
  for (size_t i = 0; i < bundle_.observations.size(); ++i) bundle_.observations[i].sigma = stretch_[i] * pixel_sigma_;
}

std::optional<IntrinsicsEvidence> IntrinsicsProblem::Evidence() {
  const int cameras = static_cast<int>(bundle_.camera_from_world.size());
  if (cameras < 2 || bundle_.observations.empty()) return std::nullopt;
  std::vector<Eigen::Matrix3d> rotations;
  for (const RigidTransform& pose : bundle_.camera_from_world) rotations.push_back(pose.rotation.toRotationMatrix());

  IntrinsicsEvidence evidence;
  evidence.at = change_;
  evidence.pixel_sigma = pixel_sigma_;
  ReducedSystem system(cameras);
  std::vector<std::optional<EliminatedPoint>> points;
  const auto fill_rows = [&](size_t p, std::vector<Row>& rows) {
    rows.clear();
    for (int i = first_observation_[p]; i < first_observation_[p + 1]; ++i) {
      const BundleObservation& seen = bundle_.observations[i];
      const Eigen::Vector3d x = bundle_.camera_from_world[seen.camera] * bundle_.points[p];
      if (!IsInFront(x) || !corrected_[i]) continue;
      const std::optional<Prediction> predicted =
          Predict(camera_, change_, bundle_.pinhole, bundle_.pinhole.Project(x), distorted_[i], *corrected_[i]);
      if (!predicted) continue;
      rows.push_back(MakeRow(bundle_.pinhole, rotations[seen.camera], x, *predicted, distorted_[i], pixel_sigma_,
                             huber_threshold_));
      rows.back().column = kPoseDof * (seen.camera - 1);
    }
  };
  // Rows are filled on several threads, and added up in the order of the points.
  std::array<std::vector<Row>, kPointsTogether> rows;
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

  const PoseSolver solver(system, Growth(bundle_.camera_from_world));
  if (!solver.solves()) return std::nullopt;
  const Eigen::MatrixXd cross = system.hessian.topRightCorner(system.poses, kEntries);
  camera_response_ = -solver.Solve(cross);
  camera_step_ = -solver.Solve(system.gradient.head(system.poses));
  evidence.information = system.hessian.bottomRightCorner<kEntries, kEntries>() + cross.transpose() * camera_response_;
  evidence.information = 0.5 * (evidence.information + evidence.information.transpose()).eval();
  evidence.gradient = system.gradient.tail<kEntries>() + cross.transpose() * camera_step_;
  if (!evidence.information.allFinite() || !evidence.gradient.allFinite()) return std::nullopt;

  point_response_.assign(points.size(), IntrinsicsBlock::Zero());
  point_step_.assign(points.size(), Eigen::Vector3d::Zero());
  for (size_t p = 0; p < points.size(); ++p) {
    if (!points[p]) continue;
    point_response_[p] = -points[p]->by_intrinsics;
    point_step_[p] = -points[p]->step;
    for (const EliminatedPoint::Edge& edge : points[p]->edges) {
      point_response_[p] -= edge.block * camera_response_.middleRows<kPoseDof>(edge.column);
      point_step_[p] -= edge.block * camera_step_.segment<kPoseDof>(edge.column);
    }
  }
  return evidence;
}

void IntrinsicsProblem::Follow(const Vector& change) {
  const Vector step = change - change_;
  const Eigen::VectorXd cameras = camera_response_ * step + camera_step_;
  for (size_t k = 1; k < bundle_.camera_from_world.size(); ++k) {
    RigidTransform& pose = bundle_.camera_from_world[k];
    const auto move = cameras.segment<kPoseDof>(kPoseDof * (static_cast<Eigen::Index>(k) - 1));
    const Eigen::Vector3d centre = pose.inverse().translation - move.tail<3>();
    pose.rotation = (RotationFromVector(move.head<3>()) * pose.rotation).normalized();
    pose.translation = -(pose.rotation * centre);
  }
  for (size_t p = 0; p < bundle_.points.size(); ++p) {
    const Eigen::Vector3d moved = bundle_.points[p] + point_response_[p] * step + point_step_[p];
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
