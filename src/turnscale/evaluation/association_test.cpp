// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/association.h"

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/evaluation/test_drive.h"

namespace turnscale {
namespace {

Trajectory At(const std::vector<double>& times) {
  Trajectory trajectory;
  for (const double time : times) trajectory.push_back({time, {}});
  return trajectory;
}

std::vector<std::pair<int, int>> Indices(const PosePairs& pairs) {
  std::vector<std::pair<int, int>> indices;
  for (const PosePair& pair : pairs) indices.emplace_back(pair.estimate_index, pair.truth_index);
  return indices;
}

using Expected = std::vector<std::pair<int, int>>;

TEST(AssociateByTime, TakesTheNearestWithinTheTolerance) {
  const PosePairs pairs = AssociateByTime(At({0.011, 0.1, 0.25, 0.305}), At({0.0, 0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(Indices(pairs), (Expected{{0, 0}, {1, 1}, {3, 3}})) << "0.25 s is in the middle of two and left out";
  EXPECT_EQ(pairs[2].time, 0.305);
}

TEST(AssociateByTime, DefaultToleranceIsHalfTheIntervalOfADenseTruth) {
  EXPECT_EQ(Indices(AssociateByTime(At({0.0, 0.016}), At({0.0, 0.01}))), (Expected{{0, 0}}));
  EXPECT_EQ(Indices(AssociateByTime(At({0.0, 0.014}), At({0.0, 0.01}))), (Expected{{0, 0}, {1, 1}}));
  EXPECT_EQ(Indices(AssociateByTime(At({0.0, 0.016}), At({0.0, 0.01}), {0.006})), (Expected{{0, 0}, {1, 1}}));
}

TEST(PosesInCommonTime, AreThoseBetweenTheLaterStartAndTheEarlierEnd) {
  const CommonPoses common = PosesInCommonTime(At({0.0, 1.0, 2.0, 3.0}), At({0.5, 1.0, 1.5, 2.0}));
  EXPECT_EQ(common.estimated, 2);
  EXPECT_EQ(common.in_truth, 4);
  EXPECT_EQ(PosesInCommonTime(At({0.0}), At({1.0})).estimated, 0);
  EXPECT_EQ(PosesInCommonTime({}, At({1.0})).in_truth, 0);
}

TEST(AssociateByTime, UsesATruePoseOnceAndForTheNearest) {
  EXPECT_EQ(Indices(AssociateByTime(At({0.095, 0.101, 0.108}), At({0.0, 0.1, 0.2}))), (Expected{{1, 1}}));
}

TEST(AssociateByTime, RefusesWhatCannotBePaired) {
  EXPECT_THROW(AssociateByTime({}, At({0})), InputError);
  EXPECT_THROW(AssociateByTime(At({0}), {}), InputError);
  EXPECT_THROW(AssociateByTime(At({10, 11}), At({0, 1})), InputError);
  EXPECT_THROW(AssociateByTime(At({0, 1, 0.5}), At({0, 1, 2})), InputError);
  EXPECT_THROW(AssociateByTime(At({0, 1}), At({0, 0})), InputError);
}

TEST(AssociateByFrame, PairsOneByOneOrNotAtAll) {
  EXPECT_EQ(Indices(AssociateByFrame(At({0, 0}), At({5, 6}))), (Expected{{0, 0}, {1, 1}}));
  EXPECT_THROW(AssociateByFrame(At({0, 1}), At({0, 1, 2})), InputError);
  EXPECT_THROW(AssociateByFrame({}, {}), InputError);
}

TEST(PathLength, SumsBothSides) {
  const Trajectory truth = WindingDrive(51);
  const PosePairs pairs = AssociateByTime(Scaled(truth, 0.5), truth);
  EXPECT_NEAR(TruePathLength(pairs), 50, 1e-9);
  EXPECT_NEAR(EstimatedPathLength(pairs), 25, 1e-9);
}

}  // namespace
}  // namespace turnscale
