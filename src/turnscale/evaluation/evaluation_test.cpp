// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/evaluation.h"

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/evaluation/test_drive.h"

namespace turnscale {
namespace {

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
