// SPDX-License-Identifier: MIT
#include "turnscale/odometry/turned_views.h"

#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "turnscale/geometry/angle.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

class TurnedViewsTest : public testing::Test {
 protected:
  static Eigen::Quaterniond Heading(double degrees) { return RotationFromVector({0, degrees / kDegreesPerRadian, 0}); }

  // The gray level of each image is the number of its keyframe.
  void Drive(double heading) {
    map_.keyframes.push_back(
        {.frame = 0, .time = 0, .camera_from_world = {Heading(heading), {0, 0, 0}}, .observations = {}});
    views_.Add(map_, cv::Mat(2, 2, CV_8UC1, cv::Scalar(CountKeyframes(map_) - 1)));
  }

  // Keyframe of the view, and by how much the camera has turned since, degrees.
  std::optional<std::pair<int, double>> Before(double heading) {
    const EarlierView view = views_.Before(map_, Heading(heading));
    if (view.gray.empty()) return std::nullopt;
    return std::pair<int, double>(view.gray.at<uchar>(0, 0), InDegrees(VectorFromRotation(view.now_from_then).y()));
  }

  Map map_;
  TurnedViews views_;
};

TEST_F(TurnedViewsTest, ThereIsNoneOnAStraight) {
  EXPECT_FALSE(Before(0));
  for (int i = 0; i < 5; ++i) Drive(0.2 * i);
  EXPECT_FALSE(Before(1));
  EXPECT_EQ(Before(3)->first, 0) << "the latest pose has turned";
}

TEST_F(TurnedViewsTest, OneOfTwoLooksInAnotherDirection) {
  for (int i = 0; i <= 9; ++i) Drive(i);
  EXPECT_EQ(Before(9)->first, 4) << "kept at 0, 4 and 8 degrees";
  EXPECT_NEAR(Before(9)->second, 5, 1e-9);
  EXPECT_EQ(Before(11)->first, 8);
  EXPECT_NEAR(Before(11)->second, 3, 1e-9);
  EXPECT_EQ(Before(4)->first, 8) << "the camera turns back";
}

TEST_F(TurnedViewsTest, ANewMapForgetsThem) {
  for (int i = 0; i <= 9; ++i) Drive(i);
  views_.Clear();
  EXPECT_FALSE(Before(20));
  Drive(20);
  EXPECT_FALSE(Before(20));
  EXPECT_EQ(Before(23)->first, 10);
}

}  // namespace
}  // namespace turnscale
