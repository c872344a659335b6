// SPDX-License-Identifier: MIT
#include "turnscale/odometry/road_observer.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/road/synthetic_road.h"

namespace turnscale {
namespace {

constexpr double kMetresPerUnit = 8;
constexpr double kSpacing = 0.6;  // metres from keyframe to keyframe
constexpr int kRescaled = 4;

CameraModel RoadCamera() {
  CameraModel camera;
  camera.pinhole = {.fx = 300, .fy = 300, .cx = 239.5, .cy = 110};
  camera.width = 480;
  camera.height = 200;
  return camera;
}

/// What keyframes of a straight drive show, the map in its own unit.
struct Observed {
  Map map;  ///< as it truly is
  std::vector<std::optional<MeasuredHeight>> heights;
};

/// `rise`: by which each keyframe is too high while it is the latest one, metres. `blank`: first keyframes without
/// texture. `factor`: by which the map's unit changes before keyframe kRescaled.
Observed ObserveMap(const SyntheticRoad& road, int keyframes, int gap = -1, double rise = 0, int blank = 0,
                    double factor = 1) {
  const CameraModel camera = RoadCamera();
  RoadObserver observer{RoadObserverOptions{}};
  Observed observed;
  Map& map = observed.map;
  map.camera = camera;
  for (int k = 0; k < keyframes; ++k) {
    RigidTransform world_from_camera{RotationFromVector({-0.06, 0, 0}), {0, 0, kSpacing * k}};
    SyntheticRoad shown = road;
    if (k < blank) shown.contrast = 0;
    const RoadImage image = RenderRoad(shown, camera, world_from_camera);
    world_from_camera.translation *= (k < kRescaled ? 1 : factor) / kMetresPerUnit;
    if (k == kRescaled) {
      for (Keyframe& keyframe : map.keyframes) keyframe.camera_from_world.translation *= factor;
      observer.Rescale(factor);
    }
    map.keyframes.push_back({k, 0.1 * k, world_from_camera.inverse(), {}, k == gap});
    FlowImage flow;
    flow.gray = image.gray;
    flow.pyramid = {image.gray, image.half};
    RigidTransform too_high = world_from_camera;
    too_high.translation.y() -= rise / kMetresPerUnit;
    map.keyframes.back().camera_from_world = too_high.inverse();
    observed.heights.push_back(observer.Observe(map, Eigen::Quaterniond::Identity(), flow, {}));
    map.keyframes.back().camera_from_world = world_from_camera.inverse();
  }
  return observed;
}

std::vector<std::optional<MeasuredHeight>> Observe(const SyntheticRoad& road, int keyframes, int gap = -1) {
  return ObserveMap(road, keyframes, gap).heights;
}

TEST(RoadObserver, FindsTheHeightAndFollowsIt) {
  const SyntheticRoad road;
  const auto heights = Observe(road, 8);
  int seen = 0;
  for (int k = 0; k < 8; ++k) {
    if (!heights[k]) continue;
    ++seen;
    EXPECT_EQ(heights[k]->keyframe, k);
    EXPECT_LT(heights[k]->reference, k);
    const double distance = kSpacing * (k - heights[k]->reference);
    EXPECT_NEAR(heights[k]->ratio * distance / road.height, 1, 0.02) << k;
    EXPECT_LT(heights[k]->sigma, 0.06);
  }
  EXPECT_GE(seen, 6);
}

// The latest keyframe has an error that adjustment of the map removes later; so do the heights measured with it.
TEST(RoadObserver, HeightsFollowTheAdjustedMotion) {
  const SyntheticRoad road;
  const Observed exact = ObserveMap(road, 8);
  const Observed off = ObserveMap(road, 8, -1, 0.006);
  double before = 0;
  double after = 0;
  int compared = 0;
  for (int k = 3; k < 8; ++k) {
    if (!exact.heights[k] || !off.heights[k]) continue;
    VehicleStep step;
    step.first = k - 1;
    step.last = k;
    SetStepHeight(off.map, {*off.heights[k]}, step);
    const double distance = kSpacing / kMetresPerUnit * (k - off.heights[k]->reference);
    before += std::pow(off.heights[k]->ratio / exact.heights[k]->ratio - 1, 2);
    after += std::pow(step.height / (exact.heights[k]->ratio * distance) - 1, 2);
    ++compared;
  }
  EXPECT_GE(compared, 4);
  EXPECT_GT(std::sqrt(before / compared), 0.005);
  EXPECT_LT(std::sqrt(after / before), 0.4);
}

TEST(RoadObserver, GoesOnWhereTheUnitOfTheMapChanges) {
  const auto plain = ObserveMap({}, 8).heights;
  const auto rescaled = ObserveMap({}, 8, -1, 0, 0, 1.5).heights;
  ASSERT_TRUE(plain[kRescaled]);
  for (int k = 0; k < 8; ++k) {
    ASSERT_EQ(rescaled[k].has_value(), plain[k].has_value()) << k;
    if (plain[k]) {
      EXPECT_NEAR(rescaled[k]->ratio / plain[k]->ratio, 1, 1e-6) << k;
    }
  }
}

TEST(RoadObserver, NoRoadNoHeight) {
  for (const auto& height : Observe({.contrast = 0}, 6)) EXPECT_FALSE(height);
}

TEST(RoadObserver, SearchesAtEachOfTheFirstKeyframes) {
  const auto heights = ObserveMap({}, 6, -1, 0, 2).heights;
  EXPECT_FALSE(heights[1] || heights[2]);
  EXPECT_TRUE(heights[3]);
}

TEST(RoadObserver, DoesNotReachAcrossAGap) {
  for (const auto& height : Observe({}, 8, 4))
    if (height && height->keyframe >= 4) {
      EXPECT_GE(height->reference, 4);
    }
}

// Whether the road is found above the camera where the images are upside down; `mask` leaves out what is no scene.
bool IsAboveWhenTurned(const cv::Mat& mask) {
  constexpr int kKeyframes = 12;
  const CameraModel camera = RoadCamera();
  RoadObserver observer{RoadObserverOptions{}};
  Map map;
  map.camera = camera;
  map.camera.pinhole.cx = camera.width - 1 - camera.pinhole.cx;
  map.camera.pinhole.cy = camera.height - 1 - camera.pinhole.cy;
  for (int k = 0; k < kKeyframes; ++k) {
    const Eigen::Vector3d place(0, 0, kSpacing * k);
    cv::Mat turned;
    cv::rotate(RenderRoad({}, camera, {RotationFromVector({-0.06, 0, 0}), place}).gray, turned, cv::ROTATE_180);
    const RigidTransform world_from_camera{RotationFromVector({0.06, 0, 0}), place / kMetresPerUnit};
    map.keyframes.push_back(
        {.frame = k, .time = 0.1 * k, .camera_from_world = world_from_camera.inverse(), .observations = {}});
    observer.Observe(map, Eigen::Quaterniond::Identity(), BuildFlowImage(FlowOptions(), turned), mask);
  }
  return observer.IsRoadAbove();
}

TEST(RoadObserver, FindsARoadAboveUnlessWhatIsBelowIsHidden) {
  EXPECT_TRUE(IsAboveWhenTurned({}));
  cv::Mat mask(RoadCamera().height, RoadCamera().width, CV_8U, cv::Scalar(255));
  mask.rowRange(150, mask.rows).setTo(0);
  EXPECT_FALSE(IsAboveWhenTurned(mask)) << "it may be the ceiling of a garage";
}

TEST(RoadObserverOptions, RefusesSenselessValues) {
  const auto refused = [](auto change) { return RefusedField<RoadObserverOptions>(change); };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& o) { o.min_baseline = 0; }), "min_baseline");
  EXPECT_EQ(refused([](auto& o) { o.min_baseline = 1; }), "baseline");
  EXPECT_EQ(refused([](auto& o) { o.max_turn = 0; }), "max_turn_deg");
  EXPECT_EQ(refused([](auto& o) { o.plane.roll_sigma = 0; }), "roll_sigma_deg");
}

}  // namespace
}  // namespace turnscale
