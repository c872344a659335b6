// SPDX-License-Identifier: MIT
#include "turnscale/odometry/mount_jump.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "turnscale/geometry/angle.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kCarSpeed = 8;  // m/s

Eigen::Quaterniond Yaw(double degrees) {
  return RotationFromVector(degrees / kDegreesPerRadian * Eigen::Vector3d::UnitY());
}

// A camera that looks ahead.
struct Frames {
  std::vector<double> times;
  std::vector<RigidTransform> world_from_camera;
};

// A car that drives straight on, turns into a bend of 40 degrees per second within `turn_in` seconds after 3 s, and
// goes straight on within the same time after 5 s; 8 s in all.
Frames Bend(double fps, double turn_in = 0.8) {
  constexpr double kRate = 40;
  constexpr int kParts = 100;
  Frames frames;
  double heading = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (int i = 0; i < 8 * fps; ++i) {
    const double time = i / fps;
    frames.times.push_back(time);
    frames.world_from_camera.push_back({Yaw(heading), position});
    for (int part = 0; part < kParts; ++part) {
      const double now = time + part / (kParts * fps);
      const double share = std::clamp(std::min((now - 3) / turn_in, (5 + turn_in - now) / turn_in), 0.0, 1.0);
      heading += share * kRate / (kParts * fps);
      position += kCarSpeed / (kParts * fps) * (Yaw(heading) * Eigen::Vector3d::UnitZ());
    }
  }
  return frames;
}

// The camera is turned from frame `first` on.
void Turn(const Eigen::Quaterniond& before_from_after, std::size_t first, Frames& frames) {
  for (std::size_t i = first; i < frames.times.size(); ++i)
    frames.world_from_camera[i].rotation = frames.world_from_camera[i].rotation * before_from_after;
}

std::vector<MountJump> JumpsOf(const Frames& frames, const std::function<bool(std::size_t)>& is_break = {}) {
  MountJumpDetector detector;
  std::vector<MountJump> jumps;
  for (std::size_t i = 0; i < frames.times.size(); ++i) {
    if (is_break && is_break(i)) {
      if (const auto jump = detector.End()) jumps.push_back(*jump);
      continue;
    }
    const RigidTransform motion =
        i > 0 ? frames.world_from_camera[i - 1].inverse() * frames.world_from_camera[i] : RigidTransform();
    if (const auto jump = detector.Add(static_cast<int>(i), frames.times[i], motion, Eigen::Vector3d::UnitY()))
      jumps.push_back(*jump);
  }
  return jumps;
}

TEST(MountJump, TheUnitOfLengthMayChange) {
  Frames frames = Bend(10);
  Turn(Yaw(-2), 45, frames);
  MountJumpDetector detector;
  int jumps = 0;
  double unit = 1;
  for (std::size_t i = 0; i < frames.times.size(); ++i) {
    RigidTransform motion;
    if (i > 0) motion = frames.world_from_camera[i - 1].inverse() * frames.world_from_camera[i];
    if (i > 0 && i % 7 == 0) {
      detector.Rescale(1.5);
      unit *= 1.5;
    }
    motion.translation *= unit;
    if (const auto jump = detector.Add(static_cast<int>(i), frames.times[i], motion, Eigen::Vector3d::UnitY())) {
      EXPECT_EQ(jump->first_frame, 45);
      ++jumps;
    }
  }
  EXPECT_EQ(jumps, 1);
}

TEST(MountJump, AKnockIsMeasuredAtAnyRateOnAStraightAndInATurn) {
  const Eigen::Quaterniond knock = Yaw(-2) * RotationFromVector({0.01, 0, 0.02});
  for (const double fps : {10, 15, 25, 30, 60}) {
    for (const double at : {1.5, 4.5, 6.5}) {
      SCOPED_TRACE(testing::Message() << fps << " frames/s, after " << at << " s");
      Frames frames = Bend(fps);
      const auto first = static_cast<std::size_t>(at * fps);
      Turn(knock, first, frames);
      const std::vector<MountJump> jumps = JumpsOf(frames);
      ASSERT_EQ(jumps.size(), 1U);
      EXPECT_EQ(jumps[0].first_frame, static_cast<int>(first));
      EXPECT_EQ(jumps[0].time, frames.times[first]);
      EXPECT_LT(InDegrees(jumps[0].before_from_after.angularDistance(knock)), 0.1);
    }
  }
}

TEST(MountJump, AKnockWhereATurnBeginsOrEndsIsMeasured) {
  for (const double fps : {10, 30}) {
    for (double at = 2.5; at < 6.4; at += 0.1) {
      for (const double degrees : {-2, 2}) {
        SCOPED_TRACE(testing::Message() << fps << " frames/s, after " << at << " s, by " << degrees);
        Frames frames = Bend(fps);
        const auto first = static_cast<std::size_t>(std::lround(at * fps));
        Turn(Yaw(degrees), first, frames);
        const std::vector<MountJump> jumps = JumpsOf(frames);
        ASSERT_EQ(jumps.size(), 1U);
        EXPECT_EQ(jumps[0].first_frame, static_cast<int>(first));
        EXPECT_LT(InDegrees(jumps[0].before_from_after.angularDistance(Yaw(degrees))), 0.3);
      }
    }
  }
}

TEST(MountJump, OneThatTakesSomeFramesIsMeasured) {
  Frames frames = Bend(30);
  for (std::size_t i = 40; i < 44; ++i) Turn(Yaw(1), i, frames);
  const std::vector<MountJump> jumps = JumpsOf(frames);
  ASSERT_EQ(jumps.size(), 1U);
  EXPECT_LT(InDegrees(jumps[0].before_from_after.angularDistance(Yaw(4))), 0.3);
}

TEST(MountJump, TwoKnocksAreTwoJumps) {
  Frames frames = Bend(10);
  Turn(Yaw(3), 15, frames);
  Turn(Yaw(-2), 65, frames);
  const std::vector<MountJump> jumps = JumpsOf(frames);
  ASSERT_EQ(jumps.size(), 2U);
  EXPECT_EQ(jumps[0].first_frame, 15);
  EXPECT_EQ(jumps[1].first_frame, 65);
}

TEST(MountJump, AKnockThatSpoilsAnImageIsMeasured) {
  Frames frames = Bend(30);
  constexpr std::ptrdiff_t kFirst = 195;
  Turn(Yaw(4), kFirst, frames);
  frames.times.erase(frames.times.begin() + kFirst);
  frames.world_from_camera.erase(frames.world_from_camera.begin() + kFirst);
  const std::vector<MountJump> jumps = JumpsOf(frames);
  ASSERT_EQ(jumps.size(), 1U);
  EXPECT_LT(InDegrees(jumps[0].before_from_after.angularDistance(Yaw(4))), 0.2);
}

TEST(MountJump, APoseThatIsCorrectedOrNotFiniteIsNoJump) {
  const Frames frames = Bend(10);
  MountJumpDetector detector;
  for (std::size_t i = 0; i < frames.times.size(); ++i) {
    RigidTransform motion =
        i > 0 ? frames.world_from_camera[i - 1].inverse() * frames.world_from_camera[i] : RigidTransform();
    if (i == 20) motion.rotation = motion.rotation * Yaw(3);
    if (i == 60) motion.translation.x() = std::nan("");
    EXPECT_FALSE(detector.Add(static_cast<int>(i), frames.times[i], motion, Eigen::Vector3d::UnitY())) << i;
    if (i == 20) detector.CorrectLast({Yaw(-3), Eigen::Vector3d::Zero()});
  }
}

TEST(MountJump, TheNoiseOfACarThatStandsIsNoJump) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise;
  Frames frames;
  for (int i = 0; i < 600; ++i) {
    const Eigen::Vector3d turn = 3e-4 * Eigen::Vector3d(noise(random), noise(random), noise(random));
    const Eigen::Vector3d shift = 0.005 * Eigen::Vector3d(noise(random), noise(random), noise(random));
    frames.times.push_back(i / 30.0);
    frames.world_from_camera.push_back({RotationFromVector(turn), shift});
  }
  EXPECT_TRUE(JumpsOf(frames).empty());
}

TEST(MountJump, NoTurnOfACarIsAJump) {
  for (const double fps : {5, 7, 10, 30, 60})
    for (const double turn_in : {0.1, 0.3, 0.5, 0.8, 2.0})
      EXPECT_TRUE(JumpsOf(Bend(fps, turn_in)).empty()) << fps << ' ' << turn_in;
}

TEST(MountJump, AMotionThatSwingsBackIsNoJump) {
  Frames nod = Bend(10);
  for (std::size_t i = 20; i < 24; ++i)
    nod.world_from_camera[i].rotation = nod.world_from_camera[i].rotation * RotationFromVector({0.02, 0, 0.02});
  EXPECT_TRUE(JumpsOf(nod).empty()) << "the body nods and rolls";
  Frames glitch = Bend(10);
  glitch.world_from_camera[20].rotation = glitch.world_from_camera[20].rotation * Yaw(3);
  EXPECT_TRUE(JumpsOf(glitch).empty()) << "a wrong pose";
}

TEST(MountJump, AMissingImageInATurnIsNoJump) {
  const Frames all = Bend(10);
  for (std::size_t missing = 32; missing < 56; ++missing) {
    Frames frames;
    Frames with_times_of_a_constant_rate;
    for (std::size_t i = 0; i < all.times.size(); ++i) {
      if (i == missing) continue;
      frames.times.push_back(all.times[i]);
      frames.world_from_camera.push_back(all.world_from_camera[i]);
      with_times_of_a_constant_rate.times.push_back(all.times[i > missing ? i - 1 : i]);
    }
    with_times_of_a_constant_rate.world_from_camera = frames.world_from_camera;
    EXPECT_TRUE(JumpsOf(frames).empty()) << missing;
    EXPECT_TRUE(JumpsOf(with_times_of_a_constant_rate).empty()) << missing;
  }
}

TEST(MountJump, MotionAcrossALossOfTrackingIsNoJump) {
  Frames frames = Bend(10);
  Turn(Yaw(5), 20, frames);
  EXPECT_TRUE(JumpsOf(frames, [](std::size_t i) { return i == 19; }).empty());
}

}  // namespace
}  // namespace turnscale
