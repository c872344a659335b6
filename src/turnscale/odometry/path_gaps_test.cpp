// SPDX-License-Identifier: MIT
#include "turnscale/odometry/path_gaps.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kGap = 3;  // seconds
constexpr int kFirstAfter = 5;

/// A drive along x at 5 units/s with a keyframe every 0.2 s; the first one after the gap is number 5, where the map
/// predicts it, and the car goes on at `after` units/s.
struct Drive {
  Map map;
  std::vector<MeasuredEnd> ends;
  RefinedScale refined;

  explicit Drive(double after, int keyframes = 10) {
    double x = 0;
    double time = 0;
    for (int k = 0; k < keyframes; ++k) {
      if (k > 0) {
        const double seconds = k == kFirstAfter ? kGap : 0.2;
        x += seconds * (k <= kFirstAfter ? 5 : after);
        time += seconds;
      }
      map.keyframes.push_back({k, time, {Eigen::Quaterniond::Identity(), {-x, 0, 0}}, {}, k == kFirstAfter});
      ends.push_back({time, {x, 0, 0}});
      refined.path.centres.emplace_back(2 * x, 0, 0);
      refined.path.metres_per_unit.push_back(2);
      refined.keyframes.push_back({.sigma = 0.02});
    }
  }

  /// Returns the standard deviation of the path's length, up to so many seconds after the last keyframe.
  double Bridge(double after = 0) {
    BridgeGaps(map, ends, map.keyframes.back().time + after, refined);
    return refined.gap_sigma;
  }
  double GapLength() const { return refined.path.centres[kFirstAfter].x() - refined.path.centres[kFirstAfter - 1].x(); }
  void SetSigma(double sigma, int first, int end) {
    for (int k = first; k < end; ++k) refined.keyframes[k].sigma = sigma;
  }
};

TEST(BridgeGaps, ASteadySpeedGoesOn) {
  Drive drive(5);
  const MetricPath before = drive.refined.path;
  EXPECT_NEAR(drive.Bridge(), GapLengthSigma(kGap, true), 1e-12);
  for (size_t k = 0; k < before.centres.size(); ++k)
    EXPECT_LT((drive.refined.path.centres[k] - before.centres[k]).norm(), 1e-9) << k;
}

TEST(BridgeGaps, ACarThatStopsHasGoneHalfAsFar) {
  Drive drive(0);
  drive.Bridge();
  EXPECT_NEAR(drive.GapLength(), 0.5 * kGap * 10, 1e-9);
  EXPECT_NEAR(drive.refined.path.centres.back().x(), drive.refined.path.centres[kFirstAfter].x(), 1e-9)
      << "what follows moves along";
}

TEST(BridgeGaps, ACarThatReversesHasHardlyMoved) {
  Drive drive(-5);
  drive.Bridge();
  EXPECT_NEAR(drive.GapLength(), 0, 1e-9);
}

TEST(BridgeGaps, ATurnInTheGapStays) {
  Drive drive(5);
  // To the right by 0.6 rad, of which the way across the gap has seen half.
  const Eigen::AngleAxisd half(0.3, Eigen::Vector3d::UnitY());
  std::vector<Eigen::Vector3d>& centres = drive.refined.path.centres;
  const std::vector<Eigen::Vector3d> straight = centres;
  const Eigen::Vector3d& start = straight[kFirstAfter - 1];
  const Eigen::Vector3d way = half * (straight[kFirstAfter] - start);
  for (size_t k = kFirstAfter; k < centres.size(); ++k)
    centres[k] = start + way + half * half * (straight[k] - straight[kFirstAfter]);
  drive.Bridge();
  EXPECT_LT((centres[kFirstAfter] - start - way).norm(), 1e-9);
}

TEST(BridgeGaps, ACarBrakesForACorner) {
  const auto turned = [](double turn, double sigma = 0) {
    Drive drive(5);
    const Eigen::Quaterniond rotation = RotationFromVector({0, -turn, 0});
    for (int k = kFirstAfter; k < CountKeyframes(drive.map); ++k)
      drive.map.keyframes[k].camera_from_world.rotation = rotation;
    drive.map.keyframes[kFirstAfter].gap_turn_sigma = sigma;
    drive.Bridge();
    return drive;
  };
  EXPECT_NEAR(turned(0.5).GapLength(), kGap * 10 - 0.18 * 0.25 * kGap * kGap, 1e-9);
  EXPECT_NEAR(turned(-0.5).GapLength(), turned(0.5).GapLength(), 1e-9);
  EXPECT_NEAR(turned(1.5).GapLength(), kGap * 10 - 0.25 * kGap * kGap, 1e-9);
  EXPECT_NEAR(turned(1.5).refined.gap_sigma, GapLengthSigma(kGap, true), 1e-12);
  // A turn of a radian that may be nearly two, and one that may be none.
  const double slowing = CornerSlowing(kGap, 1.8) - CornerSlowing(kGap, 1);
  const double chord = kGap * 10 * (1.8 * 1.8 - 1) / 24;
  EXPECT_NEAR(turned(1, 0.8).refined.gap_sigma, std::hypot(GapLengthSigma(kGap, true), slowing + chord), 1e-9);
  const double all = CornerSlowing(kGap, 1.5) + kGap * 10 * 1.5 * 1.5 / 24;
  EXPECT_NEAR(turned(1.5, 2).refined.gap_sigma, std::hypot(GapLengthSigma(kGap, true), all), 1e-9);
}

TEST(BridgeGaps, ASlowCarKeepsMostOfTheWay) {
  constexpr double kSlow = 0.02;
  Drive drive(5);
  for (int k = 0; k < CountKeyframes(drive.map); ++k) {
    RigidTransform& pose = drive.map.keyframes[k].camera_from_world;
    pose.translation *= kSlow;
    if (k >= kFirstAfter) pose = RigidTransform{RotationFromVector({0, 1.5, 0}), Eigen::Vector3d::Zero()} * pose;
    drive.ends[k].centre *= kSlow;
    drive.refined.path.centres[k] *= kSlow;
  }
  drive.Bridge();
  EXPECT_NEAR(drive.GapLength(), 0.75 * kSlow * kGap * 10, 1e-9);
}

TEST(BridgeGaps, OnlyWhatIsNotMeasuredIsInterpolated) {
  Drive drive(0);
  // The frames after the last keyframe are tracked for another second.
  drive.ends[kFirstAfter - 1].time += 1;
  drive.ends[kFirstAfter - 1].centre.x() += 5;
  const double sigma = drive.Bridge();
  EXPECT_NEAR(drive.GapLength(), 10 + 0.5 * (kGap - 1) * 10, 1e-9);
  EXPECT_NEAR(sigma, GapLengthSigma(kGap - 1, true), 1e-12);
}

TEST(BridgeGaps, TheSideWithTheBetterScaleDecides) {
  Drive drive(10);
  drive.SetSigma(2, 0, kFirstAfter);
  const double sigma = drive.Bridge();
  EXPECT_NEAR(drive.GapLength(), kGap * 20, 0.05 * kGap * 20) << "the speed after the gap";
  EXPECT_GT(sigma, 0.9 * GapLengthSigma(kGap, false)) << "from one side only";

  Drive other(10);
  other.SetSigma(2, kFirstAfter, 10);
  other.Bridge();
  EXPECT_NEAR(other.GapLength(), kGap * 10, 0.05 * kGap * 10) << "the speed before it";
}

TEST(BridgeGaps, APendingScaleIsTheSameOnBothSides) {
  Drive drive(10);
  drive.SetSigma(std::numeric_limits<double>::infinity(), 0, 10);
  EXPECT_NEAR(drive.Bridge(), GapLengthSigma(kGap, true), 1e-12);
  EXPECT_NEAR(drive.GapLength(), 0.5 * kGap * (10 + 20), 1e-9);
}

TEST(BridgeGaps, WithoutASpeedAfterThePredictionStays) {
  Drive drive(5, kFirstAfter + 1);
  EXPECT_NEAR(drive.Bridge(), GapLengthSigma(kGap, false), 1e-12);
  EXPECT_NEAR(drive.GapLength(), kGap * 10, 1e-9);
}

TEST(BridgeGaps, AnEndThatIsNotMeasuredCounts) {
  Drive drive(5, kFirstAfter);
  EXPECT_EQ(drive.Bridge(), 0);
  EXPECT_NEAR(drive.Bridge(2), GapLengthSigma(2, false), 1e-12);
}

TEST(GapLengthSigma, GrowsWithTheSquareOfTheTimeUpToABoundOfTheSpeed) {
  EXPECT_NEAR(GapLengthSigma(4, true) / GapLengthSigma(2, true), 4, 1e-12);
  EXPECT_GT(GapLengthSigma(2, false), GapLengthSigma(2, true));
  EXPECT_NEAR(GapLengthSigma(600, true) / GapLengthSigma(300, true), 2, 1e-12);
}

}  // namespace
}  // namespace turnscale
