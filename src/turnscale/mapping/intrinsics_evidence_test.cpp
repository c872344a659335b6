// SPDX-License-Identifier: MIT
#include "turnscale/mapping/intrinsics_evidence.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/rolling_shutter.h"
#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/mapping/test_intrinsics.h"

namespace turnscale {
namespace {

constexpr int kEntries = IntrinsicsChange::kEntries;
using Vector = IntrinsicsChange::Vector;
using Matrix = IntrinsicsChange::Matrix;

const std::vector<DriveSegment> kCorner = {{4, 0.8, 0}, {12, 0.7, 0.07}, {3, 0.8, 0}};

Map CornerMap(double points_per_step, double noise, unsigned seed, double unit = 1) {
  const CarDrive drive = MakeCarDrive(kCorner, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  Map map = MakeMap(drive, {.points_per_step = points_per_step, .pixel_noise = noise, .seed = seed});
  for (Keyframe& keyframe : map.keyframes) keyframe.camera_from_world.translation *= unit;
  for (Landmark& landmark : map.landmarks) landmark.position *= unit;
  return map;
}

IntrinsicsWindow Whole(const Map& map) {
  IntrinsicsWindow window;
  window.last = CountKeyframes(map) - 1;
  return window;
}

// The distorted pixel that is corrected to `ideal`, from one nearby.
Eigen::Vector2d Distorted(const CameraModel& given, const Vector& change, const Eigen::Vector2d& ideal,
                          const Eigen::Vector2d& begin) {
  Eigen::Vector2d pixel = begin;
  const Pinhole pinhole = ChangedPinhole(given.pinhole, change);
  const Eigen::DiagonalMatrix<double, 2> focal(pinhole.fx, pinhole.fy);
  for (int round = 0; round < 10; ++round) {
    const CorrectedPixel corrected = *Correct(given, change, pixel);
    pixel += focal * corrected.jacobian.inverse() * focal.inverse() * (ideal - corrected.pixel);
  }
  return pixel;
}

// What a camera sees, and how far each pixel moves while its row waits.
struct SeenPixels {
  std::vector<Eigen::Vector2d> raw;
  std::vector<Eigen::Vector2d> row_motion;
};

// Residuals of all observations in the distorted image, in sigmas, when poses, points and intrinsics move: six numbers
// a pose but the first (rotation vector, centre), three a point, the change of the intrinsics.
Eigen::VectorXd Residuals(const BundleProblem& bundle, const SeenPixels& all, double sigma, const CameraModel& given,
                          const Vector& change, const Eigen::VectorXd& step) {
  const std::vector<Eigen::Vector2d>& raw = all.raw;
  const Vector moved = change + step.tail<kEntries>();
  const Pinhole pinhole = ChangedPinhole(given.pinhole, moved);
  const Eigen::Index points = 6 * (static_cast<Eigen::Index>(bundle.camera_from_world.size()) - 1);
  Eigen::VectorXd residuals(2 * static_cast<Eigen::Index>(raw.size()));
  for (size_t i = 0; i < raw.size(); ++i) {
    const BundleObservation& seen = bundle.observations[i];
    const RigidTransform& pose = bundle.camera_from_world[seen.camera];
    Eigen::Vector3d offset =
        bundle.points[seen.point] + step.segment<3>(points + 3 * seen.point) - pose.inverse().translation;
    Eigen::Quaterniond rotation = pose.rotation;
    if (seen.camera > 0) {
      const auto move = step.segment<6>(6 * (seen.camera - 1));
      rotation = RotationFromVector(move.head<3>()) * rotation;
      offset -= move.tail<3>();
    }
    const Eigen::Vector2d predicted =
        pinhole.Project(rotation * offset) + moved[IntrinsicsChange::kReadout] * all.row_motion[i];
    residuals.segment<2>(2 * static_cast<Eigen::Index>(i)) =
        (Distorted(given, moved, predicted, raw[i]) - raw[i]) / sigma;
  }
  return residuals;
}

void ExpectTheFullNormalEquations(LensModel lens, double correction) {
  const Map map = CornerMap(2, 0.3, 2);
  IntrinsicsWindow window = Whole(map);
  window.huber_threshold = 0;
  window.last = 9;
  CameraModel camera = map.camera;
  camera.radial_correction = lens == LensModel::kPinhole ? 0.004 : 0;
  camera.lens = lens;
  if (lens != LensModel::kPinhole) camera.distortion = {-0.1, 0.02, 0.001, -0.001, 0};
  constexpr double kSigma = 0.5;
  IntrinsicsProblem problem(map, camera, window, kSigma);
  Vector change = Change(0.02, 3, -2, correction);
  change[IntrinsicsChange::kLogAspect] = -0.03;
  change[IntrinsicsChange::kReadout] = 0.01;
  const BundleProblem& bundle = problem.bundle();
  SeenPixels raw;
  for (const BundleObservation& seen : bundle.observations) {
    raw.raw.push_back(*camera.Project(camera.pinhole.Ray(seen.pixel)));
    raw.row_motion.push_back(RowMotion(map, seen.camera, bundle.points[seen.point], raw.raw.back(), {}));
  }
  problem.Change(change);
  const std::optional<IntrinsicsEvidence> evidence = problem.Evidence();
  ASSERT_TRUE(evidence);

  const Eigen::Index poses = 6 * (static_cast<Eigen::Index>(bundle.camera_from_world.size()) - 1);
  const Eigen::Index others = poses + 3 * static_cast<Eigen::Index>(bundle.points.size());
  Eigen::MatrixXd J(2 * static_cast<Eigen::Index>(raw.raw.size()), others + kEntries);
  for (Eigen::Index i = 0; i < J.cols(); ++i) {
    const Eigen::VectorXd h = 1e-5 * Eigen::VectorXd::Unit(J.cols(), i);
    J.col(i) =
        (Residuals(bundle, raw, kSigma, camera, change, h) - Residuals(bundle, raw, kSigma, camera, change, -h)) / 2e-5;
  }
  const Eigen::VectorXd r = Residuals(bundle, raw, kSigma, camera, change, Eigen::VectorXd::Zero(J.cols()));
  // What is left of the intrinsics' columns once all others have explained what they can. How far the last camera is
  // along z stays as it is, which holds the unit of length.
  Eigen::MatrixXd rest(J.rows(), others - 1);
  rest << J.leftCols(poses - 1), J.middleCols(poses, others - poses);
  rest = rest.colwise().normalized().eval();
  const Eigen::MatrixXd columns = J.rightCols<kEntries>();
  const Eigen::MatrixXd left = columns - rest * rest.householderQr().solve(columns);
  const Matrix information = left.transpose() * left;
  const Vector gradient = left.transpose() * r;
  const Vector unit = information.diagonal().cwiseSqrt().cwiseInverse();
  EXPECT_NEAR((unit.asDiagonal() * (evidence->information - information) * unit.asDiagonal()).norm(), 0, 1e-4);
  EXPECT_NEAR((unit.asDiagonal() * (evidence->gradient - gradient)).norm(), 0,
              1e-4 * (unit.asDiagonal() * gradient).norm());
}

TEST(IntrinsicsEvidence, IsWhatTheFullNormalEquationsLeaveForTheIntrinsics) {
  ExpectTheFullNormalEquations(LensModel::kPinhole, 0.004);
  ExpectTheFullNormalEquations(LensModel::kRadialTangential, 0.03);
  ExpectTheFullNormalEquations(LensModel::kEquidistant, -0.03);
}

TEST(IntrinsicsEvidence, DoesNotDependOnTheUnitOfLength) {
  std::vector<IntrinsicsEvidence> evidence;
  for (const double unit : {1.0, 100.0}) {
    const Map map = CornerMap(10, 0.3, 3, unit);
    IntrinsicsProblem problem(map, map.camera, Whole(map), 0.5);
    ASSERT_TRUE(problem.Adjust(20));
    const std::optional<IntrinsicsEvidence> found = problem.Evidence();
    ASSERT_TRUE(found);
    evidence.push_back(*found);
  }
  for (int i = 0; i < kEntries; ++i)
    EXPECT_NEAR(evidence[1].information(i, i) / evidence[0].information(i, i), 1, 1e-4);
}

double MeanResidual(const IntrinsicsProblem& problem) {
  double sum = 0;
  int count = 0;
  for (const double length : problem.Residuals()) {
    if (!std::isfinite(length)) continue;
    sum += length;
    ++count;
  }
  return count > 0 ? sum / count : HUGE_VAL;
}

TEST(IntrinsicsProblem, ResidualsAreWhatThePixelsAreOff) {
  const Map map = CornerMap(10, 0.3, 5);
  IntrinsicsProblem problem(map, map.camera, Whole(map), 0.5);
  const std::vector<double> residuals = problem.Residuals();
  ASSERT_EQ(residuals.size(), problem.bundle().observations.size());
  const BundleProblem& bundle = problem.bundle();
  for (size_t i = 0; i < residuals.size(); ++i) {
    const BundleObservation& seen = bundle.observations[i];
    const Eigen::Vector3d x = bundle.camera_from_world[seen.camera] * bundle.points[seen.point];
    EXPECT_NEAR(residuals[i], (map.camera.pinhole.Project(x) - seen.pixel).norm(), 1e-9);
  }
  // The mean length of two normal errors.
  EXPECT_NEAR(MeanResidual(problem), 0.3 * std::sqrt(std::numbers::pi / 2), 0.03);
  // In the image, an error is what it was before the pixels are moved apart.
  IntrinsicsProblem wider(map, map.camera, Whole(map), 0.5);
  wider.Change(Change(0.1, 0, 0, 0));
  EXPECT_GT(MeanResidual(wider), 3);
}

TEST(IntrinsicsProblem, ReadingAcrossExplainsAReadoutAlongTheColumns) {
  constexpr double kSeconds = 0.02;
  const CarDrive drive = MakeCarDrive(kCorner, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  for (const bool reads_columns : {false, true}) {
    const Map map =
        MakeMap(drive, {.points_per_step = 10, .pixel_noise = 0, .readout = kSeconds, .reads_columns = reads_columns});
    IntrinsicsProblem along(map, map.camera, Whole(map), 0.5);
    EXPECT_EQ(along.read_direction(), ReadDirection());
    Vector change = Vector::Zero();
    change[IntrinsicsChange::kReadout] = kSeconds;
    along.Change(change);
    IntrinsicsProblem across = along;
    across.ReadAcross();
    EXPECT_EQ(across.read_direction(), (ReadDirection{1, 0}));
    const double right = MeanResidual(reads_columns ? across : along);
    EXPECT_LT(right, 0.1 * MeanResidual(reads_columns ? along : across)) << reads_columns;
    across.ReadAcross();
    EXPECT_EQ(across.read_direction(), ReadDirection());
    EXPECT_EQ(across.Residuals(), along.Residuals()) << "back again";
  }
}

// Seen for longest, in a straight, is what lies ahead.
TEST(IntrinsicsEvidence, LandmarksAreTakenFromAllOverTheView) {
  const CarDrive drive = MakeCarDrive({{20, 0.8, 0}}, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  const Map map = MakeMap(drive, {.points_per_step = 60, .seed = 3});
  const auto is_outer = [&](const Eigen::Vector2d& pixel) { return std::abs(map.camera.pinhole.Ray(pixel).x()) > 0.5; };
  std::vector<Landmark> longest = map.landmarks;
  std::ranges::stable_sort(longest, std::ranges::greater(),
                           [](const Landmark& landmark) { return landmark.observations.size(); });
  longest.resize(100);
  double outer = 0;
  double all = 0;
  for (const Landmark& landmark : longest)
    for (const LandmarkObservation& seen : landmark.observations) {
      outer += is_outer(seen.pixel) ? 1 : 0;
      all += 1;
    }
  IntrinsicsWindow window = Whole(map);
  window.max_landmarks = 100;
  const IntrinsicsProblem problem(map, map.camera, window, 0.3);
  EXPECT_EQ(problem.landmarks(), 100);
  const auto& taken = problem.bundle().observations;
  const auto taken_outer = std::ranges::count_if(taken, [&](const auto& seen) { return is_outer(seen.pixel); });
  EXPECT_GT(static_cast<double>(taken_outer) / static_cast<double>(taken.size()), 1.25 * outer / all);
}

TEST(IntrinsicsEvidence, FollowingAndLookingAgainLeadsToTheTruth) {
  const Map truth = CornerMap(10, 0, 4);
  for (const Vector& error :
       {Change(0.15, 0, 0, 0), Change(-0.15, 0, 0, 0), Change(0, 20, -15, 0), Change(0.03, 5, 0, 0.01)}) {
    Map map = truth;
    map.camera.pinhole = ChangedPinhole(truth.camera.pinhole, error);
    for (Landmark& landmark : map.landmarks)
      for (LandmarkObservation& seen : landmark.observations)
        seen.pixel = UndoRadialCorrection(truth.camera.pinhole, error[IntrinsicsChange::kCorrection], seen.pixel);
    IntrinsicsProblem problem(map, map.camera, Whole(map), 0.5);
    ASSERT_TRUE(problem.Adjust(20));
    for (int round = 0; round < 8; ++round) {
      const std::optional<IntrinsicsEvidence> evidence = problem.Evidence();
      ASSERT_TRUE(evidence);
      const Vector step = -evidence->information.ldlt().solve(evidence->gradient);
      problem.Follow(*evidence, problem.change() + std::min(1.0, 0.1 / std::abs(step[0])) * step);
      ASSERT_TRUE(problem.Adjust(10));
    }
    const Vector found = problem.change();
    EXPECT_NEAR(found[0], -error[0], 1e-5);
    EXPECT_NEAR(found[1], -error[1], 1e-3);
    EXPECT_NEAR(found[2], -error[2], 1e-3);
  }
}

}  // namespace
}  // namespace turnscale
