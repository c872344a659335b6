// SPDX-License-Identifier: MIT
#include "turnscale/calibration/calibration.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/test_drive.h"

namespace turnscale {
namespace {

const LeverArm kArm{1.2, 0};

Calibration CalibratePath(const Trajectory& path, TravelModel travel = TravelModel::kSteady) {
  CalibrationOptions options;
  options.refinement.travel = travel;
  return Calibrate(StepsAlong(path), options);
}

TEST(Calibrate, FindsTheRotationOfAnExactDriveFromOneTurnOn) {
  for (const int side : {1, -1}) {
    for (const TravelModel travel : {TravelModel::kSteady, TravelModel::kFree}) {
      const Calibration found = CalibratePath(TestPath(TestRoute({side}), kArm, kTilted), travel);
      EXPECT_TRUE(found.observable) << found.problem;
      EXPECT_EQ(found.turns, 1);
      EXPECT_TRUE(found.refinement.converged);
      EXPECT_LT(DegreesBetween(found.vehicle_from_camera, kTilted), 1e-6);
    }
  }
}

TEST(Calibrate, FindsTheLeverArmInTheOdometrysUnit) {
  Trajectory path = TestPath(TestRoute({1, -1}), kArm, kTilted);
  for (StampedPose& pose : path) pose.world_from_camera.translation *= 0.05;
  const Calibration found = CalibratePath(path);
  ASSERT_EQ(found.refinement.lever_arms.size(), 2U);
  for (const double lever_arm : found.refinement.lever_arms) EXPECT_NEAR(lever_arm, 0.05 * 1.2, 1e-6);
}

TEST(Calibrate, ASmallTurnShowsTheRollLessWell) {
  const auto roll_sigma = [](double turn) {
    constexpr int kFrames = 24;
    const Trajectory path =
        TestPath({{60, 0.8, 0}, {kFrames, 0.8, turn / kFrames}, {60, 0.8, 0}}, kArm, kTilted, 0.03 * kDeg);
    return Calibrate(StepsAlong(path)).sigma.roll;
  };
  EXPECT_GT(roll_sigma(35 * kDeg), 1.3 * roll_sigma(90 * kDeg)) << "a change of grade looks like roll";
}

TEST(Calibrate, StatesTheSpreadThatItsErrorsHave) {
  constexpr int kRuns = 60;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  Eigen::Vector3d stated = Eigen::Vector3d::Zero();
  CalibrationOptions options;
  options.refinement.road_bank = 0;
  options.refinement.grade_change = 0;
  options.body_lean = false;
  options.motion_bias = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Trajectory path = TestPath(TestRoute({1, -1, 1}), kArm, kTilted, 0.3 * kDeg, 100 + run);
    const Calibration found = Calibrate(StepsAlong(path), options);
    const Eigen::Vector3d error = VectorFromRotation(found.vehicle_from_camera * kTilted.conjugate());
    squares += error.cwiseAbs2();
    stated += found.covariance.diagonal();
  }
  const Eigen::Vector3d ratio = (stated.array() / squares.array()).sqrt();
  // The spread over 60 runs is itself uncertain by 9 %.
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(ratio[axis], 1, 0.25) << axis;
}

TEST(Calibrate, TurnsWithTheCamera) {
  const Trajectory path = TestPath(TestRoute({1, -1}), kArm, Eigen::Quaterniond::Identity(), 0.3 * kDeg);
  const Calibration upright = CalibratePath(path);
  Trajectory rotated = path;
  for (StampedPose& pose : rotated) pose.world_from_camera.rotation = pose.world_from_camera.rotation * kTilted;
  EXPECT_LT(DegreesBetween(CalibratePath(rotated).vehicle_from_camera, upright.vehicle_from_camera * kTilted), 1e-9);
}

TEST(Calibrate, BackingUpIsTurnedRound) {
  std::vector<CameraStep> steps = StepsAlong(TestPath(TestRoute({1, -1}), kArm, kTilted));
  for (size_t i = 0; i < steps.size() / 3; ++i) steps[i] = Reversed(steps[i]);
  const Calibration found = Calibrate(steps);
  EXPECT_EQ(found.reversed, static_cast<int>(steps.size() / 3));
  EXPECT_LT(DegreesBetween(found.vehicle_from_camera, kTilted), 1e-6);
}

TEST(Calibrate, OutliersHaveLittleSay) {
  Trajectory path = TestPath(TestRoute({1, -1, 1, -1}), kArm, kTilted, 0.05 * kDeg);
  Random random(5);
  for (StampedPose& pose : path) {
    if (random.Chance(0.02)) pose.world_from_camera.translation += Eigen::Vector3d(0.3, -0.2, 0);
  }
  EXPECT_LT(DegreesBetween(CalibratePath(path).vehicle_from_camera, kTilted), 0.04);
}

TEST(Calibrate, SideSlipDoesNotBiasIt) {
  const Calibration found = CalibratePath(TestPath(TestRoute({1, 1, -1}), {1.2, 0.005}, kTilted));
  EXPECT_LT(DegreesBetween(found.vehicle_from_camera, kTilted), 1e-6);
}

TEST(Calibrate, SaysWhatAStraightDriveLacks) {
  const Calibration found = CalibratePath(TestPath({{300, 0.8, 0}}, kArm, kTilted, 0.1 * kDeg));
  EXPECT_FALSE(found.observable);
  EXPECT_EQ(found.problem, "no turn yet: roll and yaw offset not observable");
  EXPECT_LT(found.linear.confidence, CalibrationOptions().min_confidence);
}

TEST(Calibrate, RefusesTooFewSteps) { EXPECT_THROW(Calibrate({CameraStep{}, CameraStep{}}), InputError); }

// Steps along a rendered street, of a camera 5.5 m ahead of the axle and turned by 3 degrees to the right: frames,
// their mean rotation and direction of travel, and its length. A turn of four steps between straights; the camera
// swings out by as much as it goes forward.
struct BusStep {
  int frames;
  Eigen::Vector3d rotation;
  Eigen::Vector3d direction;
  double length;
};
const std::vector<BusStep> kBusSteps = {
    {1, {0.01501, -0.00027, 0.00100}, {-0.05614, -0.19649, 0.97890}, 1.000},
    {1, {0.00452, -0.00006, 0.00046}, {-0.05276, 0.03310, 0.99806}, 2.725},
    {2, {0.00219, -0.00007, 0.00009}, {-0.05251, 0.03833, 0.99788}, 2.734},
    {2, {0.00112, 0.00000, 0.00070}, {-0.05042, 0.04484, 0.99772}, 3.978},
    {2, {-0.00202, -0.00012, -0.00118}, {-0.05107, 0.05371, 0.99725}, 5.242},
    {2, {0.00146, -0.00011, 0.00155}, {-0.04882, 0.04207, 0.99792}, 4.492},
    {2, {-0.00097, -0.00000, -0.00004}, {-0.05206, 0.05547, 0.99710}, 5.125},
    {2, {-0.00285, 0.00025, -0.00131}, {-0.05618, 0.05590, 0.99685}, 6.967},
    {2, {-0.00403, 0.00009, 0.00115}, {-0.05211, 0.05717, 0.99700}, 7.913},
    {2, {-0.00310, -0.00015, -0.00237}, {-0.05165, 0.05343, 0.99724}, 7.290},
    {2, {-0.00872, 0.00009, 0.00057}, {-0.04972, 0.05631, 0.99717}, 9.219},
    {3, {-0.00962, 0.00024, -0.00015}, {-0.05163, 0.04616, 0.99760}, 7.841},
    {2, {-0.00041, -0.00016, -0.00087}, {-0.05214, 0.01497, 0.99853}, 9.613},
    {3, {-0.00142, 0.00013, 0.00088}, {-0.05243, 0.02247, 0.99837}, 5.413},
    {3, {0.00051, 0.00003, -0.00038}, {-0.05366, 0.01473, 0.99845}, 5.258},
    {7, {-0.00120, 0.05728, -0.00596}, {0.38456, 0.05361, 0.92154}, 2.117},
    {8, {0.00017, 0.06022, -0.00076}, {0.56924, 0.03329, 0.82150}, 1.568},
    {8, {0.00169, 0.05974, -0.00260}, {0.56011, 0.01877, 0.82821}, 1.557},
    {5, {0.00213, 0.04135, 0.00258}, {0.22189, 0.03418, 0.97447}, 2.490},
    {3, {0.00134, -0.00128, 0.00107}, {-0.05505, 0.04412, 0.99751}, 5.774},
    {3, {0.00141, 0.00012, -0.00055}, {-0.05280, 0.04181, 0.99773}, 4.593},
    {3, {0.00130, 0.00005, -0.00016}, {-0.05227, 0.04682, 0.99753}, 5.185},
    {3, {-0.00131, -0.00005, -0.00050}, {-0.05146, 0.05116, 0.99736}, 5.770},
    {3, {-0.00048, 0.00001, 0.00134}, {-0.05133, 0.04127, 0.99783}, 5.049},
};

TEST(RefineRotation, HoldsWhereTheCameraSwingsOutWide) {
  std::vector<StepMeasurement> steps;
  for (const BusStep& step : kBusSteps)
    steps.push_back({RotationFromVector(step.rotation), step.direction.normalized(), step.length, step.frames});
  for (const double yaw : {0.0, 3.0, 8.0}) {
    const Refinement refined = RefineRotation(steps, RotationFromYawPitchRoll({yaw * kDeg, 0, 0}));
    EXPECT_TRUE(refined.converged);
    EXPECT_NEAR(YawPitchRollFromRotation(refined.vehicle_from_camera).yaw, 3 * kDeg, 0.3 * kDeg) << yaw;
    EXPECT_NEAR(refined.lever_arms.at(0), 15.1, 0.5) << yaw << ": 5.5 m";
  }
}

TEST(CalibrationOptions, RefuseSenselessValues) {
  using Options = CalibrationOptions;
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.min_turn = -1; }), "min_turn");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.min_confidence = 0; }), "min_confidence");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.motion_bias = -1; }), "motion_bias");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.counted_turn = 0; }), "counted_turn");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.refinement.huber_share = 0; }), "huber_share");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.refinement.grade_change = -1; }), "grade_change");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.refinement.road_bank = -1; }), "road_bank");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.refinement.max_iterations = 0; }), "max_iterations");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.refinement.tolerance = 0; }), "tolerance");
}

}  // namespace
}  // namespace turnscale
