// SPDX-License-Identifier: MIT
#include "turnscale/mapping/local_bundle_adjustment.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/random_vector.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

// Five keyframes; landmark i is seen by the keyframes of seen_by[i].
Map MakeSmallMap(const std::vector<std::vector<int>>& seen_by) {
  Map map;
  map.camera.pinhole = {700, 710, 600, 180};
  for (int k = 0; k < 5; ++k)
    map.keyframes.push_back({k, 0.1 * k, {Eigen::Quaterniond::Identity(), {0, 0, -1.0 * k}}, {}, false});
  for (size_t i = 0; i < seen_by.size(); ++i) {
    map.landmarks.push_back({Eigen::Vector3d(1.0 * static_cast<double>(i), 0, 20), true, {}});
    for (const int k : seen_by[i]) AddObservation(map, k, static_cast<int>(i), {100.0 * k, static_cast<double>(i)});
  }
  return map;
}

TEST(WindowProblem, TakesLandmarksThatFreeKeyframesSee) {
  Map map = MakeSmallMap({{3, 4}, {0, 1}, {1, 2}, {2, 3, 4}, {0, 4}, {3, 4}});
  map.landmarks[5].valid = false;
  const WindowProblem problem = MakeWindowProblem(map, {1, 3}, 0.7);
  EXPECT_EQ(problem.landmarks, (std::vector<int>{0, 3}))
      << "1 and 2 no free keyframe sees, 4 only one of the window, 5 has no depth";
  const BundleProblem& bundle = problem.bundle;
  EXPECT_EQ(bundle.pinhole.fy, 710);
  ASSERT_EQ(bundle.camera_from_world.size(), 4U);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(bundle.camera_from_world[i].translation.z(), -1.0 - i);
  EXPECT_EQ(bundle.camera_is_fixed, (std::vector<char>{1, 1, 0, 0}));
  ASSERT_EQ(bundle.points.size(), 2U);
  EXPECT_EQ(bundle.points[1].x(), 3);
  ASSERT_EQ(bundle.observations.size(), 5U);
  for (const BundleObservation& seen : bundle.observations) {
    EXPECT_EQ(seen.pixel, Eigen::Vector2d(100.0 * (seen.camera + 1), problem.landmarks[seen.point]));
    EXPECT_EQ(seen.sigma, 0.7);
  }
}

TEST(WindowProblem, WritesBackOnlyWhatMayMove) {
  Map map = MakeSmallMap({{3, 4}, {0, 1}});
  WindowProblem problem = MakeWindowProblem(map, {1, 3}, 1);
  ASSERT_EQ(problem.landmarks, (std::vector<int>{0}));
  for (RigidTransform& pose : problem.bundle.camera_from_world) pose.translation.x() += 7;
  problem.bundle.points[0].y() = 9;
  WriteBack(problem, map);
  for (int k = 0; k < 5; ++k) EXPECT_EQ(map.keyframes[k].camera_from_world.translation.x(), k < 3 ? 0 : 7) << k;
  EXPECT_EQ(map.landmarks[0].position, Eigen::Vector3d(0, 9, 20));
  EXPECT_EQ(map.landmarks[1].position, Eigen::Vector3d(1, 0, 20));
}

TEST(WindowProblem, LaterKeyframesFollowWhatIsWrittenBack) {
  Map map = MakeSmallMap({{1, 2}, {2, 3, 4}, {3, 4}});
  Map earlier = map;
  earlier.keyframes.resize(3);
  std::erase_if(earlier.landmarks[1].observations, [](const LandmarkObservation& seen) { return seen.keyframe > 2; });
  earlier.landmarks[2].observations.clear();
  WindowProblem problem = MakeWindowProblem(earlier, {0, 1}, 1);
  ASSERT_EQ(problem.landmarks, (std::vector<int>{0}));
  // Everything is 1.5 times as large about keyframe 0, and then turned.
  const RigidTransform turn{RotationFromVector({0.1, -0.2, 0.3}), {0.4, 0.5, 0.6}};
  const auto moved = [&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return turn * (1.5 * x); };
  for (RigidTransform& pose : problem.bundle.camera_from_world) {
    pose.translation *= 1.5;
    pose = pose * turn.inverse();
  }
  problem.bundle.camera_is_fixed.assign(3, 0);
  problem.bundle.points[0] = moved(map.landmarks[0].position);
  const Map before = map;
  WriteBack(problem, map);
  for (int k = 0; k < 5; ++k) {
    const RigidTransform& pose = map.keyframes[k].camera_from_world;
    const Eigen::Vector3d centre = before.keyframes[k].camera_from_world.inverse().translation;
    EXPECT_LT((pose.inverse().translation - moved(centre)).norm(), 1e-12) << k;
    EXPECT_LT(RotationAngle(pose.rotation * turn.rotation), 1e-7) << k;
  }
  for (int i = 0; i < 3; ++i)
    EXPECT_LT((map.landmarks[i].position - moved(before.landmarks[i].position)).norm(), 1e-12) << i;
}

TEST(WindowProblem, TheMapStartsAfterTheLastGap) {
  Map map = MakeSmallMap({});
  EXPECT_EQ(StartOfMap(map), 0);
  map.keyframes[1].after_gap = true;
  EXPECT_EQ(StartOfMap(map), 1);
  map.keyframes[3].after_gap = true;
  EXPECT_EQ(StartOfMap(map), 3);
  map.keyframes[4].after_gap = true;
  EXPECT_EQ(StartOfMap(map), 4);
}

constexpr int kKeyframes = 30;

// Straight on, then round a corner.
Map TrueMap() {
  const CarDrive drive = MakeCarDrive({{15, 0.8, 0}, {14, 0.8, 0.06}}, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  return MakeMap(drive, {.points_per_step = 30, .pixel_noise = 0.3});
}

// Moves keyframes from `first` on by 5 cm and a quarter of a degree, and what they see by two per cent of its depth.
void Disturb(int first, Map& map) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return DrawVector<3>([&] { return normal(random); }); };
  for (int k = first; k < CountKeyframes(map); ++k) {
    RigidTransform& pose = map.keyframes[k].camera_from_world;
    pose = RigidTransform{RotationFromVector(0.004 * vector()), 0.05 * vector()} * pose;
  }
  for (Landmark& landmark : map.landmarks)
    if (landmark.observations.front().keyframe >= first) {
      const RigidTransform& pose = map.keyframes[landmark.observations.front().keyframe].camera_from_world;
      landmark.position = pose.inverse() * ((1 + 0.02 * normal(random)) * (pose * landmark.position)).eval();
    }
}

double PositionError(const Map& map, const Map& truth, int keyframe) {
  return (map.keyframes[keyframe].camera_from_world.inverse().translation -
          truth.keyframes[keyframe].camera_from_world.inverse().translation)
      .norm();
}

double RotationError(const Map& map, const Map& truth, int keyframe) {
  return RotationAngle(map.keyframes[keyframe].camera_from_world.rotation *
                       truth.keyframes[keyframe].camera_from_world.rotation.conjugate()) *
         kDegreesPerRadian;
}

bool Moved(const Map& map, const Map& before, int keyframe) {
  const RigidTransform& a = map.keyframes[keyframe].camera_from_world;
  const RigidTransform& b = before.keyframes[keyframe].camera_from_world;
  return a.translation != b.translation || a.rotation.coeffs() != b.rotation.coeffs();
}

TEST(LocalBundleAdjustment, BringsTheLatestKeyframesBack) {
  const Map truth = TrueMap();
  ASSERT_EQ(truth.keyframes.size(), static_cast<size_t>(kKeyframes));
  Map map = truth;
  Disturb(kKeyframes - 10, map);
  const Map before = map;
  const LocalBundleResult result = AdjustLocalWindow({}, map);
  EXPECT_LT(result.summary.final_cost, 0.06 * result.summary.initial_cost);
  EXPECT_TRUE(std::ranges::is_sorted(result.landmarks));
  for (int k = 0; k < kKeyframes - 10; ++k) EXPECT_FALSE(Moved(map, before, k)) << k;
  for (int k = kKeyframes - 10; k < kKeyframes; ++k) {
    EXPECT_TRUE(Moved(map, before, k)) << k;
    EXPECT_LT(PositionError(map, truth, k), 0.007) << k;
    EXPECT_LT(RotationError(map, truth, k), 0.023) << k;
  }
}

TEST(LocalBundleAdjustment, LandmarksOutOfTheWindowStay) {
  Map map = TrueMap();
  Disturb(kKeyframes - 10, map);
  const Map before = map;
  const LocalBundleResult result = AdjustLocalWindow({}, map);
  size_t took_part = 0;
  size_t stayed = 0;
  for (size_t i = 0; i < map.landmarks.size(); ++i) {
    if (std::ranges::binary_search(result.landmarks, static_cast<int>(i))) {
      ++took_part;
      EXPECT_GE(map.landmarks[i].observations.back().keyframe, kKeyframes - 10) << i;
    } else {
      ++stayed;
      EXPECT_EQ(map.landmarks[i].position, before.landmarks[i].position) << i;
    }
  }
  EXPECT_EQ(took_part, result.landmarks.size());
  EXPECT_GT(took_part, 100U);
  EXPECT_GT(stayed, 100U);
}

TEST(LocalBundleAdjustment, TheFirstKeyframeNeverMoves) {
  Map map = TrueMap();
  Disturb(1, map);
  const Map before = map;
  AdjustFrom({}, 0, map);
  EXPECT_FALSE(Moved(map, before, 0));
  for (int k = 1; k < kKeyframes; ++k) EXPECT_TRUE(Moved(map, before, k)) << k;
}

TEST(LocalBundleAdjustment, AGapPartsTheMap) {
  const Map truth = TrueMap();
  Map map = truth;
  map.keyframes[22].after_gap = true;
  Disturb(24, map);
  // What is before the gap would pull, were it asked.
  for (int k = 0; k < 22; ++k) map.keyframes[k].camera_from_world.translation.x() += 3;
  const Map before = map;
  AdjustLocalWindow({}, map);
  for (int k = 0; k <= 22; ++k) EXPECT_FALSE(Moved(map, before, k)) << k;
  // The first step after the gap is the true one, and it holds the scale.
  for (int k = 23; k < kKeyframes; ++k) {
    EXPECT_TRUE(Moved(map, before, k)) << k;
    EXPECT_LT(RotationError(map, truth, k), 0.045) << k;
    EXPECT_LT(PositionError(map, truth, k), 0.007) << k;
  }
}

TEST(LocalBundleAdjustment, TheFirstStepKeepsItsLengthWhereNothingElseHoldsTheScale) {
  const auto first_step = [](const Map& map) {
    return (map.keyframes[23].camera_from_world.inverse().translation -
            map.keyframes[22].camera_from_world.inverse().translation)
        .norm();
  };
  Map map = TrueMap();
  map.keyframes[22].after_gap = true;
  Disturb(23, map);
  // The points are too near, as those of two noisy views are.
  const Eigen::Vector3d start = map.keyframes[22].camera_from_world.inverse().translation;
  for (Landmark& landmark : map.landmarks) landmark.position = start + 0.9 * (landmark.position - start);
  const double before = first_step(map);
  const LocalBundleResult result = AdjustLocalWindow({}, map);
  EXPECT_LT(result.summary.final_cost, 0.1 * result.summary.initial_cost);
  EXPECT_NEAR(first_step(map), before, 1e-9);
  // The rest follows it: the map is the true one but for its unit.
  const Map truth = TrueMap();
  const double unit = before / first_step(truth);
  const auto length = [](const Map& of) {
    double sum = 0;
    for (int k = 23; k < kKeyframes; ++k)
      sum += (of.keyframes[k].camera_from_world.inverse().translation -
              of.keyframes[k - 1].camera_from_world.inverse().translation)
                 .norm();
    return sum;
  };
  EXPECT_NEAR(length(map), unit * length(truth), 0.01 * unit * length(truth));
}

TEST(LocalBundleAdjustment, DoesNotDependOnTheUnitOfLength) {
  Map one = TrueMap();
  Disturb(kKeyframes - 10, one);
  Map ten = one;
  for (Keyframe& keyframe : ten.keyframes) keyframe.camera_from_world.translation *= 10;
  for (Landmark& landmark : ten.landmarks) landmark.position *= 10;
  AdjustLocalWindow({}, one);
  AdjustLocalWindow({}, ten);
  for (int k = 0; k < kKeyframes; ++k)
    EXPECT_LT(
        (ten.keyframes[k].camera_from_world.translation / 10 - one.keyframes[k].camera_from_world.translation).norm(),
        1e-6)
        << k;
}

TEST(LocalBundleAdjustment, ANumberThatIsNoneLeavesTheMapAsItIs) {
  Map map = TrueMap();
  Disturb(kKeyframes - 10, map);
  const int landmark = map.keyframes.back().observations.front().landmark;
  map.landmarks[landmark].position.x() = std::nan("");
  const Map before = map;
  for (const LocalBundleResult& result : {AdjustLocalWindow({}, map), AdjustFrom({}, 0, map)}) {
    EXPECT_TRUE(result.failed);
    EXPECT_TRUE(result.landmarks.empty());
  }
  for (int k = 0; k < kKeyframes; ++k) EXPECT_FALSE(Moved(map, before, k)) << k;
  for (size_t i = 0; i < map.landmarks.size(); ++i) {
    if (static_cast<int>(i) == landmark) continue;
    EXPECT_EQ(map.landmarks[i].position, before.landmarks[i].position) << i;
  }
}

TEST(LocalBundleAdjustment, OptionsNameTheFieldThatMakesNoSense) {
  using Options = LocalBundleOptions;
  EXPECT_EQ(RefusedField<Options>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.window = 1; }), "window");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.anchors = 0; }), "anchors");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.window = o.anchors = 10'000; }), "");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.window = 10'001; }), "window");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.anchors = 10'001; }), "anchors");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.pixel_sigma = 0; }), "pixel_sigma");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_iterations = 0; }), "max_iterations");
}

}  // namespace
}  // namespace turnscale
