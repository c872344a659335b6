// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/calibration_check.h"
#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/mapping/test_calibration.h"
#include "turnscale/mapping/test_intrinsics.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;

TEST(CalibrationCheckReadout, ARollingShutterIsNoOtherCamera) {
  for (const double readout : {0.025, -0.025}) {
    Vector error = Vector::Zero();
    error[IntrinsicsChange::kReadout] = -readout;
    const Map map = WrongMap(kRightAndLeft, error, 0.3, 4);
    const CalibrationCheck check = CheckAlong(map);
    EXPECT_TRUE(check.Contradictions(WithCorrection()).empty()) << readout;
    ASSERT_TRUE(check.Readout(WithCorrection()));
    EXPECT_NEAR(check.Readout(WithCorrection())->seconds, readout, 0.002);
    EXPECT_LT(check.Readout(WithCorrection())->sigma, 0.002);
    EXPECT_NEAR(check.Estimate().change[IntrinsicsChange::kCentreY], 0, 2);
    CalibrationCheckOptions global;
    global.readout_prior_sigma = 1e-6;
    EXPECT_FALSE(CheckAlong(map, global).Contradictions(WithCorrection()).empty()) << "it has to be estimated";
  }
}

// A clockwise quarter turn of the image, about its corner: what was below is on the left.
Map TurnedByQuarter(Map map) {
  const Pinhole before = map.camera.pinhole;
  const int height = map.camera.height;
  map.camera.pinhole = {before.fy, before.fx, height - 1 - before.cy, before.cx};
  map.camera.height = std::exchange(map.camera.width, height);
  map.camera.read_direction = {-1, 0};
  const auto turn = [&](auto& observations) {
    for (auto& seen : observations) seen.pixel = {height - 1 - seen.pixel.y(), seen.pixel.x()};
  };
  const RigidTransform quarter{RotationFromVector({0, 0, 0.5 * std::numbers::pi}), Eigen::Vector3d::Zero()};
  for (Keyframe& keyframe : map.keyframes) {
    keyframe.camera_from_world = quarter * keyframe.camera_from_world;
    turn(keyframe.observations);
  }
  for (Landmark& landmark : map.landmarks) turn(landmark.observations);
  return map;
}

TEST(CalibrationCheckReadout, RowsAreThoseOfTheSensor) {
  Vector error = Vector::Zero();
  error[IntrinsicsChange::kReadout] = -0.025;
  Map upright = WrongMap(kRightAndLeft, error, 0.3, 4);
  for (int quarters = 0; quarters < 4; ++quarters) {
    const CalibrationCheck check = CheckAlong(upright);
    EXPECT_TRUE(check.Contradictions(WithCorrection()).empty()) << quarters;
    const std::optional<ShutterReadout> readout = check.Readout(upright.camera);
    ASSERT_TRUE(readout) << quarters;
    EXPECT_NEAR(readout->seconds, 0.025, 0.002) << quarters;
    EXPECT_EQ(readout->direction, upright.camera.read_direction);
    const ReadDirection read = upright.camera.read_direction;
    upright = TurnedByQuarter(std::move(upright));
    upright.camera.read_direction = {-read.y, read.x};
  }
}

// As in a video of a camera that hangs sideways, which was rotated and encoded anew.
TEST(CalibrationCheckReadout, AReadoutAlongTheColumnsIsNoOtherCamera) {
  for (const double readout : {0.025, -0.025}) {
    Vector error = Vector::Zero();
    error[IntrinsicsChange::kReadout] = -readout;
    const Map map = WrongMap(kRightAndLeft, error, 0.3, 4, Eigen::Quaterniond::Identity(), true);
    const CalibrationCheck check = CheckAlong(map);
    EXPECT_TRUE(check.IsReadAcross()) << readout;
    EXPECT_TRUE(check.Contradictions(map.camera).empty()) << readout;
    const std::optional<ShutterReadout> found = check.Readout(map.camera);
    ASSERT_TRUE(found) << readout;
    EXPECT_NEAR(found->seconds, std::abs(readout), 0.003);
    EXPECT_EQ(found->direction, (ReadDirection{readout > 0 ? 1 : -1, 0}));
    EXPECT_TRUE(check.Estimate().Holds(IntrinsicsChange::kLogAspect));
    EXPECT_NEAR(check.Estimate().change[IntrinsicsChange::kCentreX], 0, 4);
  }
}

TEST(CalibrationCheckReadout, OtherCamerasAreNotReadAlongTheirColumns) {
  for (const Vector& error : {Change(0.14, 0, 0, 0), Change(0, 40, 0, 0), Change(0, 0, 40, 0)}) {
    const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, error, 0.3, 4));
    EXPECT_FALSE(check.IsReadAcross()) << error.transpose();
    EXPECT_FALSE(check.Contradictions(WithCorrection()).empty()) << error.transpose();
  }
  Vector error = Vector::Zero();
  error[IntrinsicsChange::kReadout] = -0.025;
  EXPECT_FALSE(CheckAlong(WrongMap(kRightAndLeft, error, 0.3, 4)).IsReadAcross());
}

CalibrationCheck CheckWithReadout(const Map& map, const GivenReadout& readout) {
  return CheckAlong(map, {}, Vector::Zero(), readout);
}

TEST(CalibrationCheckReadout, AReadoutThatIsKnownIsRefined) {
  Vector error = Vector::Zero();
  error[IntrinsicsChange::kReadout] = -0.025;
  const Map map = WrongMap(kRightAndLeft, error, 0.3, 4);
  // Off by less than what is reported.
  const CalibrationCheck check = CheckWithReadout(map, {0.022, 0.002});
  EXPECT_TRUE(check.Contradictions(map.camera).empty());
  ASSERT_TRUE(check.Readout(map.camera));
  EXPECT_NEAR(check.Readout(map.camera)->seconds, 0.025, 0.0015);
  EXPECT_LE(check.Readout(map.camera)->sigma, 0.002);
  EXPECT_EQ(Of(IntrinsicsParameter::kReadout, check).given, 0.022);
}

TEST(CalibrationCheckReadout, AReadoutThatIsContradictedIsReportedAndReplaced) {
  const Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 4);
  const CalibrationCheck check = CheckWithReadout(map, {0.02, 0.001});
  EXPECT_TRUE(check.Contradictions(map.camera).empty()) << "the camera is right";
  const std::optional<ParameterEstimate> contradicted = check.ContradictedReadout(map.camera);
  ASSERT_TRUE(contradicted);
  EXPECT_EQ(contradicted->given, 0.02);
  EXPECT_NEAR(contradicted->found, 0, 0.001);
  EXPECT_LT(contradicted->sigma, 0.003);
  EXPECT_EQ(check.Verdict(map.camera), CalibrationVerdict::kNotContradicted) << "with the other readout";
  EXPECT_FALSE(check.Readout(map.camera)) << "a global shutter";
  EXPECT_TRUE(check.Estimate().Holds(IntrinsicsChange::kReadout));
  EXPECT_EQ(check.Estimate().change[IntrinsicsChange::kReadout], 0);
}

TEST(CalibrationCheckReadout, AnotherReadoutThanTheKnownOneTakesItsPlace) {
  Vector error = Vector::Zero();
  error[IntrinsicsChange::kReadout] = -0.025;
  const Map map = WrongMap(kRightAndLeft, error, 0.3, 4);
  for (const double given : {0.0, 0.01, -0.025, 0.15}) {
    const CalibrationCheck check = CheckWithReadout(map, {given, 0.0005});
    ASSERT_TRUE(check.ContradictedReadout(map.camera)) << given;
    EXPECT_NEAR(check.ContradictedReadout(map.camera)->found, 0.025, 0.002) << given;
    ASSERT_TRUE(check.Readout(map.camera)) << given;
    EXPECT_NEAR(check.Readout(map.camera)->seconds, 0.025, 0.002) << given;
    EXPECT_TRUE(check.Contradictions(map.camera).empty()) << given;
  }
}

// A wrong camera may look like another readout.
TEST(CalibrationCheckReadout, AReadoutThatIsKnownStaysWhereTheCameraIsContradicted) {
  const Map map = WrongMap(kRightAndLeft, Change(0.14, 0, 0, 0), 0.3, 4);
  const CalibrationCheck check = CheckWithReadout(map, {0.02, 0.0005});
  EXPECT_FALSE(check.Contradictions(map.camera).empty());
  EXPECT_FALSE(check.ContradictedReadout(map.camera));
  ASSERT_TRUE(check.Readout(map.camera));
  EXPECT_EQ(check.Readout(map.camera)->seconds, 0.02);
}

TEST(CalibrationCheckReadout, AGlobalShutterMayBeKnown) {
  CameraModel camera;
  EXPECT_FALSE(ReadoutOf(camera));
  camera.readout_sigma = 0.0005;
  ASSERT_TRUE(ReadoutOf(camera));
  const Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 4);
  const CalibrationCheck check = CheckWithReadout(map, *ReadoutOf(camera));
  EXPECT_GT(check.windows(), 1);
  EXPECT_FALSE(check.ContradictedReadout(map.camera));
  EXPECT_FALSE(check.Readout(map.camera));
  EXPECT_FALSE(check.Estimate().Holds(IntrinsicsChange::kReadout));
  EXPECT_NEAR(check.Estimate().change[IntrinsicsChange::kReadout], 0, 0.001);
}

// Long enough for more windows than are kept.
const std::vector<DriveSegment> kManyTurns = {{4, 0.8, 0}, {22, 0.7, 0.07}, {4, 0.8, 0}, {22, 0.7, -0.07},
                                              {4, 0.8, 0}, {22, 0.7, 0.07}, {4, 0.8, 0}, {22, 0.7, -0.07},
                                              {4, 0.8, 0}, {22, 0.7, 0.07}, {4, 0.8, 0}, {22, 0.7, -0.07},
                                              {4, 0.8, 0}, {22, 0.7, 0.07}};

// All windows there are, one after another.
CalibrationCheck CheckWindows(const Map& whole, int windows, const CalibrationCheckOptions& options = {}) {
  CalibrationCheck check(options, whole.camera.pinhole);
  const int last_first = CountKeyframes(whole) - options.window;
  for (int i = 0; i < windows; ++i) {
    IntrinsicsProblem window = WindowFrom(last_first * i / (windows - 1), whole, options);
    EXPECT_TRUE(check.Read(window)) << i;
  }
  EXPECT_EQ(check.windows(), windows);
  return check;
}

TEST(CalibrationCheckReadout, TheDirectionIsThatOfTheSensorAfterMoreWindowsThanAreKept) {
  constexpr int kWindows = 18;
  Vector error = Vector::Zero();
  error[IntrinsicsChange::kReadout] = -0.025;
  const Map columns = WrongMap(kManyTurns, error, 0.3, 4, Eigen::Quaterniond::Identity(), true);
  const CalibrationCheck across = CheckWindows(columns, kWindows);
  EXPECT_TRUE(across.IsReadAcross());
  ASSERT_TRUE(across.Readout(columns.camera));
  EXPECT_NEAR(across.Readout(columns.camera)->seconds, 0.025, 0.003);
  EXPECT_TRUE(across.Contradictions(columns.camera).empty());
  const Map rows = WrongMap(kManyTurns, error, 0.3, 4);
  const CalibrationCheck along = CheckWindows(rows, kWindows);
  EXPECT_FALSE(along.IsReadAcross());
  ASSERT_TRUE(along.Readout(rows.camera));
  EXPECT_NEAR(along.Readout(rows.camera)->seconds, 0.025, 0.002);
  EXPECT_FALSE(CheckWindows(WrongMap(kManyTurns, Change(0, 40, 0, 0), 0.3, 4), kWindows).IsReadAcross());
}

// One direction explains the windows better, but not by as much as is asked for.
TEST(CalibrationCheckReadout, ADirectionThatIsOpenCorrectsNothingAndWidensSigmas) {
  Vector error = Vector::Zero();
  error[IntrinsicsChange::kReadout] = -0.025;
  const Map map = WrongMap(kRightAndLeft, error, 0.3, 4, Eigen::Quaterniond::Identity(), true);
  CalibrationCheckOptions options;
  options.significance = 8;
  options.pixel_sigma_inflation = 11;
  const CalibrationCheck check = CheckAlong(map, options);
  ASSERT_TRUE(check.IsDirectionOpen());
  EXPECT_FALSE(check.IsReadAcross());
  EXPECT_FALSE(check.Readout(map.camera));
  EXPECT_FALSE(check.LatestReadout());
  const Vector sigmas = check.Estimate().covariance.diagonal().cwiseSqrt();
  EXPECT_NEAR(Of(IntrinsicsParameter::kCentreX, check).sigma, sigmas[IntrinsicsChange::kCentreX], 1e-9);
  EXPECT_NEAR(Of(IntrinsicsParameter::kCentreY, check).sigma, sigmas[IntrinsicsChange::kCentreY], 1e-9);
  EXPECT_TRUE(check.Contradictions(map.camera).empty());
}

TEST(CalibrationCheckReadout, AReadoutThatIsKnownStaysWithoutATurn) {
  const Map map = WrongMap(kStreet, Vector::Zero(), 0.3, 11);
  const CalibrationCheck check = CheckWithReadout(map, {0.02, 0.001});
  EXPECT_EQ(check.windows(), 0);
  ASSERT_TRUE(check.Readout(map.camera));
  EXPECT_EQ(check.Readout(map.camera)->seconds, 0.02);
  EXPECT_EQ(check.Readout(map.camera)->sigma, 0.001);
}

}  // namespace
}  // namespace turnscale
