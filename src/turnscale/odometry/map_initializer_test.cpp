// SPDX-License-Identifier: MIT
#include "turnscale/odometry/map_initializer.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/test_boards.h"

namespace turnscale {
namespace {

// Position i of a camera that goes ahead and to the right, turning.
RigidTransform Moved(int i) {
  const RigidTransform world_from_camera{RotationFromVector({0, 0.004 * i, 0}), {0.12 * i, 0, 0.12 * i}};
  return world_from_camera.inverse();
}

std::optional<InitialMap> Add(const Boards& boards, const RigidTransform& pose, int frame, MapInitializer& initializer,
                              const cv::Mat& mask = {}) {
  return initializer.Add(BuildFlowImage({}, boards.Seen(SmallCamera(), pose)), mask, frame, 0.1 * frame);
}

void ExpectTrueMap(const InitialMap& map, const Boards& boards, const RigidTransform& truth,
                   double max_direction_deg = 1.2, double max_rotation_deg = 0.1) {
  const double baseline = truth.translation.norm();
  EXPECT_NEAR(map.second_from_first.translation.norm(), 1, 1e-9) << "the baseline is the unit";
  const double cosine = map.second_from_first.translation.dot(truth.translation) / baseline;
  EXPECT_LT(std::acos(std::min(1.0, cosine)) * kDegreesPerRadian, max_direction_deg);
  EXPECT_LT(RotationAngle(map.second_from_first.rotation * truth.rotation.conjugate()) * kDegreesPerRadian,
            max_rotation_deg);
  int points = 0;
  int right = 0;
  for (size_t i = 0; i < map.points.size(); ++i) {
    if (map.has_point[i] == 0) continue;
    ++points;
    const double depth = boards.DepthAt(SmallCamera().pinhole.Ray(map.frames.front().undistorted[i]));
    right += std::abs(map.points[i].z() * baseline / depth - 1) < 0.1 ? 1 : 0;
  }
  EXPECT_GE(points, 80);
  EXPECT_GT(right, 0.8 * points);
}

TEST(MapInitializer, WaitsForABaselineAndFindsTheMap) {
  const Boards boards(1);
  MapInitializer initializer({}, SmallCamera());
  for (const int frame : {0, 1, 2}) {
    EXPECT_FALSE(Add(boards, Moved(0), frame, initializer)) << "standing still";
    EXPECT_GT(initializer.tracked(), 200);
  }
  std::optional<InitialMap> map;
  int last = 2;
  while (!map && last < 14) {
    ++last;
    map = Add(boards, Moved(last - 2), last, initializer);
  }
  ASSERT_TRUE(map);
  EXPECT_GT(last, 3) << "one step is too short a baseline";
  ASSERT_EQ(static_cast<int>(map->frames.size()), last + 1);
  EXPECT_EQ(map->frames.front().frame, 0);
  EXPECT_EQ(map->frames.back().frame, last);
  EXPECT_NEAR(map->frames.back().time, 0.1 * last, 1e-12);
  EXPECT_EQ(map->first_pixels.size(), map->points.size());
  EXPECT_EQ(map->second_pixels.size(), map->frames.back().features.size());
  for (size_t i = 0; i < map->has_point.size(); ++i) {
    if (map->has_point[i] != 0) {
      EXPECT_TRUE(std::ranges::binary_search(map->frames.back().features, static_cast<int>(i)));
    }
  }
  ExpectTrueMap(*map, boards, Moved(last - 2));
}

// A dashboard over the lower rows of the image.
cv::Mat BehindDashboard(const cv::Mat& scene, int first_row) {
  const SyntheticTexture texture(77, 8, 60);
  const cv::Mat dashboard = MakeImage(scene.size(), [&](const Eigen::Vector2d& pixel) { return texture.At(pixel); });
  cv::Mat image = scene.clone();
  dashboard.rowRange(first_row, scene.rows).copyTo(image.rowRange(first_row, scene.rows));
  return image;
}

TEST(MapInitializer, ADashboardIsNoneOfTheScene) {
  constexpr int kFirstRow = 150;
  const Boards boards(1);
  MapInitializer initializer({}, SmallCamera());
  const auto add = [&](int moved, int frame) {
    const cv::Mat image = BehindDashboard(boards.Seen(SmallCamera(), Moved(moved)), kFirstRow);
    return initializer.Add(BuildFlowImage({}, image), {}, frame, 0.1 * frame);
  };
  for (const int frame : {0, 1, 2}) EXPECT_FALSE(add(0, frame)) << "standing still";
  std::optional<InitialMap> map;
  int last = 2;
  while (!map && last < 14) {
    ++last;
    map = add(last - 2, last);
  }
  ASSERT_TRUE(map);
  EXPECT_EQ(map->frames.front().frame, 0);
  // Less of the scene is in sight.
  ExpectTrueMap(*map, boards, Moved(last - 2), 2.5, 0.2);
  for (size_t i = 0; i < map->has_point.size(); ++i) {
    if (map->has_point[i] != 0) {
      EXPECT_LT(map->frames.front().undistorted[i].y(), kFirstRow + 8) << "half a patch reaches over the edge";
    }
  }
  EXPECT_EQ(map->second_pixels.size(), map->frames.back().features.size());
  int still = 0;
  for (const ObservedMotion& motion : map->motion) {
    if (!motion.stands_still) continue;
    ++still;
    EXPECT_GT(motion.pixel.y, kFirstRow - 8);
  }
  EXPECT_GT(still, 50);
}

TEST(MapInitializer, WhatStandsStillAtTheSidesIsNoneOfTheScene) {
  // The pillars of the car cover half of the image, in the rows of the scene.
  const Boards boards(1);
  const SyntheticTexture texture(77, 8, 60);
  MapInitializer initializer({}, SmallCamera());
  std::optional<InitialMap> map;
  int last = -1;
  while (!map && last < 14) {
    ++last;
    cv::Mat image = boards.Seen(SmallCamera(), Moved(last));
    const cv::Mat pillar = MakeImage(image.size(), [&](const Eigen::Vector2d& pixel) { return texture.At(pixel); });
    for (const cv::Range& columns : {cv::Range(0, 120), cv::Range(360, 480)})
      pillar.colRange(columns).copyTo(image.colRange(columns));
    map = initializer.Add(BuildFlowImage({}, image), {}, last, 0.1 * last);
  }
  ASSERT_TRUE(map);
  for (size_t i = 0; i < map->has_point.size(); ++i) {
    if (map->has_point[i] != 0) {
      EXPECT_NEAR(map->frames.front().undistorted[i].x(), 240, 128);
    }
  }
}

TEST(MapInitializer, WhatPassesBeforeAStandingCameraIsNoStart) {
  // A wall that moves to the right covers a good part of the image.
  const Boards boards(5);
  const SyntheticTexture wall(50, 8, 60);
  const CameraModel camera = SmallCamera();
  MapInitializer initializer({}, camera);
  for (int frame = 0; frame < 12; ++frame) {
    cv::Mat image = boards.Seen(camera, Moved(0));
    const cv::Mat passing = MakeImage(image.size(), [&](const Eigen::Vector2d& pixel) {
      return wall.At(pixel - Eigen::Vector2d((1.0 + 0.02 * pixel.y()) * frame, 0));
    });
    passing.rowRange(140, 240).copyTo(image.rowRange(140, 240));
    EXPECT_FALSE(initializer.Add(BuildFlowImage({}, image), {}, frame, 0.1 * frame)) << "frame " << frame;
  }
}

TEST(MapInitializer, AVehicleThatLeavesBeforeAStandingCameraIsNoStart) {
  // Its rear, in the middle of the image, shrinks about the point that the vehicle drives to, the edges less than the
  // middle: motion straight back, if it were the scene.
  const Boards boards(5);
  const SyntheticTexture rear(50, 8, 60);
  const CameraModel camera = SmallCamera();
  const Eigen::Vector2d centre(240, 110);
  const auto starts = [&](double min_cell_share) {
    OdometryOptions options;
    options.initialization.min_cell_share = min_cell_share;
    MapInitializer initializer(options, camera);
    bool started = false;
    for (int frame = 0; frame < 14; ++frame) {
      cv::Mat image = boards.Seen(camera, Moved(0));
      const cv::Mat leaving = MakeImage(image.size(), [&](const Eigen::Vector2d& pixel) {
        const double depth = pixel.x() < 200 || pixel.x() > 280 ? 1.5 : 1;
        return rear.At(centre + (1 + 0.02 * frame / depth) * (pixel - centre));
      });
      const cv::Rect covered(160, 20, 160, 200);
      leaving(covered).copyTo(image(covered));
      started = started || initializer.Add(BuildFlowImage({}, image), {}, frame, 0.1 * frame);
    }
    return started;
  };
  EXPECT_TRUE(starts(0));
  EXPECT_FALSE(starts(OdometryOptions().initialization.min_cell_share));
}

TEST(MapInitializer, WhatPassesAndFillsTheImageIsNoStart) {
  const SyntheticTexture wall(50, 8, 60);
  const auto starts = [&](const std::optional<Eigen::Quaterniond>& vehicle_from_camera) {
    MapInitializer initializer({}, SmallCamera(), vehicle_from_camera);
    bool started = false;
    for (int frame = 0; frame < 12; ++frame) {
      const cv::Mat passing = MakeImage({480, 240}, [&](const Eigen::Vector2d& pixel) {
        return wall.At(pixel - Eigen::Vector2d((4.0 + 0.01 * pixel.x()) * frame, 0));
      });
      started = started || initializer.Add(BuildFlowImage({}, passing), {}, frame, 0.1 * frame);
    }
    return started;
  };
  EXPECT_TRUE(starts(std::nullopt)) << "the camera may look sideways";
  EXPECT_FALSE(starts(Eigen::Quaterniond::Identity()));
}

TEST(MapInitializer, MaskedPixelsAreLeftOut) {
  const Boards boards(1);
  cv::Mat mask(240, 480, CV_8U, cv::Scalar(255));
  mask.colRange(0, 160).setTo(0);
  MapInitializer initializer({}, SmallCamera());
  std::optional<InitialMap> map;
  for (int frame = 0; !map && frame < 14; ++frame) map = Add(boards, Moved(frame), frame, initializer, mask);
  ASSERT_TRUE(map);
  for (const cv::Point2f& pixel : map->first_pixels) EXPECT_TRUE(IsKept(mask, pixel)) << pixel;
  for (const cv::Point2f& pixel : map->second_pixels) EXPECT_TRUE(IsKept(mask, pixel)) << pixel;
}

TEST(MapInitializer, PureRotationGivesNoMap) {
  const Boards boards(2);
  MapInitializer initializer({}, SmallCamera());
  for (int frame = 0; frame < 6; ++frame) {
    const RigidTransform turned{RotationFromVector({0, -0.02 * frame, 0}), Eigen::Vector3d::Zero()};
    EXPECT_FALSE(Add(boards, turned, frame, initializer));
  }
  EXPECT_GT(initializer.tracked(), 100) << "it follows all the same";
}

TEST(MapInitializer, StartsFromTwoViewsThatShareLittle) {
  const Boards boards(3);
  MapInitializer initializer({}, SmallCamera());
  EXPECT_FALSE(Add(boards, Moved(0), 0, initializer));
  const int features = initializer.tracked();
  const std::optional<InitialMap> map = Add(boards, Moved(8), 1, initializer);
  EXPECT_LT(initializer.tracked(), 0.4 * features);
  ASSERT_TRUE(map);
  ExpectTrueMap(*map, boards, Moved(8));
}

TEST(MapInitializer, TakesANewFirstViewWhereTheOldOneIsOutOfSight) {
  const Boards before(3);
  const Boards after(400);
  MapInitializer initializer({}, SmallCamera());
  EXPECT_FALSE(Add(before, Moved(0), 0, initializer));
  EXPECT_FALSE(Add(before, Moved(1), 1, initializer));
  std::optional<InitialMap> map;
  int last = 1;
  while (!map && last < 14) {
    ++last;
    map = Add(after, Moved(last - 2), last, initializer);
  }
  ASSERT_TRUE(map);
  EXPECT_EQ(map->frames.front().frame, 2);
  ExpectTrueMap(*map, after, Moved(last - 2));
}

}  // namespace
}  // namespace turnscale
