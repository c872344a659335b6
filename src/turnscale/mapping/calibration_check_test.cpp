// SPDX-License-Identifier: MIT
#include "turnscale/mapping/calibration_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/base/test_seeds.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/mapping/test_intrinsics.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;

const std::vector<DriveSegment> kStreet = {{60, 0.8, 0}};

// A drive read with a calibration that is off by `error`: to be right, the pinhole has to change by minus that, and
// pixels want error[kCorrection] as correction.
Map WrongMap(const std::vector<DriveSegment>& segments, const Vector& error, double noise, unsigned seed,
             const Eigen::Quaterniond& vehicle_from_camera = Eigen::Quaterniond::Identity(),
             bool reads_columns = false) {
  const CarDrive drive = MakeCarDrive(segments, 0.1, {1.2, 0}, vehicle_from_camera);
  Map map = MakeMap(drive, {.points_per_step = 25,
                            .pixel_noise = noise,
                            .seed = seed,
                            .readout = -error[IntrinsicsChange::kReadout],
                            .reads_columns = reads_columns});
  const Pinhole truth = map.camera.pinhole;
  map.camera.pinhole = ChangedPinhole(truth, error);
  const auto seen_through_lens = [&](const Eigen::Vector2d& pixel) {
    return UndoRadialCorrection(truth, error[IntrinsicsChange::kCorrection], pixel);
  };
  for (Keyframe& keyframe : map.keyframes)
    for (KeyframeObservation& seen : keyframe.observations) seen.pixel = seen_through_lens(seen.pixel);
  for (Landmark& landmark : map.landmarks)
    for (LandmarkObservation& seen : landmark.observations) seen.pixel = seen_through_lens(seen.pixel);
  return map;
}

// The camera of these maps with the correction that is applied.
CameraModel WithCorrection(double correction = 0) {
  CameraModel camera;
  camera.pinhole = kTestPinhole;
  camera.radial_correction = correction;
  return camera;
}

ParameterEstimate Of(IntrinsicsParameter parameter, const std::vector<ParameterEstimate>& estimates) {
  const auto found = std::ranges::find(estimates, parameter, &ParameterEstimate::parameter);
  return found == estimates.end() ? ParameterEstimate() : *found;
}

ParameterEstimate Of(IntrinsicsParameter parameter, const CalibrationCheck& check) {
  return Of(parameter, check.Parameters(WithCorrection()));
}

CalibrationCheck CheckAlong(const Map& whole, const CalibrationCheckOptions& options = {}) {
  CalibrationCheck check(options, whole.camera.pinhole);
  for (int keyframes = 1; keyframes <= CountKeyframes(whole); ++keyframes) check.Observe(MapUpTo(keyframes, whole));
  return check;
}

TEST(CalibrationCheck, FindsAWrongFocalLength) {
  for (const double percent : {15.0, -15.0, 5.0, -5.0})
    for (int seed = 1; seed <= SeedsToTest(2); ++seed) {
      const Vector error = Change(std::log(1 + percent / 100), 0, 0, 0);
      const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, error, 0.3, static_cast<unsigned>(seed)));
      const std::vector<ParameterEstimate> found = check.Contradictions(WithCorrection());
      ASSERT_EQ(found.size(), 1U) << percent;
      EXPECT_EQ(found[0].parameter, IntrinsicsParameter::kFocalLength);
      EXPECT_NEAR(found[0].given, 718 * (1 + percent / 100), 1e-6);
      EXPECT_NEAR(found[0].found, 718, 1.6 * found[0].sigma);
      EXPECT_LT(found[0].sigma, 0.015 * 718);
    }
}

TEST(CalibrationCheck, FindsAWrongPrincipalPoint) {
  for (const Vector& error : {Change(0, 25, 0, 0), Change(0, 0, -25, 0)}) {
    const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, error, 0.3, 3));
    const ParameterEstimate x = Of(IntrinsicsParameter::kCentreX, check);
    const ParameterEstimate y = Of(IntrinsicsParameter::kCentreY, check);
    EXPECT_NEAR(x.found, 607, 0.2 * x.sigma);
    EXPECT_NEAR(y.found, 185, 0.2 * y.sigma);
    const std::vector<ParameterEstimate> found = check.Contradictions(WithCorrection());
    ASSERT_EQ(found.size(), 1U) << error.transpose();
    EXPECT_EQ(found[0].parameter,
              error[IntrinsicsChange::kCentreX] != 0 ? IntrinsicsParameter::kCentreX : IntrinsicsParameter::kCentreY);
  }
}

TEST(CalibrationCheck, AnErrorTooSmallForAReportLeavesTheCalibrationInDoubt) {
  const auto verdict = [](double pixels) {
    const Vector error = Change(0, pixels, 0, 0);
    return CheckAlong(WrongMap(kRightAndLeft, error, 0.3, 3)).Verdict(WithCorrection());
  };
  EXPECT_EQ(verdict(0), CalibrationVerdict::kNotContradicted);
  EXPECT_EQ(verdict(8), CalibrationVerdict::kInDoubt);
  EXPECT_EQ(verdict(25), CalibrationVerdict::kContradicted);
  EXPECT_EQ(CalibrationCheck({}, kTestPinhole).Verdict(WithCorrection()), CalibrationVerdict::kNotContradicted);
}

TEST(CalibrationCheck, ADoubtIsLargeAndLessThanAContradiction) {
  const auto check_of = [](double pixels) {
    CalibrationCheckOptions options;
    options.significance = 15;
    return CheckAlong(WrongMap(kRightAndLeft, Change(0, pixels, 0, 0), 0.3, 3), options);
  };
  EXPECT_TRUE(check_of(0).Doubts(WithCorrection()).empty());
  EXPECT_TRUE(check_of(5).Doubts(WithCorrection()).empty()) << "too small for a report";
  const CalibrationCheck check = check_of(25);
  EXPECT_TRUE(check.Contradictions(WithCorrection()).empty());
  const std::vector<ParameterEstimate> doubts = check.Doubts(WithCorrection());
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_EQ(doubts[0].parameter, IntrinsicsParameter::kCentreX);
  EXPECT_TRUE(CheckAlong(WrongMap(kRightAndLeft, Change(0, 25, 0, 0), 0.3, 3)).Doubts(WithCorrection()).empty())
      << "contradicted";
}

TEST(CalibrationCheck, AFocalLengthThatIsNotDeterminedIsInDoubt) {
  EXPECT_FALSE(CalibrationCheck({}, kTestPinhole).DeterminesFocalLength()) << "no window";
  EXPECT_TRUE(CheckAlong(WrongMap(kRightAndLeft, Change(0, 0, 0, 0), 0.3, 3)).DeterminesFocalLength());
  CalibrationCheckOptions options;
  options.pixel_sigma_inflation = 500;
  const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, Change(0, 0, 0, 0), 0.3, 3), options);
  ASSERT_GT(check.windows(), 0);
  EXPECT_FALSE(check.DeterminesFocalLength());
  EXPECT_EQ(check.Verdict(WithCorrection()), CalibrationVerdict::kInDoubt);
}

TEST(CalibrationCheck, TellsALensFromAFocalLength) {
  const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, Change(0, 0, 0, 0.015), 0.3, 4));
  const ParameterEstimate distortion = Of(IntrinsicsParameter::kDistortion, check);
  EXPECT_NEAR(distortion.found, 0.015, 2 * distortion.sigma);
  EXPECT_LT(distortion.sigma, 0.007);
  EXPECT_TRUE(check.Contradictions(WithCorrection(0.015)).empty()) << "applied";
}

// Looks down on the road: about a vertical axis in the image, a scene of another height turns alike.
const Eigen::Quaterniond kPitched = RotationFromYawPitchRoll({0, -0.2, 0.05});

// Pixels of a calibration that takes them for square.
Map SqueezedMap(double aspect, unsigned seed, const Eigen::Quaterniond& vehicle_from_camera = kPitched) {
  Vector error = Vector::Zero();
  error[IntrinsicsChange::kLogAspect] = -std::log(aspect);
  return WrongMap(kRightAndLeft, error, 0.3, seed, vehicle_from_camera);
}

TEST(CalibrationCheck, FindsPixelsThatAreNotSquare) {
  for (const double aspect : {0.5, 0.75, 1.33, 2.0}) {
    const CalibrationCheck check = CheckAlong(SqueezedMap(aspect, 4));
    const ParameterEstimate found = Of(IntrinsicsParameter::kPixelAspect, check);
    EXPECT_NEAR(found.given, 1 / aspect, 1e-9);
    EXPECT_NEAR(found.found, 1, 2 * found.sigma) << aspect;
    EXPECT_LT(found.sigma, 0.08) << aspect;
    EXPECT_TRUE(check.Contradicts(found)) << aspect;
    // The others are right, and so are their estimates.
    const std::vector<ParameterEstimate> contradictions = check.Contradictions(WithCorrection());
    ASSERT_EQ(contradictions.size(), 1U) << aspect;
    EXPECT_EQ(contradictions[0].parameter, IntrinsicsParameter::kPixelAspect);
    const ParameterEstimate y = Of(IntrinsicsParameter::kCentreY, check);
    EXPECT_NEAR(y.found, 185, 2 * y.sigma) << aspect;
    const ParameterEstimate focal = Of(IntrinsicsParameter::kFocalLength, check);
    EXPECT_NEAR(focal.found, 718, focal.sigma) << aspect;
  }
}

TEST(CalibrationCheck, ALevelTurnDoesNotShowThePixelsAspect) {
  const CalibrationCheck level = CheckAlong(SqueezedMap(1 / 1.22, 4, Eigen::Quaterniond::Identity()));
  const ParameterEstimate found = Of(IntrinsicsParameter::kPixelAspect, level);
  EXPECT_GT(found.sigma, 0.1);
  EXPECT_FALSE(level.Contradicts(found));
  EXPECT_TRUE(level.Estimate().Holds(IntrinsicsChange::kLogAspect));
}

bool HasAspect(const std::vector<ParameterEstimate>& parameters) {
  return std::ranges::find(parameters, IntrinsicsParameter::kPixelAspect, &ParameterEstimate::parameter) !=
         parameters.end();
}

TEST(CalibrationCheck, AnAspectCanBeLeftOut) {
  CalibrationCheckOptions options;
  options.aspect_prior_sigma = 0;
  const CalibrationCheck check = CheckAlong(SqueezedMap(0.75, 4), options);
  const IntrinsicsEstimate estimate = check.Estimate();
  EXPECT_TRUE(estimate.Holds(IntrinsicsChange::kLogAspect));
  EXPECT_EQ(estimate.change[IntrinsicsChange::kLogAspect], 0);
  EXPECT_FALSE(HasAspect(check.Parameters(WithCorrection())));
  EXPECT_FALSE(HasAspect(check.Contradictions(WithCorrection())));
}

TEST(CalibrationCheck, AnAspectThatDoesNotOccurIsNotReported) {
  // So far from what is expected.
  const auto check_of = [](double expected_aspect) {
    CalibrationCheckOptions options;
    options.aspect_prior_sigma = 10;
    Vector expected = Vector::Zero();
    expected[IntrinsicsChange::kLogAspect] = std::log(expected_aspect);
    const Map map = SqueezedMap(0.75, 4);
    CalibrationCheck check(options, map.camera.pinhole, expected);
    for (int keyframes = 1; keyframes <= CountKeyframes(map); ++keyframes) check.Observe(MapUpTo(keyframes, map));
    return check;
  };
  EXPECT_TRUE(HasAspect(check_of(1).Contradictions(WithCorrection())));
  const CalibrationCheck far = check_of(4);
  EXPECT_TRUE(far.Estimate().Holds(IntrinsicsChange::kLogAspect));
  EXPECT_FALSE(HasAspect(far.Parameters(WithCorrection())));
  EXPECT_FALSE(HasAspect(far.Contradictions(WithCorrection())));
}

// As in passes over a drive: what a pass has changed goes on only as long as the images ask for it.
TEST(CalibrationCheck, TheAspectIsTestedAgainstWhatIsExpected) {
  const double wrong = std::log(1.25);
  Vector expected = Vector::Zero();
  const auto change_of = [&](const Map& map) {
    CalibrationCheck check({}, map.camera.pinhole, expected);
    for (int keyframes = 1; keyframes <= CountKeyframes(map); ++keyframes) check.Observe(MapUpTo(keyframes, map));
    return check.Estimate();
  };
  // The pass before has found the aspect.
  expected[IntrinsicsChange::kLogAspect] = -wrong;
  const IntrinsicsEstimate right = change_of(WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 4, kPitched));
  EXPECT_FALSE(right.Holds(IntrinsicsChange::kLogAspect));
  EXPECT_NEAR(right.change[IntrinsicsChange::kLogAspect], 0, 0.05);
  // It has taken something else for one.
  const IntrinsicsEstimate back = change_of(SqueezedMap(1 / 1.25, 4));
  EXPECT_TRUE(back.Holds(IntrinsicsChange::kLogAspect));
  EXPECT_NEAR(back.change[IntrinsicsChange::kLogAspect], -wrong, 1e-12);
  EXPECT_NEAR(back.change[IntrinsicsChange::kLogFocal], 0, 0.01);
  EXPECT_NEAR(back.change[IntrinsicsChange::kCentreY], 0, 8);
}

// Of a ratio, the sigma is relative, and an error has no bound from below.
TEST(CalibrationCheck, AnAspectIsAsWrongBelowAsAbove) {
  const CalibrationCheck check({}, kTestPinhole);
  for (const double ratio : {0.4, 0.5, 0.8, 1.25, 2.0, 2.5}) {
    const double relative = std::abs(std::log(ratio)) / 3;
    const auto contradicts = [&](double sigma) {
      return check.Contradicts({IntrinsicsParameter::kPixelAspect, 1, ratio, sigma * ratio});
    };
    EXPECT_TRUE(contradicts(0.99 * relative)) << ratio;
    EXPECT_FALSE(contradicts(1.01 * relative)) << ratio;
  }
}

TEST(CalibrationCheck, ARollingShutterIsNoOtherCamera) {
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

TEST(CalibrationCheck, RowsAreThoseOfTheSensor) {
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
TEST(CalibrationCheck, AReadoutAlongTheColumnsIsNoOtherCamera) {
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

TEST(CalibrationCheck, OtherCamerasAreNotReadAlongTheirColumns) {
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
  CalibrationCheck check({}, map.camera.pinhole, Vector::Zero(), readout);
  for (int keyframes = 1; keyframes <= CountKeyframes(map); ++keyframes) check.Observe(MapUpTo(keyframes, map));
  return check;
}

TEST(CalibrationCheck, AReadoutThatIsKnownIsRefined) {
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

TEST(CalibrationCheck, AReadoutThatIsContradictedIsReportedAndReplaced) {
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

TEST(CalibrationCheck, AnotherReadoutThanTheKnownOneTakesItsPlace) {
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
TEST(CalibrationCheck, AReadoutThatIsKnownStaysWhereTheCameraIsContradicted) {
  const Map map = WrongMap(kRightAndLeft, Change(0.14, 0, 0, 0), 0.3, 4);
  const CalibrationCheck check = CheckWithReadout(map, {0.02, 0.0005});
  EXPECT_FALSE(check.Contradictions(map.camera).empty());
  EXPECT_FALSE(check.ContradictedReadout(map.camera));
  ASSERT_TRUE(check.Readout(map.camera));
  EXPECT_EQ(check.Readout(map.camera)->seconds, 0.02);
}

TEST(CalibrationCheck, AGlobalShutterMayBeKnown) {
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
  const int length = options.window;
  const int last_first = CountKeyframes(whole) - length;
  for (int i = 0; i < windows; ++i) {
    IntrinsicsWindow window;
    window.first = last_first * i / (windows - 1);
    window.last = window.first + length - 1;
    window.max_landmarks = options.max_landmarks;
    window.huber_threshold = options.huber_threshold;
    IntrinsicsProblem problem(whole, whole.camera, window, options.pixel_sigma);
    EXPECT_TRUE(check.Read(problem)) << i;
  }
  EXPECT_EQ(check.windows(), windows);
  return check;
}

TEST(CalibrationCheck, TheDirectionIsThatOfTheSensorAfterMoreWindowsThanAreKept) {
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
TEST(CalibrationCheck, ADirectionThatIsOpenCorrectsNothingAndWidensSigmas) {
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

TEST(CalibrationCheck, AReadoutThatIsKnownStaysWithoutATurn) {
  const Map map = WrongMap(kStreet, Vector::Zero(), 0.3, 11);
  const CalibrationCheck check = CheckWithReadout(map, {0.02, 0.001});
  EXPECT_EQ(check.windows(), 0);
  ASSERT_TRUE(check.Readout(map.camera));
  EXPECT_EQ(check.Readout(map.camera)->seconds, 0.02);
  EXPECT_EQ(check.Readout(map.camera)->sigma, 0.001);
}

TEST(CalibrationCheck, FindsAMissingDistortion) {
  // A barrel needs a positive correction.
  for (const double distortion : {0.25, -0.08}) {
    const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, Change(0, 0, 0, distortion), 0.3, 4));
    const std::vector<ParameterEstimate> found = check.Contradictions(WithCorrection());
    ASSERT_EQ(found.size(), 1U) << distortion;
    EXPECT_EQ(found[0].parameter, IntrinsicsParameter::kDistortion);
    EXPECT_NEAR(found[0].found, distortion, 0.03);
  }
}

TEST(CalibrationCheck, SaysNothingWhereTheCalibrationIsRight) {
  for (int seed = 5; seed < 5 + SeedsToTest(6); ++seed) {
    const CalibrationCheck check =
        CheckAlong(WrongMap(kRightAndLeft, Vector::Zero(), 0.3, static_cast<unsigned>(seed)));
    EXPECT_GT(check.windows(), 1);
    EXPECT_TRUE(check.Contradictions(WithCorrection()).empty()) << seed;
    EXPECT_FALSE(check.Readout(WithCorrection())) << seed;
    for (const ParameterEstimate& estimate : check.Parameters(WithCorrection()))
      EXPECT_LT(std::abs(estimate.found - estimate.given), 2.5 * estimate.sigma) << seed;
  }
}

// With derivatives at the measured pixels it is 3 % too long here.
TEST(CalibrationCheck, NoiseDoesNotBiasTheFocalLength) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  double sum = 0;
  int drives = 0;
  for (const unsigned seed : {11U, 12U, 13U, 14U}) {
    sum += CheckAlong(WrongMap(kRightAndLeft, Vector::Zero(), 0.5, seed)).Estimate().change[0];
    ++drives;
  }
  EXPECT_NEAR(sum / drives, 0, 0.004);
}

// The pixels of a camera whose file lacks this correction.
void Distort(const Vector& lens, Map& map) {
  for (Landmark& landmark : map.landmarks)
    for (LandmarkObservation& seen : landmark.observations) {
      const Eigen::Vector2d ideal = seen.pixel;
      for (int round = 0; round < 20; ++round) seen.pixel += ideal - Correct(map.camera, lens, seen.pixel)->pixel;
    }
}

TEST(CalibrationCheck, HigherTermsOfTheLensAreNoFocalLength) {
  for (int seed = 16; seed < 16 + SeedsToTest(2); ++seed) {
    Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.15, static_cast<unsigned>(seed));
    // A camera whose file lacks 0.03 r^2 - 0.03 r^4.
    Vector lens = Change(0, 0, 0, 0.03);
    lens[IntrinsicsChange::kCorrection4] = -0.03;
    Distort(lens, map);
    const CalibrationCheck check = CheckAlong(map);
    EXPECT_NEAR(check.Estimate().change[IntrinsicsChange::kLogFocal], 0, 0.006) << seed;
    const double applied = Of(IntrinsicsParameter::kDistortion, check).found;
    EXPECT_TRUE(check.Contradictions(WithCorrection(applied)).empty()) << seed;
    CalibrationCheckOptions only_square;
    only_square.higher_prior_sigma = 0;
    EXPECT_GT(CheckAlong(map, only_square).Estimate().change[IntrinsicsChange::kLogFocal], 0.03) << seed;
  }
}

TEST(CalibrationCheck, ADistortionCountsByWhatItDoesInTheImage) {
  const auto distortion_of = [](double r2, double r4) {
    Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.15, 18);
    Vector lens = Change(0, 0, 0, r2);
    lens[IntrinsicsChange::kCorrection4] = r4;
    Distort(lens, map);
    const CalibrationCheck check = CheckAlong(map);
    EXPECT_GT(check.windows(), 0);
    const ParameterEstimate distortion = Of(IntrinsicsParameter::kDistortion, check);
    // Of the two, that in r^4 alone is ten sigmas; the others cancel to two or three.
    if (r2 == 0) {
      EXPECT_EQ(check.Contradictions(WithCorrection()).size(), 1U);
    }
    return distortion;
  };
  // All in r^4, and two terms that cancel.
  const ParameterEstimate fourth = distortion_of(0, 0.15);
  EXPECT_NEAR(fourth.found, 0.096, 0.02);
  const ParameterEstimate opposite = distortion_of(0.05, -0.1);
  EXPECT_NEAR(opposite.found, -0.014, 0.02);
}

// What is applied is a share of the square of the radius without distortion, what is found one of that in the image.
TEST(CalibrationCheck, WhatIsAppliedIsStatedAsWhatIsFound) {
  const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 5));
  const auto given = [&](double correction, double k1) {
    CameraModel camera = WithCorrection(correction);
    camera.lens = LensModel::kRadialTangential;
    camera.distortion[0] = k1;
    return Of(IntrinsicsParameter::kDistortion, check.Parameters(camera)).given;
  };
  EXPECT_NEAR(given(0.05, 0), 0.05, 1e-12);
  EXPECT_EQ(given(0, -0.2), 0);
  // u^2 = r^2 + 0.4 r^4 + ..., of which r^4 counts 0.8 times the square of the corner's radius, 0.785.
  EXPECT_GT(given(0.05, -0.2), 0.05 * (1 + 0.4 * 0.8 * 0.785));
  EXPECT_LT(given(0.05, -0.2), 0.05 * 1.7);
  EXPECT_LT(given(0.05, 0.2), 0.045);
}

// What all windows get wrong alike is part of sigma, and one window has its own part.
TEST(CalibrationCheck, OneWindowIsAsUncertainAsAWindowMayBe) {
  const Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 5);
  CalibrationCheckOptions options;
  options.max_windows = 1;
  options.focal_prior_sigma = 10;
  const CalibrationCheck check = CheckAlong(map, options);
  ASSERT_EQ(check.windows(), 1);
  const double sigma = std::sqrt(check.Estimate().covariance(IntrinsicsChange::kLogFocal, IntrinsicsChange::kLogFocal));
  EXPECT_GT(sigma, std::hypot(options.focal_window_sigma, options.focal_model_sigma));
}

TEST(CalibrationCheck, AStreetDoesNotTell) {
  const CalibrationCheck check = CheckAlong(WrongMap(kStreet, Change(0.14, 0, 0, 0), 0.3, 11));
  EXPECT_EQ(check.windows(), 0);
  EXPECT_TRUE(check.Contradictions(WithCorrection()).empty());
  const ParameterEstimate focal = Of(IntrinsicsParameter::kFocalLength, check);
  EXPECT_EQ(focal.found, focal.given);
  EXPECT_NEAR(focal.sigma / focal.given, CalibrationCheckOptions().focal_prior_sigma, 1e-9);
}

TEST(CalibrationCheck, DoesNotLookAcrossAGap) {
  Map map = WrongMap(kRightAndLeft, Change(0.14, 0, 0, 0), 0.3, 12);
  for (int k = 4; k < CountKeyframes(map); k += 5) map.keyframes[k].after_gap = true;
  EXPECT_EQ(CheckAlong(map).windows(), 0);
}

TEST(CalibrationCheck, PixelsThatAreCorrectedAlreadySayTheSame) {
  const Map raw = WrongMap(kRightAndLeft, Change(0, 0, 0, 0.01), 0.3, 13);
  Map corrected = raw;
  corrected.camera.radial_correction = 0.01;
  for (Landmark& landmark : corrected.landmarks)
    for (LandmarkObservation& seen : landmark.observations)
      seen.pixel = CorrectRadially(corrected.camera.pinhole, 0.01, seen.pixel);
  CalibrationCheck from_raw({}, raw.camera.pinhole);
  CalibrationCheck from_corrected({}, corrected.camera.pinhole);
  ASSERT_TRUE(from_raw.Observe(raw));
  ASSERT_TRUE(from_corrected.Observe(corrected));
  const IntrinsicsEstimate one = from_raw.Estimate();
  const IntrinsicsEstimate other = from_corrected.Estimate();
  const Vector sigmas = one.covariance.diagonal().cwiseSqrt();
  // The search ends within a part of a standard deviation of the minimum, from either side.
  EXPECT_LT(((one.change - other.change).array() / sigmas.array()).abs().maxCoeff(), 0.002);
}

TEST(CalibrationCheck, ANumberThatIsNoneTellsNothing) {
  Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 14);
  for (const KeyframeObservation& seen : map.keyframes.back().observations)
    map.landmarks[seen.landmark].position.x() = std::nan("");
  CalibrationCheck check({}, map.camera.pinhole);
  EXPECT_FALSE(check.Observe(map));
  EXPECT_EQ(check.windows(), 0);
}

TEST(CalibrationCheck, ThePriorHasItsMeanAtTheExpectedChange) {
  const Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 1);
  const Vector expected = Change(0.05, 4, -3, 0);
  CalibrationCheckOptions options;
  CalibrationCheck unread(options, map.camera.pinhole, expected);
  EXPECT_FALSE(unread.Observe(MapUpTo(1, map)));
  EXPECT_EQ(unread.Estimate().change, expected);
  EXPECT_NEAR(Of(IntrinsicsParameter::kFocalLength, unread).found, std::exp(0.05) * map.camera.pinhole.fx, 1e-9);
  EXPECT_EQ(unread.observed_radius(), 0);
  // So sure of the focal length that the images do not count.
  options.focal_prior_sigma = 1e-5;
  CalibrationCheck check(options, map.camera.pinhole, expected);
  for (int keyframes = 1; keyframes <= CountKeyframes(map); ++keyframes) check.Observe(MapUpTo(keyframes, map));
  ASSERT_GT(check.windows(), 0);
  EXPECT_NEAR(check.Estimate().change[IntrinsicsChange::kLogFocal], 0.05, 1e-3);
  EXPECT_GT(check.observed_radius(), map.camera.pinhole.cx / 2);
  EXPECT_LT(check.observed_radius(), std::hypot(map.camera.pinhole.cx, map.camera.pinhole.cy) + 20);
}

TEST(CalibrationCheck, AnAngleIsMorePixelsAlongTheLongerFocalLength) {
  Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 1);
  map.camera.pinhole.fy = 1.25 * map.camera.pinhole.fx;
  CalibrationCheck unread({}, map.camera.pinhole);
  EXPECT_FALSE(unread.Observe(MapUpTo(1, map)));
  EXPECT_NEAR(Of(IntrinsicsParameter::kCentreY, unread).sigma, 1.25 * Of(IntrinsicsParameter::kCentreX, unread).sigma,
              1e-9);
}

TEST(CalibrationCheck, CanBeSwitchedOff) {
  CalibrationCheckOptions options;
  options.enabled = false;
  EXPECT_EQ(CheckAlong(WrongMap(kRightAndLeft, Change(0.14, 0, 0, 0), 0.3, 15), options).windows(), 0);
}

TEST(CalibrationCheck, OptionsNameTheFieldThatMakesNoSense) {
  using Options = CalibrationCheckOptions;
  EXPECT_EQ(RefusedField<Options>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.window = 2; }), "window");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_turn_deg = 0; }), "min_turn_deg");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.focal_prior_sigma = std::nan(""); }), "focal_prior_sigma");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.significance = -1; }), "significance");
}

}  // namespace
}  // namespace turnscale
