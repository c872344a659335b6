// SPDX-License-Identifier: MIT
#include "turnscale/mapping/absolute_scale_recovery.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/kinematics/pooled_line.h"
#include "turnscale/mapping/map_scaling.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

const LeverArm kLeverArm{1.2, 0.004};
const Eigen::Quaterniond kLevel = Eigen::Quaterniond::Identity();

/// 20 m straight, a right corner (steps 21..40), 100 m straight, a left corner (steps 141..160), 1 m straight.
CarDrive TwoCorners() {
  return MakeCarDrive({{20, 1.0, 0}, {20, 0.6, M_PI / 40}, {100, 1.0, 0}, {20, 0.6, -M_PI / 40}, {1, 1.0, 0}}, 0.1,
                      kLeverArm, kLevel);
}

/// The odometry's unit: `start` of them to the metre, growing by 30 % over the long straight.
std::vector<double> Drift(double start) {
  std::vector<double> factors(162, start);
  for (std::size_t j = 41; j < factors.size(); ++j) {
    const double share = std::min(1.0, (static_cast<double>(j) - 40) / 100);
    // Most of it in the last third, so that an even passage from turn to turn is off.
    factors[j] = start * std::pow(1.3, share * share * share);
  }
  return factors;
}

const TurnScale kFirstTurn{21, 40, 1, {}};
const TurnScale kSecondTurn{141, 160, 1, {}};

TurnScale WithFactor(TurnScale turn, double factor) {
  turn.factor = factor;
  return turn;
}

double StepLength(const std::vector<Eigen::Vector3d>& centres, int step) {
  return (centres[step] - centres[step - 1]).norm();
}

/// Largest relative error of the lengths of steps first..last, averaged over five steps to see scale, not jitter.
double ScaleError(const Map& map, const Map& truth, int first, int last) {
  const auto centres = KeyframeCentres(map);
  const auto true_centres = KeyframeCentres(truth);
  double worst = 0;
  for (int j = first; j + 4 <= last; ++j) {
    double length = 0;
    double true_length = 0;
    for (int i = j; i < j + 5; ++i) {
      length += StepLength(centres, i);
      true_length += StepLength(true_centres, i);
    }
    worst = std::max(worst, std::abs(length / true_length - 1));
  }
  return worst;
}

std::vector<VehicleStep> StepsOfTurn(const Map& map, const TurnScale& turn) {
  std::vector<VehicleStep> steps;
  for (int j = turn.first_step; j <= turn.last_step; ++j) {
    const RigidTransform previous_from_current =
        map.keyframes[j - 1].camera_from_world * map.keyframes[j].camera_from_world.inverse();
    steps.push_back(
        {TurningMotionOf(previous_from_current, kLevel), map.keyframes[j].time - map.keyframes[j - 1].time});
  }
  return steps;
}

class AbsoluteScaleRecovery : public testing::Test {
 protected:
  AbsoluteScaleRecovery() : truth_(MakeMap(TwoCorners(), {.points_per_step = 2})), map_(truth_) {
    ScaleMap(Drift(0.2), map_);
  }

  Map truth_;
  Map map_;
};

TEST_F(AbsoluteScaleRecovery, BringsTheStreetBetweenTwoTurnsToMetres) {
  std::vector<TurnScale> turns = {kFirstTurn, kSecondTurn};
  for (TurnScale& turn : turns) {
    turn.factor = MetresPerUnit(PoolTurn(StepsOfTurn(map_, turn), {}).line.value(), kLeverArm);
  }
  EXPECT_NEAR(turns[0].factor, 5.0, 1e-9);
  const auto before = KeyframeCentres(map_);
  const ScaleRecoveryResult result = RecoverAbsoluteScale({}, turns, map_);
  ASSERT_EQ(result.ranges.size(), 1u);
  EXPECT_TRUE(result.ranges[0].adjusted) << result.ranges[0].reason;
  EXPECT_TRUE(result.ranges[0].summary.converged);
  EXPECT_LT(ScaleError(map_, truth_, 1, 160), 0.006);
  EXPECT_LT(ScaleError(map_, truth_, 21, 40), 1e-6);
  EXPECT_LT(ScaleError(map_, truth_, 141, 160), 1e-6);

  Map guess = truth_;
  ScaleMap(Drift(0.2), guess);
  SetKeyframeCentres(ScaleSteps(before, StepFactors(before, turns)), guess);
  EXPECT_GT(ScaleError(guess, truth_, 41, 140), 0.08) << "the first guess alone would not do";

  double points = 0;
  for (std::size_t i = 0; i < map_.landmarks.size(); ++i) {
    if ((map_.landmarks[i].position - truth_.landmarks[i].position).norm() < 1.0) ++points;
  }
  EXPECT_GT(points, 0.9 * static_cast<double>(map_.landmarks.size()));
}

TEST_F(AbsoluteScaleRecovery, TurnsKeepTheirShape) {
  const auto before = KeyframeCentres(map_);
  RecoverAbsoluteScale({}, {WithFactor(kFirstTurn, 5.0)}, map_);
  const auto after = KeyframeCentres(map_);
  for (int j = 21; j <= 40; ++j) EXPECT_NEAR(StepLength(after, j) / StepLength(before, j), 5.0, 5e-9);
}

TEST_F(AbsoluteScaleRecovery, PerFrameDistancesAreHeldAsTheyAre) {
  TurnScale turn = WithFactor(kFirstTurn, 5.0);
  for (int j = 21; j <= 40; ++j) turn.distances.push_back(j == 30 ? -1 : 0.6 + 0.01 * (j % 3));
  const ScaleRecoveryResult result = RecoverAbsoluteScale({}, {turn}, map_);
  EXPECT_TRUE(result.ranges[0].adjusted) << result.ranges[0].reason;
  const auto after = KeyframeCentres(map_);
  for (int j = 21; j <= 40; ++j) {
    if (j == 30) continue;
    EXPECT_NEAR(StepLength(after, j), turn.distances[j - 21], 1e-8);
  }
  EXPECT_NEAR(StepLength(after, 30), 0.6, 0.005) << "a step that told nothing goes with the others";
}

TEST_F(AbsoluteScaleRecovery, ASureTurnThatIsWeighedIsAsGoodAsHeld) {
  TurnScale turn = WithFactor(kFirstTurn, 5.0);
  turn.sigma = 1e-7;
  const auto before = KeyframeCentres(map_);
  const ScaleRecoveryResult result = RecoverAbsoluteScale({}, {turn}, map_);
  EXPECT_TRUE(result.ranges[0].adjusted) << result.ranges[0].reason;
  const auto after = KeyframeCentres(map_);
  for (int j = 21; j <= 40; ++j) EXPECT_NEAR(StepLength(after, j) / StepLength(before, j), 5.0, 1e-4);
}

// The second turn has its scale wrong by a tenth; the images carry the first one's to it.
TEST_F(AbsoluteScaleRecovery, AnUnsureTurnGivesWayToTheImages) {
  TurnScale sure = WithFactor(kFirstTurn, 5.0);
  TurnScale wrong = WithFactor(kSecondTurn, 1.1 * 5.0 / 1.3);
  Map held = map_;
  RecoverAbsoluteScale({}, {sure, wrong}, held);
  EXPECT_GT(ScaleError(held, truth_, 141, 160), 0.09);
  sure.sigma = 0.001;
  wrong.sigma = 0.1;
  const ScaleRecoveryResult result = RecoverAbsoluteScale({.pixel_sigma_inflation = 1}, {sure, wrong}, map_);
  EXPECT_TRUE(result.ranges[0].summary.converged);
  EXPECT_LT(ScaleError(map_, truth_, 21, 40), 0.002);
  EXPECT_LT(ScaleError(map_, truth_, 141, 160), 0.013);
}

TEST_F(AbsoluteScaleRecovery, UnitOfTheStartCancels) {
  std::vector<std::vector<Eigen::Vector3d>> centres;
  for (const double unit : {0.1, 1.0, 10.0}) {
    Map map = truth_;
    ScaleMap(Drift(unit), map);
    RecoverAbsoluteScale({}, {WithFactor(kFirstTurn, 1 / unit), WithFactor(kSecondTurn, 1 / (1.3 * unit))}, map);
    centres.push_back(KeyframeCentres(map));
  }
  for (std::size_t k = 1; k < centres[0].size(); ++k) {
    EXPECT_LT((centres[0][k] - centres[1][k]).norm(), 1e-9 * centres[1][k].norm());
    EXPECT_LT((centres[2][k] - centres[1][k]).norm(), 1e-9 * centres[1][k].norm());
  }
}

TEST_F(AbsoluteScaleRecovery, GapIsScaledNotAdjusted) {
  // Nothing is seen on both sides of keyframe 90, and what leads there is bridged.
  for (Landmark& landmark : map_.landmarks) {
    const bool later = landmark.observations.back().keyframe >= 90;
    std::erase_if(landmark.observations,
                  [&](const LandmarkObservation& seen) { return later == (seen.keyframe < 90); });
    landmark.valid = landmark.observations.size() >= 2;
  }
  map_.keyframes[90].after_gap = true;
  const std::vector<TurnScale> turns = {WithFactor(kFirstTurn, 5.0), WithFactor(kSecondTurn, 5.0 / 1.3)};
  const auto before = KeyframeCentres(map_);
  const double guessed_step = StepFactors(before, turns, {90})[90] * StepLength(before, 90);
  const ScaleRecoveryResult result = RecoverAbsoluteScale({}, turns, map_);
  ASSERT_EQ(result.ranges.size(), 2u);
  EXPECT_EQ(result.ranges[0].range.last, 89);
  EXPECT_EQ(result.ranges[1].range.first, 90);
  for (const RangeRecovery& range : result.ranges) EXPECT_TRUE(range.adjusted) << range.reason;
  EXPECT_LT(ScaleError(map_, truth_, 1, 88), 0.006);
  EXPECT_LT(ScaleError(map_, truth_, 93, 160), 0.007);
  EXPECT_NEAR(StepLength(KeyframeCentres(map_), 90), guessed_step, 1e-9);

  Map one_turn = map_;
  const ScaleRecoveryResult second = RecoverAbsoluteScale({}, {kSecondTurn}, one_turn);
  EXPECT_FALSE(second.ranges[0].adjusted);
  EXPECT_NE(second.ranges[0].reason.find("no turn"), std::string::npos);
  EXPECT_TRUE(second.ranges[1].adjusted);
}

TEST_F(AbsoluteScaleRecovery, GuessStandsWhereTheAdjustmentFails) {
  TurnScale turn = WithFactor(kFirstTurn, 5.0);
  for (int j = 21; j <= 40; ++j) turn.distances.push_back(j % 2 == 0 ? 0.1 : 30);
  const auto before = KeyframeCentres(map_);
  const auto guess = ScaleSteps(before, StepFactors(before, {turn}));
  const ScaleRecoveryResult result = RecoverAbsoluteScale({}, {turn}, map_);
  EXPECT_FALSE(result.ranges[0].adjusted);
  EXPECT_FALSE(result.ranges[0].reason.empty());
  const auto after = KeyframeCentres(map_);
  for (std::size_t k = 0; k < after.size(); ++k) EXPECT_LT((after[k] - guess[k]).norm(), 1e-9);
  EXPECT_NEAR(result.factors.back(), 5.0, 1e-9);
}

TEST_F(AbsoluteScaleRecovery, BlindKeyframeIsNamed) {
  for (Landmark& landmark : map_.landmarks) {
    std::erase_if(landmark.observations, [](const LandmarkObservation& seen) { return seen.keyframe == 50; });
  }
  const ScaleRecoveryResult result = RecoverAbsoluteScale({}, {WithFactor(kFirstTurn, 5.0)}, map_);
  EXPECT_FALSE(result.ranges[0].adjusted);
  EXPECT_NE(result.ranges[0].reason.find("keyframe 50"), std::string::npos);
}

TEST_F(AbsoluteScaleRecovery, BrokenLandmarkDoesNotEndTheDrive) {
  map_.landmarks[5].position.x() = std::nan("");
  const ScaleRecoveryResult result = RecoverAbsoluteScale({}, {WithFactor(kFirstTurn, 5.0)}, map_);
  EXPECT_FALSE(result.ranges[0].adjusted);
  EXPECT_FALSE(result.ranges[0].reason.empty());
  EXPECT_NEAR(result.factors.back(), 5.0, 1e-9);
}

TEST_F(AbsoluteScaleRecovery, LandmarkSeenOnceGoesWithItsKeyframe) {
  Landmark once{map_.landmarks[0].position, true, {{150, {600, 180}}}};
  const Eigen::Vector3d in_camera(1, -1, 10);
  once.position = map_.keyframes[150].camera_from_world.inverse() * (in_camera * 0.2 * 1.3);
  map_.landmarks.push_back(once);
  RecoverAbsoluteScale({}, {WithFactor(kFirstTurn, 5.0), WithFactor(kSecondTurn, 5.0 / 1.3)}, map_);
  EXPECT_LT((map_.keyframes[150].camera_from_world * map_.landmarks.back().position - in_camera).norm(), 1e-6);
}

TEST_F(AbsoluteScaleRecovery, RefusesWhatMakesNoSense) {
  EXPECT_THROW(RecoverAbsoluteScale({}, {}, map_), InternalError);
  EXPECT_THROW(RecoverAbsoluteScale({}, {kSecondTurn, kFirstTurn}, map_), InternalError);
  EXPECT_THROW(RecoverAbsoluteScale({}, {{0, 20, 1, {}}}, map_), InternalError);
  EXPECT_THROW(RecoverAbsoluteScale({}, {{150, 162, 1, {}}}, map_), InternalError);
  EXPECT_THROW(RecoverAbsoluteScale({}, {WithFactor(kFirstTurn, -1)}, map_), InternalError);
  EXPECT_THROW(RecoverAbsoluteScale({}, {{21, 40, 1, {0.6}}}, map_), InternalError);
  EXPECT_THROW(RecoverAbsoluteScale({}, {{21, 40, 1, {}, -0.1}}, map_), InternalError);
  EXPECT_THROW(RecoverAbsoluteScale({.pixel_sigma = 0}, {kFirstTurn}, map_), InputError);
  EXPECT_THROW(RecoverAbsoluteScale({.pixel_sigma_inflation = 0.5}, {kFirstTurn}, map_), InputError);
}

}  // namespace
}  // namespace turnscale
