// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/position_error.h"

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

}  // namespace
}  // namespace turnscale
