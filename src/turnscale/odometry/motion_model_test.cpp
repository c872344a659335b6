// SPDX-License-Identifier: MIT
#include "turnscale/odometry/motion_model.h"

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

const RigidTransform kStep{RotationFromVector({0.01, -0.06, 0.002}), {0.1, -0.02, -0.9}};
const RigidTransform kYawStep{RotationFromVector({0, -0.06, 0}), {0.1, -0.02, -0.9}};
const RigidTransform kStart{RotationFromVector({0.2, 0.4, -0.1}), {3, 1, -7}};

void ExpectNear(const RigidTransform& a, const RigidTransform& b) {
  EXPECT_LT(RotationAngle(a.rotation * b.rotation.conjugate()), 1e-12);
  EXPECT_LT((a.translation - b.translation).norm(), 1e-12);
}

TEST(MotionModel, StandsStillUntilItKnowsTwoPoses) {
  MotionModel motion;
  ExpectNear(motion.Predict(5), RigidTransform{});
  motion.Update(1, kStart);
  ExpectNear(motion.Predict(5), kStart);
  EXPECT_EQ(motion.speed(), 0);
}

TEST(MotionModel, GoesOnAsItMovedLast) {
  MotionModel motion;
  motion.Update(1.0, kStart);
  motion.Update(1.1, kStep * kStart);
  ExpectNear(motion.Predict(1.1), kStep * kStart);
  ExpectNear(motion.Predict(1.2), kStep * kStep * kStart);
  EXPECT_NEAR(motion.speed(), kStep.translation.norm() / 0.1, 1e-9);
  const RigidTransform half = motion.Predict(1.15) * motion.last().inverse();
  EXPECT_NEAR(RotationAngle(half.rotation), 0.5 * RotationAngle(kStep.rotation), 1e-12);
  EXPECT_LT((half.translation - 0.5 * kStep.translation).norm(), 1e-12);
}

TEST(MotionModel, TheLastStepCounts) {
  MotionModel motion;
  motion.Update(0.0, kStart);
  motion.Update(0.1, kStep * kStart);
  motion.Update(0.3, kStep * kStep * kStart);
  const RigidTransform half = motion.Predict(0.4) * motion.last().inverse();
  EXPECT_NEAR(RotationAngle(half.rotation), 0.5 * RotationAngle(kStep.rotation), 1e-12) << "0.1 s of a step of 0.2 s";
  EXPECT_NEAR(motion.speed(), kStep.translation.norm() / 0.2, 1e-9);
}

TEST(MotionModel, TimeThatStandsStillGivesNoVelocity) {
  MotionModel motion;
  motion.Update(1.0, kStart);
  motion.Update(1.0, kStep * kStart);
  EXPECT_EQ(motion.speed(), 0);
  ExpectNear(motion.Predict(2.0), kStep * kStart);
}

TEST(MotionModel, ACorrectionMovesThePoseAndScalesTheSpeed) {
  MotionModel motion;
  motion.Update(1.0, kStart);
  motion.Update(1.1, kStep * kStart);
  const RigidTransform corrected{RotationFromVector({0, 0.1, 0}), {1, 2, 3}};
  const double speed = motion.speed();
  motion.Correct(corrected, 7.0);
  EXPECT_NEAR(motion.speed(), 7 * speed, 1e-9);
  const RigidTransform longer{kStep.rotation, 7 * kStep.translation};
  ExpectNear(motion.Predict(1.2), longer * corrected);
}

TEST(MotionModel, ATurnGoesOnForTwoSecondsAtMost) {
  MotionModel motion;
  motion.Update(1.0, RigidTransform{});
  motion.Update(1.1, {RotationFromVector({0, -0.05, 0}), {0, 0, -1}});
  const auto turned = [&](double after) {
    return RotationAngle(motion.Predict(1.1 + after).rotation * motion.last().rotation.conjugate());
  };
  EXPECT_NEAR(turned(0.3), 0.15, 1e-9) << "as fast as measured";
  EXPECT_NEAR(turned(0.5), 0.25, 1e-9);
  EXPECT_NEAR(turned(1.5), 0.6149, 1e-4) << "0.75 at a steady rate";
  EXPECT_NEAR(turned(100), 1, 1e-6) << "two seconds of half a radian a second";
}

TEST(MotionModel, ALongWayAheadIsBoundedToo) {
  MotionModel motion;
  motion.Update(1.0, RigidTransform{});
  motion.Update(1.1, {Eigen::Quaterniond::Identity(), {0, 0, -1}});
  const auto travelled = [&](double after) {
    return (motion.Predict(1.1 + after).translation - motion.last().translation).norm();
  };
  EXPECT_NEAR(travelled(0.5), 5, 1e-9);
  EXPECT_NEAR(travelled(5), 48.354, 1e-2);
  EXPECT_NEAR(travelled(30), 238.03, 1e-1) << "300 at a steady speed";
  EXPECT_NEAR(travelled(1e9), 605, 1e-3) << "a minute at 10 m/s, and what is steady before";
}

TEST(MotionModel, ATurnBendsTheWayAhead) {
  MotionModel motion;
  motion.Update(1.0, kStart);
  motion.Update(1.1, kYawStep * kStart);
  ExpectNear(motion.Predict(1.5), kYawStep * kYawStep * kYawStep * kYawStep * kYawStep * kStart);
}

TEST(MotionModel, OnlyTheTurnAboutTheVerticalGoesOn) {
  MotionModel motion;
  // A camera that looks down by a fifth of a radian.
  const RigidTransform tilt{RotationFromVector({-0.2, 0, 0}), Eigen::Vector3d::Zero()};
  const Eigen::Vector3d vertical = tilt.rotation * Eigen::Vector3d::UnitY();
  motion.SetVertical(-vertical);
  const Eigen::Vector3d swing = 0.02 * (tilt.rotation * Eigen::Vector3d::UnitX());
  motion.Update(1.0, kStart);
  motion.Update(1.1, {RotationFromVector(-0.05 * vertical + swing) * kStart.rotation, kStart.translation});
  const auto turned = [&](double after) -> Eigen::Vector3d {
    return VectorFromRotation(motion.Predict(1.1 + after).rotation * motion.last().rotation.conjugate());
  };
  EXPECT_LT((turned(0.1) - (-0.05 * vertical + swing)).norm(), 1e-12) << "one image";
  EXPECT_NEAR(turned(0.5).dot(vertical), -0.25, 1e-3);
  EXPECT_NEAR((turned(0.5) - turned(0.5).dot(vertical) * vertical).norm(), 1.5 * 0.02, 2e-3) << "0.15 s of it";
}

TEST(MotionModel, AcrossGapsTheRatesAreMeans) {
  MotionModel motion;
  const double interval = 1.0 / 60;
  // A steady motion with poses that are off to and fro.
  for (int i = 0; i <= 40; ++i) {
    const double off = i % 2 == 0 ? 1 : -1;
    motion.Update(i * interval, {RotationFromVector({0, -0.01 * i + 0.002 * off, 0}), {0.003 * off, 0, 0}});
  }
  const RigidTransform moved = motion.Predict(40 * interval + 0.5) * motion.last().inverse();
  EXPECT_NEAR(VectorFromRotation(moved.rotation).y(), -0.3, 0.006) << "the last image alone says -0.18";
  EXPECT_LT(moved.translation.norm(), 0.02) << "and here 0.18";
}

TEST(MotionModel, AStopLeavesNoMotion) {
  MotionModel motion;
  motion.Update(1.0, kStart);
  motion.Update(1.1, kStep * kStart);
  motion.Stop();
  ExpectNear(motion.Predict(5), motion.last());
  EXPECT_EQ(motion.speed(), 0);
}

TEST(MotionModel, PredictsOtherTurnsAndSpeeds) {
  MotionModel motion;
  ExpectNear(motion.PredictOtherwise(1, 0.2, 0.5), motion.last());
  motion.Update(1.0, kStart);
  motion.Update(1.1, {RotationFromVector({0, -0.02, 0}) * kStart.rotation, kStart.translation});
  ExpectNear(motion.PredictOtherwise(1.5, 0, 1), motion.Predict(1.5));
  const RigidTransform moved = motion.PredictOtherwise(1.5, -0.3, 1) * motion.last().inverse();
  EXPECT_NEAR(VectorFromRotation(moved.rotation).y(), -0.08 - 0.3, 1e-9);
  EXPECT_LT(motion.TurnReach(1.2), motion.TurnReach(1.4));
  motion.Update(1.2, kStep * motion.last());
  const auto travelled = [&](double share) {
    return (motion.PredictOtherwise(1.3, 0, share) * motion.last().inverse()).translation.norm();
  };
  EXPECT_NEAR(travelled(0.5), 0.5 * travelled(1), 1e-9);
}

TEST(MotionModel, PredictsTheMotionAcrossAGap) {
  MotionModel motion;
  ExpectNear(motion.PredictAcross(1, 0.2, std::nullopt), motion.last());
  motion.Update(1.0, RigidTransform{});
  // Ahead at 10 units/s, turning at 0.2 rad/s.
  const RigidTransform step{RotationFromVector({0, -0.02, 0}), {0, 0, -1}};
  motion.Update(1.1, step);
  const auto moved = [&](double time, double rate, std::optional<double> turn) {
    return motion.PredictAcross(time, rate, turn) * motion.last().inverse();
  };
  const auto turn_of = [](const RigidTransform& pose) { return VectorFromRotation(pose.rotation).y(); };
  // Of the way, to the left of where the car faced before the gap.
  const auto direction_of = [](const RigidTransform& pose) {
    const Eigen::Vector3d way = pose.inverse().translation;
    return std::atan2(-way.x(), way.z());
  };
  ExpectNear(moved(1.1, 0.2, std::nullopt), RigidTransform{});
  EXPECT_NEAR(turn_of(moved(1.9, -0.2, std::nullopt)), -0.8 * 0.2, 1e-9) << "the rate stays";
  EXPECT_NEAR(turn_of(moved(1.9, 0, std::nullopt)), -0.4 * 0.2, 1e-9) << "the turn ends half-way";
  EXPECT_NEAR(turn_of(moved(1.9, 0.2, std::nullopt)), 0, 1e-9) << "an S";
  EXPECT_LT(turn_of(moved(6.1, 0, std::nullopt)), -0.5 * 0.2);
  EXPECT_GT(turn_of(moved(6.1, 0, std::nullopt)), -2.0 * 0.2) << "a turn ends";
  for (const double turn : {-0.5, 0.0, 0.4}) EXPECT_NEAR(turn_of(moved(4.1, -0.2, turn)), turn, 1e-9);

  // A turn before the gap bends all of the way, one after it only the last part.
  motion.Restart(1.1, RigidTransform{});
  EXPECT_LT(direction_of(moved(4.1, 0, std::nullopt)), -0.1);
  MotionModel straight;
  straight.Update(1.0, RigidTransform{});
  straight.Update(1.1, {Eigen::Quaterniond::Identity(), {0, 0, -1}});
  const RigidTransform turns_late = straight.PredictAcross(4.1, -0.4, std::nullopt) * straight.last().inverse();
  EXPECT_LT(turn_of(turns_late), -0.4);
  EXPECT_GT(direction_of(turns_late), 0.35 * turn_of(turns_late));
  EXPECT_NEAR(direction_of(straight.PredictAcross(4.1, 0, -0.6) * straight.last().inverse()), -0.3, 0.02) << "evenly";
  const RigidTransform turns_last = straight.PredictAcross(4.1, -0.4, -0.1) * straight.last().inverse();
  EXPECT_NEAR(turn_of(turns_last), -0.1, 1e-9);
  EXPECT_GT(direction_of(turns_last), -0.01) << "in the last 0.25 s";
}

constexpr size_t kTurningRates = 4;

TEST(MotionModel, OffersStandstillAndTheSpeedBeforeItBrokeOff) {
  MotionModel motion;
  EXPECT_TRUE(motion.OtherPredictions(1).empty());
  motion.Update(1.0, kStart);
  motion.Update(1.1, kStep * kStart);
  const RigidTransform stop = motion.last();
  ASSERT_EQ(motion.OtherPredictions(1.2).size(), 1U + kTurningRates);
  ExpectNear(motion.OtherPredictions(1.2)[0], stop);
  motion.Update(1.2, stop);
  // The noise of standing still breaks off all the time.
  for (const double noise : {1e-3, 1e-4, 3e-3, 1e-3, 1e-5})
    motion.Update(motion.last_measured_time() + 0.1, {stop.rotation, stop.translation + Eigen::Vector3d(noise, 0, 0)});
  const RigidTransform last = motion.last();
  const auto others = motion.OtherPredictions(motion.last_measured_time() + 0.1);
  ASSERT_EQ(others.size(), 2U + kTurningRates);
  ExpectNear(others[0], last);
  ExpectNear(others[1], kStep * last);
  // At the old speed again, what broke off is over.
  motion.Update(motion.last_measured_time() + 0.1, kStep * motion.last());
  EXPECT_EQ(motion.OtherPredictions(motion.last_measured_time() + 0.1).size(), 1U + kTurningRates);
}

TEST(MotionModel, AStopAtOnceIsNoneOfACar) {
  // Steps of 0.1 s of these lengths; before step `repeated`, images were repeated for 3 s.
  const auto drive = [](const std::vector<double>& steps, std::size_t repeated) {
    MotionModel motion;
    motion.Update(1.0, kStart);
    for (std::size_t i = 0; i < steps.size(); ++i)
      motion.Update(motion.last_measured_time() + (i == repeated ? 3.1 : 0.1),
                    RigidTransform{Eigen::Quaterniond::Identity(), {0, 0, -steps[i]}} * motion.last(), i == repeated);
    return motion;
  };
  MotionModel stopped = drive({1, 1, 1, 1, 0, 0}, 4);
  ASSERT_TRUE(stopped.StoppedAtOnce());
  EXPECT_NEAR(*stopped.StoppedAtOnce(), 1.4, 1e-9);
  stopped.GoOn();
  EXPECT_NEAR((stopped.Predict(1.5) * stopped.last().inverse()).translation.z(), -1, 1e-9);
  EXPECT_FALSE(drive({1, 1, 1, 1}, 4).StoppedAtOnce());
  EXPECT_FALSE(drive({1, 1, 1, 1, 0, 1}, 4).StoppedAtOnce()) << "goes on";
  EXPECT_FALSE(drive({1, 1, 1, 1, 0, 0}, 9).StoppedAtOnce()) << "no image was repeated";
  EXPECT_FALSE(drive({1, 1, 0.8, 0.6, 0.4, 0.2, 0.05, 0.01, 0}, 8).StoppedAtOnce()) << "brakes";
  EXPECT_FALSE(drive({1, 1, 1, 0.45, 0.4, 0.3, 0.2, 0.1, 0.05, 0}, 9).StoppedAtOnce()) << "brakes hard";
  EXPECT_FALSE(drive({1, 1, 1, 0.45, 0.4, 0.3, 0.2, 0.1, 0.05, 0}, 3).StoppedAtOnce()) << "brakes behind repeats";
}

TEST(MotionModel, OffersOtherTurningRates) {
  MotionModelOptions options;
  options.turn_acceleration = 1.0;
  MotionModel motion(options);
  const RigidTransform step{RotationFromVector({0, -0.06, 0}), {0, 0, -1}};
  motion.Update(1.0, kStart);
  motion.Update(1.3, step * kStart);
  const auto others = motion.OtherPredictions(1.6);
  ASSERT_EQ(others.size(), 1U + kTurningRates);
  std::vector<double> turned;
  for (size_t i = 1; i < others.size(); ++i) {
    const RigidTransform moved = others[i] * motion.last().inverse();
    turned.push_back(VectorFromRotation(moved.rotation).y());
    EXPECT_NEAR(moved.translation.norm(), 1, 1e-9) << "at the same speed";
  }
  // The rate changes by 0.3 rad/s at most in these 0.3 s.
  std::ranges::sort(turned);
  EXPECT_NEAR(turned[0], -0.06 - 0.09, 1e-9);
  EXPECT_NEAR(turned[1], -0.06 - 0.045, 1e-9);
  EXPECT_NEAR(turned[2], -0.06 + 0.045, 1e-9);
  EXPECT_NEAR(turned[3], -0.06 + 0.09, 1e-9);
}

TEST(MotionModel, SpeedsOfThePastGetLessCertain) {
  MotionModel motion;
  EXPECT_TRUE(motion.PastSpeeds().empty());
  motion.Update(1.0, kStart);
  motion.Update(1.1, kStep * kStart);
  const double speed = kStep.translation.norm() / 0.1;
  ASSERT_EQ(motion.PastSpeeds().size(), 1U);
  EXPECT_NEAR(motion.PastSpeeds()[0].speed, speed, 1e-9);
  EXPECT_EQ(motion.PastSpeeds()[0].time, 1.1);
  const PastSpeed past{10, 5};
  EXPECT_NEAR(motion.SpeedSigma(past, 5, 8), 0.05, 1e-12);
  EXPECT_NEAR(motion.SpeedSigma(past, 7, 8), 0.3041, 1e-4) << "5 % and 30 %, which are independent";
  EXPECT_NEAR(motion.SpeedSigma({1, 5}, 7, 12), 2.4005, 1e-4) << "1.2 m/s^2 at 1 m/s";
  // A stop from speed: the speed before it is still there, at its own time.
  const RigidTransform& last = motion.last();
  motion.Update(1.5, {last.rotation, last.translation + Eigen::Vector3d(1e-9, 0, 0)});
  ASSERT_EQ(motion.PastSpeeds().size(), 2U);
  EXPECT_GT(motion.SpeedSigma(motion.PastSpeeds()[0], 1.6, 8), 100) << "standing says nothing of the speed";
  EXPECT_NEAR(motion.PastSpeeds()[1].speed, speed, 1e-9);
  EXPECT_EQ(motion.PastSpeeds()[1].time, 1.1);
  motion.Correct(motion.last(), 3);
  EXPECT_NEAR(motion.PastSpeeds()[1].speed, 3 * speed, 1e-9);
}

TEST(MotionModel, AfterARestartEarlierSpeedsCountNoLonger) {
  MotionModel motion;
  motion.Update(1.0, kStart);
  motion.Update(1.1, kStep * kStart);
  motion.Update(1.2, motion.last());
  motion.Restart(3.0, kStart);
  EXPECT_TRUE(motion.PastSpeeds().empty());
  EXPECT_EQ(motion.last_measured_time(), 3.0);
  ExpectNear(motion.last(), kStart);
  motion.Update(3.1, kStep * kStart);
  EXPECT_NEAR(motion.speed(), kStep.translation.norm() / 0.1, 1e-9);
  ExpectNear(motion.Predict(3.2), kStep * kStep * kStart);
}

TEST(MotionModel, ASlowStartAfterARestartIsNoBreak) {
  MotionModel motion;
  motion.Update(1.0, kStart);
  motion.Update(1.1, kStep * kStart);
  motion.Restart(3.0, kStart);
  motion.Update(3.1, {kStart.rotation, kStart.translation + 0.3 * kStep.translation});
  ASSERT_EQ(motion.PastSpeeds().size(), 1U) << "there is no speed before the restart";
  EXPECT_NEAR(motion.PastSpeeds()[0].speed, 0.3 * kStep.translation.norm() / 0.1, 1e-9);
  EXPECT_TRUE(std::isfinite(motion.SpeedSigma(motion.PastSpeeds()[0], 3.2, 0)));
  EXPECT_EQ(motion.OtherPredictions(3.2).size(), 1U + kTurningRates);
}

TEST(MotionModel, TheSpeedIsAMeanOverShortSteps) {
  MotionModel motion;
  const double lengths[] = {9, 1, 3, 1, 3, 1, 3};
  double z = 0;
  for (int i = 0; i < 7; ++i) {
    z -= lengths[i];
    motion.Update(0.04 * i, {Eigen::Quaterniond::Identity(), {0, 0, z}});
  }
  EXPECT_NEAR(motion.speed(), (3 + 1 + 3 + 1 + 3) / 0.2, 1e-9);
}

TEST(GapTurnSigma, GrowsWithTheSquareOfTheTimeAndInTurnsUpToABound) {
  const auto sigma = [](double seconds, double rate) { return GapTurnSigma({}, seconds, rate, {}); };
  EXPECT_NEAR(sigma(2, 0.2) / sigma(1, 0.2), 4, 1e-12);
  EXPECT_GT(sigma(2, 0.2), sigma(2, 0));
  EXPECT_EQ(sigma(100, 0.5), sigma(200, 0.1));
}

TEST(GapTurnSigma, ASlowCarMayTurnACornerInAGap) {
  const auto degrees = [](double seconds, std::optional<double> speed) {
    return InDegrees(GapTurnSigma({}, seconds, 0, speed));
  };
  EXPECT_LT(degrees(1, 5), 6);
  EXPECT_GT(2 * degrees(2, 5), 40);
  EXPECT_GT(2 * degrees(3, 5), 90);
  EXPECT_EQ(degrees(2, {}), degrees(2, 5)) << "a car of unknown speed may be slow";
  EXPECT_LT(degrees(3, 30), 7) << "no car turns a corner on a motorway";
}

TEST(MotionModel, TheSpeedBeforeAGapTellsHowFarTheCarMayTurnInIt) {
  MotionModel motion;
  motion.Update(0, RigidTransform{});
  motion.Update(0.2, {Eigen::Quaterniond::Identity(), {0, 0, -1}});
  EXPECT_EQ(motion.TurnSigmaAcross(2.2, 0.1, 4), GapTurnSigma({}, 2, 0.1, 20));
  EXPECT_EQ(motion.TurnSigmaAcross(2.2, -0.1, {}), GapTurnSigma({}, 2, 0.1, {}));
}

TEST(MotionModel, OptionsNameTheFieldThatMakesNoSense) {
  using Options = MotionModelOptions;
  EXPECT_EQ(RefusedField<Options>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.steady_seconds = -1; }), "steady_seconds");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.turn_seconds = 0; }), "turn_seconds");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.travel_seconds = 0; }), "travel_seconds");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.swing_seconds = -1; }), "swing_seconds");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.turn_acceleration = -1; }), "turn_acceleration");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.speed_sigma = 0; }), "speed_sigma");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.speed_sigma_per_second = -1; }), "speed_sigma_per_second");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.acceleration_in_depths = -1; }), "acceleration_in_depths");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.gap_turn_on_straights = 0; }), "gap_turn_on_straights");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.gap_turn_in_turns = -1; }), "gap_turn_in_turns");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.gap_corner = -1; }), "gap_corner");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.gap_corner_speed = 0; }), "gap_corner_speed");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_gap_turn = 0; }), "max_gap_turn");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_gap_corner = -1; }), "max_gap_corner");
}

}  // namespace
}  // namespace turnscale
