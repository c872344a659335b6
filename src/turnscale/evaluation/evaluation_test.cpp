// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/evaluation.h"

#include <array>
#include <random>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/evaluation/test_drive.h"

namespace turnscale {
namespace {

const RigidTransform kElsewhere{RotationFromVector({0.3, -2.0, 0.5}), {10, -20, 30}};

TEST(PositionErrors, FirstPoseIsLaidOnTheTruthAndNothingElse) {
  const Trajectory truth = WindingDrive(200);
  Trajectory estimate = truth;
  estimate[50].world_from_camera.translation.y() += 3;
  const PositionErrors same_world = MeasurePositionsFromFirstPose(AssociateByTime(estimate, truth));
  EXPECT_NEAR(same_world.distance.rms, 3 / std::sqrt(200.0), 1e-12);
  EXPECT_NEAR(same_world.distance.max, 3, 1e-12);
  EXPECT_NEAR(same_world.distance.median, 0, 1e-12);
  const PosePairs moved = AssociateByTime(Moved(estimate, kElsewhere), truth);
  EXPECT_NEAR(MeasurePositionsFromFirstPose(moved).distance.rms, same_world.distance.rms, 1e-9);
}

TEST(PositionErrors, FirstPoseAlignmentLeavesTheScale) {
  const Trajectory truth = WindingDrive(30);
  const PosePairs pairs = AssociateByTime(Scaled(truth, 1.1), truth);
  const double last_distance = truth.back().world_from_camera.translation.norm();
  EXPECT_NEAR(MeasurePositionsFromFirstPose(pairs).distance.max, 0.1 * last_distance, 1e-9);
}

TEST(PositionErrors, SimilarityTakesAwayScaleAndWorldAndRigidOnlyTheWorld) {
  const Trajectory truth = WindingDrive(200);
  const PosePairs pairs = AssociateByTime(Moved(Scaled(truth, 0.05), kElsewhere), truth);
  const PositionErrors similarity = MeasureAlignedPositions(pairs, AlignmentModel::kSimilarity);
  EXPECT_NEAR(similarity.truth_from_estimate.scale, 20, 1e-9);
  EXPECT_LT(similarity.distance.max, 1e-9);
  EXPECT_GT(MeasureAlignedPositions(pairs, AlignmentModel::kRigid).distance.rms, 10);
  const PosePairs metric = AssociateByTime(Moved(truth, kElsewhere), truth);
  EXPECT_LT(MeasureAlignedPositions(metric, AlignmentModel::kRigid).distance.max, 1e-9);
}

TEST(PositionErrors, OnePoseHasNoAlignment) {
  const Trajectory one = WindingDrive(1);
  const PosePairs pairs = AssociateByTime(one, one);
  EXPECT_EQ(MeasurePositionsFromFirstPose(pairs).distance.rms, 0);
  EXPECT_THROW(MeasureAlignedPositions(pairs, AlignmentModel::kRigid), InputError);
  EXPECT_THROW(MeasurePositionsFromFirstPose({}), InputError);
}

// The devkit's evaluation written out with 4x4 matrices and arc cosines, as the original has it.
std::array<double, 2> Devkit(const PosePairs& pairs) {
  const auto matrix = [](const RigidTransform& pose) {
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix();
    m.topRightCorner<3, 1>() = pose.translation;
    return m;
  };
  std::vector<Eigen::Matrix4d> truth;
  std::vector<Eigen::Matrix4d> result;
  std::vector<double> dist;
  for (const PosePair& pair : pairs) {
    truth.push_back(matrix(pair.truth));
    result.push_back(matrix(pair.estimate));
    const size_t n = truth.size();
    dist.push_back(n == 1 ? 0 : dist.back() + (truth[n - 1] - truth[n - 2]).topRightCorner<3, 1>().norm());
  }
  double t_sum = 0;
  double r_sum = 0;
  int count = 0;
  for (size_t first = 0; first < truth.size(); first += 10) {
    for (int hundreds = 1; hundreds <= 8; ++hundreds) {
      const double length = 100.0 * hundreds;
      size_t last = first;
      while (last < dist.size() && dist[last] <= dist[first] + length) ++last;
      if (last == dist.size()) continue;
      const Eigen::Matrix4d delta_truth = truth[first].inverse() * truth[last];
      const Eigen::Matrix4d delta_result = result[first].inverse() * result[last];
      const Eigen::Matrix4d error = delta_result.inverse() * delta_truth;
      const double cosine = 0.5 * (error.topLeftCorner<3, 3>().trace() - 1);
      r_sum += std::acos(std::max(-1.0, std::min(1.0, cosine))) / length;
      t_sum += error.topRightCorner<3, 1>().norm() / length;
      ++count;
    }
  }
  return {t_sum / count, r_sum / count};
}

Trajectory Drifting(int poses, double step) {
  const Trajectory truth = WindingDrive(poses, step);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.002);
  Trajectory drifting = truth;
  for (size_t i = 1; i < truth.size(); ++i) {
    RigidTransform motion = truth[i - 1].world_from_camera.inverse() * truth[i].world_from_camera;
    const double x = noise(random);
    const double y = noise(random);
    motion.rotation = motion.rotation * RotationFromVector({x, y, noise(random)});
    motion.translation *= 1.02 + noise(random);
    drifting[i].world_from_camera = drifting[i - 1].world_from_camera * motion;
  }
  return drifting;
}

std::vector<double> Lengths(const SegmentErrors& errors) {
  std::vector<double> lengths;
  for (const SegmentLengthError& error : errors.by_length) lengths.push_back(error.length);
  return lengths;
}

TEST(Segments, AgreeWithTheDevkit) {
  const PosePairs pairs = AssociateByTime(Drifting(1100, 1.03), WindingDrive(1100, 1.03));
  const auto [translation, rotation] = Devkit(pairs);
  const SegmentErrors errors = MeasureSegments(pairs);
  EXPECT_GT(translation, 0.01);
  EXPECT_NEAR(errors.translation, translation, 1e-10);
  EXPECT_NEAR(errors.rotation, rotation, 1e-10);
  EXPECT_EQ(Lengths(errors), (std::vector<double>{100, 200, 300, 400, 500, 600, 700, 800}));
}

TEST(Segments, TenPerCentOfScaleOnAStraightRoadIsTenPerCent) {
  Trajectory truth;
  for (int i = 0; i <= 400; ++i) truth.push_back({0.1 * i, {Eigen::Quaterniond::Identity(), {0, 0, 1.0 * i}}});
  // The segment ends at the first pose beyond its length, hence 101/100 and the like.
  const PosePairs pairs = AssociateByTime(Scaled(truth, 1.1), truth);
  const SegmentErrors errors = MeasureSegments(pairs);
  EXPECT_NEAR(errors.by_length[0].translation, 0.1 * 1.01, 1e-9);
  EXPECT_NEAR(errors.by_length[2].translation, 0.1 * 301 / 300, 1e-9);
  EXPECT_NEAR(errors.rotation, 0, 1e-12);
  EXPECT_NEAR(MeasureSegments(pairs, 1 / 1.1).translation, 0, 1e-12) << "the scale undoes it";
}

TEST(Segments, AConstantYawDriftIsItsRate) {
  const Trajectory truth = WindingDrive(400);
  Trajectory estimate = truth;
  for (size_t i = 0; i < truth.size(); ++i) {
    const RigidTransform drift{RotationFromVector({0, 1e-4 * static_cast<double>(i), 0}), Eigen::Vector3d::Zero()};
    estimate[i].world_from_camera = truth[i].world_from_camera * drift;
  }
  const SegmentErrors errors = MeasureSegments(AssociateByTime(estimate, truth));
  EXPECT_NEAR(errors.by_length.back().rotation, 1e-4, 3e-6);
}

TEST(Segments, DoNotDependOnTheWorldFrames) {
  const Trajectory truth = WindingDrive(300, 1.03);
  const Trajectory estimate = Drifting(300, 1.03);
  const RigidTransform elsewhere{RotationFromVector({1, 2, 0.5}), {7, 8, 9}};
  const double translation = MeasureSegments(AssociateByTime(estimate, truth)).translation;
  EXPECT_NEAR(MeasureSegments(AssociateByTime(Moved(estimate, elsewhere), truth)).translation, translation, 1e-10);
  EXPECT_NEAR(MeasureSegments(AssociateByTime(estimate, Moved(truth, elsewhere))).translation, translation, 1e-10);
}

TEST(Segments, LengthsFitTheDrive) {
  const auto lengths = [](int poses, double step) {
    const Trajectory drive = WindingDrive(poses, step);
    return Lengths(MeasureSegments(AssociateByTime(drive, drive)));
  };
  EXPECT_EQ(lengths(356, 1.0), (std::vector<double>{100, 200, 300}));
  EXPECT_EQ(lengths(92, 1.0), (std::vector<double>{10, 20, 30, 40, 50, 60, 70, 80}));
  EXPECT_EQ(lengths(29, 1.0), (std::vector<double>{10, 20}));
  EXPECT_EQ(lengths(45, 0.1), (std::vector<double>{1, 2, 3, 4}));
}

TEST(Segments, ADriveThatGoesNowhereIsNoYardstick) {
  const Trajectory one = WindingDrive(1);
  EXPECT_THROW(MeasureSegments(AssociateByTime(one, one)), InputError);
  const Trajectory still = WindingDrive(50, 0.0);
  EXPECT_THROW(MeasureSegments(AssociateByTime(still, still)), InputError);
  const Trajectory drive = WindingDrive(50);
  EXPECT_THROW(MeasureSegments(AssociateByTime(drive, drive), 1, {.lengths = {100}}), InputError);
}

TEST(Steps, AlongThePathHaveTheAskedLengthAndKnowTurns) {
  const Trajectory drive = WindingDrive(211, 0.4);
  const PosePairs pairs = AssociateByTime(drive, drive);
  const std::vector<Step> steps = StepsAlongPath(pairs);
  ASSERT_EQ(steps.size(), 70U) << "three poses of 0.4 m each";
  int turning = 0;
  for (const Step& step : steps) {
    EXPECT_EQ(step.last - step.first, 3);
    const Eigen::Quaterniond turn = pairs[step.first].truth.rotation.conjugate() * pairs[step.last].truth.rotation;
    EXPECT_EQ(step.turning, std::abs(TwistAboutY(turn)) > 2 / kDegreesPerRadian);
    turning += step.turning ? 1 : 0;
  }
  EXPECT_GT(turning, 10);
  EXPECT_LT(turning, 68);
}

TEST(Steps, BetweenKeyframesFollowTheTable) {
  const Trajectory drive = WindingDrive(20);
  Trajectory numbered = drive;
  for (size_t i = 0; i < drive.size(); ++i) numbered[i].time = static_cast<double>(i);
  const std::vector<KeyframeRow> keyframes = {{0, 0.0, false}, {4, 0.4, true}, {6, 0.60001, false}, {90, 9.0, true}};
  for (const KeyframeKey key : {KeyframeKey::kTime, KeyframeKey::kFrame}) {
    const Trajectory& poses = key == KeyframeKey::kTime ? drive : numbered;
    const std::vector<Step> steps = StepsBetweenKeyframes(AssociateByTime(poses, poses), keyframes, key);
    ASSERT_EQ(steps.size(), 2U);
    EXPECT_EQ(steps[0].first, 0);
    EXPECT_EQ(steps[0].last, 4);
    EXPECT_TRUE(steps[0].turning);
    EXPECT_EQ(steps[1].last, 6);
    EXPECT_FALSE(steps[1].turning);
  }
  const PosePairs pairs = AssociateByTime(drive, drive);
  EXPECT_TRUE(StepsBetweenKeyframes(pairs, {{90, 9.0, true}, {91, 9.1, true}}, KeyframeKey::kTime).empty());
}

TEST(StepErrors, ScaleErrorRatioIsTheScalesError) {
  const Trajectory truth = WindingDrive(300);
  const PosePairs pairs = AssociateByTime(Scaled(truth, 0.93), truth);
  const std::vector<Step> steps = StepsAlongPath(pairs);
  const StepErrors errors = MeasureSteps(pairs, steps, false);
  EXPECT_EQ(errors.scale.count, static_cast<int>(steps.size()));
  EXPECT_NEAR(errors.scale.rms, 0.07, 1e-9);
  EXPECT_NEAR(errors.scale.median, 0.07, 1e-9);
  EXPECT_NEAR(errors.psi.rms, 0, 1e-9);
  EXPECT_NEAR(MeasureSteps(pairs, steps, false, 1 / 0.93).scale.rms, 0, 1e-9);
}

TEST(StepErrors, TurningStepsAreCountedApart) {
  const Trajectory truth = WindingDrive(300);
  PosePairs pairs = AssociateByTime(truth, truth);
  const std::vector<Step> steps = StepsAlongPath(pairs);
  // Every turning step is estimated 20 % too long, every other one exactly.
  for (const Step& step : steps) {
    RigidTransform motion = pairs[step.first].truth.inverse() * pairs[step.last].truth;
    if (step.turning) motion.translation *= 1.2;
    pairs[step.last].estimate = pairs[step.first].estimate * motion;
  }
  const StepErrors turning = MeasureSteps(pairs, steps, true);
  const StepErrors all = MeasureSteps(pairs, steps, false);
  EXPECT_NEAR(turning.scale.rms, 0.2, 1e-9);
  EXPECT_NEAR(all.scale.rms, 0.2 * std::sqrt(1.0 * turning.scale.count / all.scale.count), 1e-9);
  EXPECT_NEAR(all.scale.max, 0.2, 1e-9);
}

TEST(StepErrors, PsiIsTheVehiclesTurningAngle) {
  const Trajectory truth = WindingDrive(100, 1.01);
  const Eigen::Quaterniond vehicle_from_camera = RotationFromYawPitchRoll({0.2, -0.1, 0.05});
  const auto mounted = [&](double extra_psi) {
    Trajectory drive = truth;
    for (size_t i = 0; i < drive.size(); ++i) {
      RigidTransform& pose = drive[i].world_from_camera;
      pose.rotation =
          pose.rotation * RotationFromVector({0, extra_psi * static_cast<double>(i), 0}) * vehicle_from_camera;
    }
    return drive;
  };
  const PosePairs pairs = AssociateByTime(mounted(0.001), mounted(0));
  const std::vector<Step> steps = StepsAlongPath(pairs);
  StepErrorOptions options;
  options.vehicle_from_camera = vehicle_from_camera;
  EXPECT_NEAR(MeasureSteps(pairs, steps, false, 1, options).psi.rms, 0.001, 2e-6);
}

TEST(StepErrors, StandstillDoesNotExplode) {
  Trajectory truth = WindingDrive(50);
  Trajectory estimate = truth;
  for (int i = 0; i < 20; ++i) {
    truth.push_back(truth.back());
    truth.back().time += 0.1;
    truth.back().world_from_camera.translation.x() += 1e-4;
    estimate.push_back(estimate.back());
    estimate.back().time += 0.1;
    estimate.back().world_from_camera.translation.x() += 0.05;
  }
  const PosePairs pairs = AssociateByTime(estimate, truth);
  std::vector<Step> every_pose;
  for (int i = 1; i < static_cast<int>(pairs.size()); ++i) every_pose.push_back({i - 1, i, true});
  const StepErrors errors = MeasureSteps(pairs, every_pose, false);
  EXPECT_EQ(errors.scale.count, 49);
  EXPECT_NEAR(errors.scale.max, 0, 1e-9);
}

TEST(StepErrors, NoTurningStepGivesNoNumber) {
  const Trajectory drive = WindingDrive(10);
  const PosePairs pairs = AssociateByTime(drive, drive);
  const StepErrors errors = MeasureSteps(pairs, {{0, 9, false}}, true);
  EXPECT_EQ(errors.scale.count, 0);
  EXPECT_TRUE(std::isnan(errors.scale.rms));
}

TEST(Evaluate, AnUpToScaleEstimateIsPerfectOnceRescaled) {
  const Trajectory truth = WindingDrive(300);
  const PosePairs pairs = AssociateByTime(Scaled(truth, 0.8), truth);
  const Evaluation evaluation = Evaluate(pairs, StepsAlongPath(pairs));
  EXPECT_EQ(evaluation.poses, 300);
  EXPECT_NEAR(evaluation.true_path_length, 299, 1e-9);
  EXPECT_NEAR(evaluation.as_given.path_length_error, -0.2, 1e-9);
  EXPECT_NEAR(evaluation.as_given.all_steps.scale.rms, 0.2, 1e-9);
  ASSERT_TRUE(evaluation.rescaled);
  EXPECT_NEAR(evaluation.rescaled->scale, 1.25, 1e-9);
  EXPECT_NEAR(evaluation.rescaled->path_length_error, 0, 1e-9);
  EXPECT_NEAR(evaluation.rescaled->segments.translation, 0, 1e-9);
  EXPECT_NEAR(evaluation.similarity->distance.rms, 0, 1e-8);
  EXPECT_GT(evaluation.rigid->distance.rms, 1);
}

TEST(Evaluate, AStraightRoadHasNoAlignmentButALength) {
  Trajectory truth;
  for (int i = 0; i < 150; ++i) truth.push_back({0.1 * i, {Eigen::Quaterniond::Identity(), {0, 0, 1.0 * i}}});
  const PosePairs pairs = AssociateByTime(Scaled(truth, 1.05), truth);
  const Evaluation evaluation = Evaluate(pairs, StepsAlongPath(pairs));
  EXPECT_NEAR(evaluation.as_given.path_length_error, 0.05, 1e-9);
  EXPECT_FALSE(evaluation.similarity);
  EXPECT_FALSE(evaluation.rescaled);
  EXPECT_EQ(evaluation.alignment_problem, "cannot align: the first positions lie on one line or point");
}

TEST(Evaluate, AnEstimateThatNeverMovesIsScored) {
  const Trajectory truth = WindingDrive(150);
  const PosePairs pairs = AssociateByTime(Scaled(truth, 0.0), truth);
  const Evaluation evaluation = Evaluate(pairs, StepsAlongPath(pairs));
  EXPECT_NEAR(evaluation.as_given.path_length_error, -1, 1e-12);
  EXPECT_FALSE(evaluation.alignment_problem.empty());
}

TEST(Evaluate, OnePoseIsTooLittle) {
  const Trajectory one = WindingDrive(1);
  const PosePairs pairs = AssociateByTime(one, one);
  EXPECT_THROW(Evaluate(pairs, {}), InputError);
}

}  // namespace
}  // namespace turnscale
