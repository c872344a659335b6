// SPDX-License-Identifier: MIT
#include "turnscale/mapping/two_view_initialization.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/random_vector.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

struct Views {
  std::vector<Eigen::Vector2d> first;
  std::vector<Eigen::Vector2d> second;
  std::vector<Eigen::Vector3d> points;
};

// Points in front of the first camera, and where both views see them with the given pixel noise.
Views MakeViews(const RigidTransform& second_from_first, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(50, 1150);
  std::uniform_real_distribution<double> y(20, 340);
  std::uniform_real_distribution<double> depth(6, 30);
  std::normal_distribution<double> normal;
  const auto jitter = [&] { return DrawVector<2>([&] { return noise * normal(random); }); };
  Views views;
  for (int i = 0; i < 500; ++i) {
    const double row = y(random);
    const Eigen::Vector2d pixel(x(random), row);
    const Eigen::Vector3d point = depth(random) * kTestPinhole.Ray(pixel);
    const Eigen::Vector3d in_second = second_from_first * point;
    if (in_second.z() < 1) continue;
    views.first.emplace_back(pixel + jitter());
    views.second.emplace_back(kTestPinhole.Project(in_second) + jitter());
    views.points.push_back(point);
  }
  return views;
}

TEST(TwoViewInitialization, RecoversAForwardMotionThatTurns) {
  const RigidTransform truth{RotationFromVector({0.002, -0.05, 0.001}), {0.1, 0.0, -1.5}};
  Views views = MakeViews(truth, 0.3, 1);
  for (int i = 0; i < 80; ++i) views.second[i] += Eigen::Vector2d(-30, 25 + i);
  const TwoViewResult result = InitializeFromTwoViews({}, kTestPinhole, views.first, views.second);
  ASSERT_EQ(result.status, TwoViewStatus::kInitialized);
  EXPECT_LT(RotationAngle(result.second_from_first.rotation * truth.rotation.conjugate()) * kDegreesPerRadian, 0.02);
  EXPECT_NEAR(result.second_from_first.translation.norm(), 1.0, 1e-12) << "the baseline is the unit";
  const double angle = std::acos(result.second_from_first.translation.normalized().dot(truth.translation.normalized()));
  EXPECT_LT(angle * kDegreesPerRadian, 0.22);
  int good = 0;
  for (size_t i = 80; i < views.points.size(); ++i)
    if (result.triangulated[i] != 0 &&
        (result.points[i] * truth.translation.norm() - views.points[i]).norm() < 0.2 * views.points[i].norm())
      ++good;
  EXPECT_GT(good, 200);
}

TEST(TwoViewInitialization, AVehicleAheadIsNotTheScene) {
  const RigidTransform truth{RotationFromVector({0.002, 0.01, 0.001}), {0.1, 0.0, -1.5}};
  Views views = MakeViews(truth, 0.3, 1);
  const size_t in_scene = views.first.size();
  // Two thirds of all matches are on a vehicle that drives away from the camera, and to the left.
  const Views vehicle = MakeViews({Eigen::Quaterniond::Identity(), {-1.5, 0.1, 1.0}}, 0.3, 2);
  for (int round = 0; round < 6; ++round)
    for (size_t i = 0; i < vehicle.first.size(); ++i)
      if (std::abs(vehicle.first[i].x() - 600) < 150) {
        const Eigen::Vector2d shift(0.3 * round, 0.1 * round);
        views.first.emplace_back(vehicle.first[i] + shift);
        views.second.emplace_back(vehicle.second[i] + shift);
      }
  ASSERT_GT(views.first.size(), 2 * in_scene);
  const TwoViewResult result = InitializeFromTwoViews({}, kTestPinhole, views.first, views.second);
  ASSERT_EQ(result.status, TwoViewStatus::kInitialized);
  EXPECT_LT(RotationAngle(result.second_from_first.rotation * truth.rotation.conjugate()) * kDegreesPerRadian, 0.1);
  const double cosine = result.second_from_first.translation.normalized().dot(truth.translation.normalized());
  EXPECT_GT(cosine, std::cos(1 / kDegreesPerRadian));
}

TEST(TwoViewInitialization, AWideVehicleBelowIsNeverTheScene) {
  // It fills the lower part of the image over all its width, with half as many matches as the scene.
  const RigidTransform truth{Eigen::Quaterniond::Identity(), {0, 0, -1.5}};
  for (const double top : {150.0, 180.0, 210.0}) {
    Views views = MakeViews(truth, 0.3, 1);
    const Views vehicle = MakeViews({Eigen::Quaterniond::Identity(), {-1.5, 0.1, 1.0}}, 0.3, 2);
    Views seen;
    for (int round = 0; round < 3; ++round)
      for (size_t i = 0; i < views.first.size(); ++i)
        if (views.first[i].y() < top) {
          const Eigen::Vector2d shift(0.3 * round, 0.1 * round);
          seen.first.emplace_back(views.first[i] + shift);
          seen.second.emplace_back(views.second[i] + shift);
        }
    for (size_t i = 0; i < vehicle.first.size(); ++i)
      if (vehicle.first[i].y() > top) {
        seen.first.push_back(vehicle.first[i]);
        seen.second.push_back(vehicle.second[i]);
      }
    const TwoViewResult result = InitializeFromTwoViews({}, kTestPinhole, seen.first, seen.second);
    if (result.status == TwoViewStatus::kInitialized) {
      EXPECT_LT(result.second_from_first.translation.normalized().z(), -0.95) << top;
    }
  }
}

TEST(TwoViewInitialization, NoticesStandstill) {
  const Views views = MakeViews({}, 0.3, 2);
  const TwoViewResult result = InitializeFromTwoViews({}, kTestPinhole, views.first, views.second);
  EXPECT_EQ(result.status, TwoViewStatus::kStandstill);
  EXPECT_EQ(result.parallax, 0) << "it is not measured";
}

TEST(TwoViewInitialization, NoticesPureRotation) {
  const Views views = MakeViews({RotationFromVector({0.01, 0.08, 0}), Eigen::Vector3d::Zero()}, 0.3, 3);
  const TwoViewResult result = InitializeFromTwoViews({}, kTestPinhole, views.first, views.second);
  EXPECT_EQ(result.status, TwoViewStatus::kLowParallax);
  EXPECT_GT(result.motion, 40);
  EXPECT_LT(result.parallax, 1);
}

TEST(TwoViewInitialization, AShortBaselineIsNoLongerInASharperImage) {
  const auto start = [](double zoom, double travel) {
    const Pinhole pinhole{zoom * kTestPinhole.fx, zoom * kTestPinhole.fy, zoom * kTestPinhole.cx,
                          zoom * kTestPinhole.cy};
    Views views = MakeViews({Eigen::Quaterniond::Identity(), {0, 0, -travel}}, 0.0, 6);
    for (std::vector<Eigen::Vector2d>* pixels : {&views.first, &views.second})
      for (Eigen::Vector2d& pixel : *pixels) pixel *= zoom;
    return InitializeFromTwoViews({}, pinhole, views.first, views.second);
  };
  for (const double zoom : {1.0, 3.0}) {
    EXPECT_EQ(start(zoom, 0.35).status, TwoViewStatus::kLowParallax) << zoom;
    EXPECT_EQ(start(zoom, 1.2).status, TwoViewStatus::kInitialized) << zoom;
  }
  EXPECT_GT(start(3.0, 0.35).parallax, TwoViewOptions().min_parallax) << "else the angle were not needed";
  EXPECT_EQ(start(0.3, 0.9).status, TwoViewStatus::kLowParallax) << "too few pixels to measure";
}

TEST(TwoViewInitialization, FewLandmarksSufficeWhereImagesHaveFewFeatures) {
  const auto start = [](double travel, const TwoViewOptions& options, double zoom = 1) {
    // Sixty points nearby, a hundred far away.
    const RigidTransform motion{RotationFromVector({0, 0.02, 0}), {0.2 * travel, 0, -travel}};
    const Views views = MakeViews(motion, 0.2, 5);
    Views few;
    for (size_t i = 0; i < 160; ++i) {
      const bool is_near = i % 8 < 3;
      few.first.push_back(views.first[i]);
      few.second.push_back(is_near ? views.second[i] : kTestPinhole.Project(motion * (20 * views.points[i])));
      few.first.back() *= zoom;
      few.second.back() *= zoom;
    }
    const Pinhole pinhole{zoom * kTestPinhole.fx, zoom * kTestPinhole.fy, zoom * kTestPinhole.cx,
                          zoom * kTestPinhole.cy};
    return InitializeFromTwoViews(options, pinhole, few.first, few.second);
  };
  TwoViewOptions strict;
  strict.min_landmark_share = 1;
  EXPECT_EQ(start(2.5, strict).status, TwoViewStatus::kFailed);
  EXPECT_EQ(start(2.5, {}).status, TwoViewStatus::kInitialized);
  const TwoViewResult early = start(0.9, {});
  EXPECT_EQ(early.status, TwoViewStatus::kFailed) << "with more parallax, there may be more";
  EXPECT_LT(early.parallax, 2 * strict.min_parallax);
  const TwoViewResult sharper = start(0.9, {}, 3);
  EXPECT_EQ(sharper.status, TwoViewStatus::kFailed) << "the least parallax is an angle there";
  EXPECT_GT(sharper.parallax, 2 * strict.min_parallax);
}

TEST(TwoViewInitialization, NearFeaturesThatHaveGoneShowThatTheViewsSuffice) {
  // A street below many clouds: between a fifth and a quarter of what remains in sight is near.
  const RigidTransform motion{RotationFromVector({0, 0.02, 0}), {0.8, 0, -2.5}};
  Views views = MakeViews(motion, 0.2, 5);
  for (std::size_t i = 0; i < views.first.size(); ++i)
    if (i % 9 >= 2) views.second[i] = kTestPinhole.Project(motion * (100 * views.points[i]));
  const auto status = [&](int gone) {
    return InitializeFromTwoViews({}, kTestPinhole, views.first, views.second, gone).status;
  };
  EXPECT_EQ(status(0), TwoViewStatus::kLowParallax);
  EXPECT_EQ(status(100), TwoViewStatus::kLowParallax) << "there may be more to come";
  EXPECT_EQ(status(400), TwoViewStatus::kInitialized);
  views.first.resize(300);
  views.second.resize(300);
  EXPECT_EQ(status(400), TwoViewStatus::kLowParallax) << "too few near features are left";
}

TEST(TwoViewInitialization, FewMatchesSufficeIfMostBecomeLandmarks) {
  Views views = MakeViews({RotationFromVector({0, 0.02, 0}), {0.13, 0, -0.65}}, 0.2, 5);
  views.first.resize(90);
  views.second.resize(90);
  const TwoViewResult result = InitializeFromTwoViews({}, kTestPinhole, views.first, views.second);
  EXPECT_EQ(result.status, TwoViewStatus::kInitialized);
  EXPECT_LT(std::ranges::count(result.triangulated, 1), 80);
  EXPECT_LT(result.parallax, 2 * TwoViewOptions().min_parallax);
}

TEST(TwoViewInitialization, RefusesMatchesWithoutACommonMotion) {
  Views views = MakeViews({Eigen::Quaterniond::Identity(), {0, 0, -1.5}}, 0.3, 4);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> off(-100, 100);
  for (Eigen::Vector2d& pixel : views.second) pixel += Eigen::Vector2d(off(random), off(random));
  EXPECT_EQ(InitializeFromTwoViews({}, kTestPinhole, views.first, views.second).status, TwoViewStatus::kFailed);
}

TEST(TwoViewInitialization, OptionsNameTheFieldThatMakesNoSense) {
  using Options = TwoViewOptions;
  EXPECT_EQ(RefusedField<Options>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_motion = -1; }), "min_motion");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_parallax = 0; }), "min_parallax");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_parallax_deg = 0; }), "min_parallax_deg");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_epipolar_error = 0; }), "max_epipolar_error");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_landmarks = 7; }), "min_landmarks");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_landmark_share = -0.1; }), "min_landmark_share");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.fewest_landmarks = 81; }), "fewest_landmarks");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_inlier_share = 1.1; }), "min_inlier_share");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_landmark_parallax_deg = 0; }), "min_landmark_parallax_deg");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.initial_baseline = 0; }), "initial_baseline");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.initial_baseline = HUGE_VAL; }), "initial_baseline");
}

}  // namespace
}  // namespace turnscale
