// SPDX-License-Identifier: MIT
#include "turnscale/odometry/pose_search.h"

#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "turnscale/features/synthetic_texture.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/frame_tracker.h"

namespace turnscale {
namespace {

constexpr double kInterval = 0.1;  // seconds
constexpr double kSecondsWithoutImage = 0.5;
constexpr double kSpeed = 0.4;  // metres per interval

// A yard with three textured walls: 12 m ahead, 5 m to the left and 7 m to the right. The landmarks are on what the
// camera shows at the origin; it has come there straight ahead.
class PoseSearch : public testing::Test {
 protected:
  PoseSearch() {
    map_.camera = {.pinhole = {200, 200, 159.5, 119.5}, .width = 320, .height = 240};
    map_.keyframes.push_back({0, 0, {}, {}, false});
    first_ = Seen({});
    AddTracks(16);
    motion_.Update(-kInterval, Pose(0, -kSpeed));
    motion_.Update(0, {});
  }

  // On a grid with so many pixels between its lines.
  void AddTracks(int step) {
    const auto reference = std::make_shared<const cv::Mat>(first_.gray);
    for (int row = 20; row <= 220; row += step)
      for (int column = 20; column <= 300; column += step) {
        const Eigen::Vector2d pixel(column + 0.3, row - 0.2);
        const int landmark = static_cast<int>(map_.landmarks.size());
        map_.landmarks.push_back({Surface({}, pixel).second, true, {}});
        AddObservation(map_, 0, landmark, pixel);
        const cv::Point2f shown(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
        tracks_.push_back({landmark, shown, pixel, pixel, reference, shown, 0, 0});
      }
  }

  // Turned to the right, moved along the mean heading.
  static RigidTransform Pose(double turn, double distance) {
    const Eigen::Vector3d centre = distance * Eigen::Vector3d(std::sin(turn / 2), 0, std::cos(turn / 2));
    return RigidTransform{RotationFromVector({0, turn, 0}), centre}.inverse();
  }

  // Wall and point that a pixel shows.
  std::pair<size_t, Eigen::Vector3d> Surface(const RigidTransform& camera_from_world,
                                             const Eigen::Vector2d& pixel) const {
    const RigidTransform world_from_camera = camera_from_world.inverse();
    const Eigen::Vector3d ray = world_from_camera.rotation * map_.camera.pinhole.Ray(pixel);
    const Eigen::Vector3d& centre = world_from_camera.translation;
    const std::array<double, 3> distances = {(12 - centre.z()) / ray.z(), (-5 - centre.x()) / ray.x(),
                                             (7 - centre.x()) / ray.x()};
    size_t nearest = 0;
    double distance = HUGE_VAL;
    for (size_t wall = 0; wall < distances.size(); ++wall)
      if (distances[wall] > 0 && distances[wall] < distance) distance = distances[nearest = wall];
    return {nearest, centre + distance * ray};
  }

  FlowImage Seen(const RigidTransform& camera_from_world) const { return Seen(camera_from_world, texture_); }

  FlowImage Seen(const RigidTransform& camera_from_world, const SyntheticTexture& texture) const {
    return BuildFlowImage(options_.flow,
                          MakeImage({map_.camera.width, map_.camera.height}, [&](const Eigen::Vector2d& pixel) {
                            const auto [wall, point] = Surface(camera_from_world, pixel);
                            const Eigen::Vector2d place(wall == 0 ? point.x() : point.z(), point.y());
                            return texture.At(place + 100.0 * static_cast<double>(wall) * Eigen::Vector2d::Ones());
                          }));
  }

  FlowImage Noise() const {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> gray(0, 255);
    return BuildFlowImage(options_.flow, MakeImage({map_.camera.width, map_.camera.height},
                                                   [&](const Eigen::Vector2d&) { return gray(random); }));
  }

  std::optional<RigidTransform> Search(const FlowImage& image) const {
    return SearchPose(map_, {.last_image = first_,
                             .last_from_world = motion_.last(),
                             .last_time = motion_.last_measured_time(),
                             .tracks = tracks_,
                             .lost_tracks = {},
                             .motion = motion_,
                             .image = image,
                             .time = kSecondsWithoutImage});
  }

  OdometryOptions options_;
  Map map_;
  SyntheticTexture texture_{5, 0.6, 3};  // wavelengths in metres
  FlowImage first_;
  std::vector<FeatureTrack> tracks_;
  MotionModel motion_;
};

// Largest distance in the image, pixels, of landmarks ahead by two poses.
double PixelError(const CameraModel& camera, const RigidTransform& a, const RigidTransform& b) {
  double largest = 0;
  for (const double x : {-3.0, 0.0, 3.0}) {
    const Eigen::Vector3d point = a.inverse() * Eigen::Vector3d(x, 0.5, 8);
    const Eigen::Vector3d by_b = b * point;
    largest = std::max(largest, (camera.pinhole.Project(a * point) - camera.pinhole.Project(by_b)).norm());
  }
  return largest;
}

TEST_F(PoseSearch, FindsTurnsAndSpeedsThatWereNotExpected) {
  for (const auto& [turn, distance] : {std::pair(0.25, 2.0), {-0.2, 2.4}, {0.1, 0.9}, {0.0, 3.0}}) {
    const std::optional<RigidTransform> pose = Search(Seen(Pose(turn, distance)));
    ASSERT_TRUE(pose) << turn << " rad, " << distance << " m";
    EXPECT_LT(PixelError(map_.camera, Pose(turn, distance), *pose), 2) << turn << " rad, " << distance << " m";
  }
}

TEST_F(PoseSearch, FindsNothingInAnImageOfSomethingElse) { EXPECT_FALSE(Search(Noise())); }

TEST_F(PoseSearch, FindsNothingInAnotherYardOfTheSameKind) {
  // With many landmarks some look alike at a few pixels anyway.
  AddTracks(12);
  for (const double contrast : {35.0, 3.0})
    for (unsigned seed = 10; seed < 16; ++seed) {
      const SyntheticTexture other(seed, 0.6, 3, contrast);
      EXPECT_FALSE(Search(Seen(Pose(0.1, 2), other))) << "seed " << seed << ", contrast " << contrast;
    }
}

TEST_F(PoseSearch, ImagesOfASingleSizeAreSearchedToo) {
  options_.flow.levels = 0;
  first_ = Seen({});
  ASSERT_EQ(first_.pyramid.size(), 1U);
  const RigidTransform truth = Pose(0.1, 2);
  const std::optional<RigidTransform> pose = Search(Seen(truth));
  ASSERT_TRUE(pose);
  EXPECT_LT(PixelError(map_.camera, truth, *pose), 2);
}

TEST_F(PoseSearch, TracksWithoutADepthDoNotCount) {
  for (Landmark& landmark : map_.landmarks) landmark.valid = false;
  EXPECT_FALSE(Search(Seen(Pose(0.25, 2))));
}

TEST_F(PoseSearch, TrackingGoesOnAfterAGapInATurn) {
  FrameTracker tracker(options_);
  tracker.Start(first_, tracks_, static_cast<int>(tracks_.size()));
  const RigidTransform truth = Pose(0.25, 2);
  FlowImage image = Seen(truth);
  const TrackedFrame frame =
      tracker.Track(map_, {}, image, motion_, motion_.Predict(kSecondsWithoutImage), kSecondsWithoutImage);
  ASSERT_TRUE(frame.camera_from_world);
  EXPECT_LT(PixelError(map_.camera, truth, *frame.camera_from_world), 0.3);
  size_t in_sight = 0;
  for (const FeatureTrack& track : tracks_) in_sight += PixelOf(map_, track.landmark, truth) ? 1 : 0;
  EXPECT_GT(tracker.tracks().size(), 0.7 * static_cast<double>(in_sight));
}

TEST_F(PoseSearch, TrackingGoesOnAfterAGapInImagesOfASingleSize) {
  options_.flow.levels = 0;
  first_ = Seen({});
  FrameTracker tracker(options_);
  tracker.Start(first_, tracks_, static_cast<int>(tracks_.size()));
  const RigidTransform truth = Pose(0.1, 3);
  FlowImage image = Seen(truth);
  const TrackedFrame frame =
      tracker.Track(map_, {}, image, motion_, motion_.Predict(kSecondsWithoutImage), kSecondsWithoutImage);
  ASSERT_TRUE(frame.camera_from_world);
  EXPECT_LT(PixelError(map_.camera, truth, *frame.camera_from_world), 0.3);
}

}  // namespace
}  // namespace turnscale
