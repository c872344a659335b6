// SPDX-License-Identifier: MIT
// Known points are where the camera model says, to a twentieth of a pixel: with every lens, in motion, and in mirrors.
#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "turnscale/rendering/renderer.h"
#include "turnscale/rendering/test_scene.h"

namespace turnscale {
namespace {

constexpr double kTolerance = 0.05;

RigidTransform SomePose() {
  RigidTransform pose;
  pose.rotation = Eigen::AngleAxisd(0.6, Eigen::Vector3d(0.1, 1, 0.15).normalized());
  pose.translation = {120, -1.6, 340};
  return pose;
}

// Marks all over the image, the corners too, some near and some far, about ten pixels wide.
std::vector<Mark> MarksAllOver(const CameraModel& camera, const RigidTransform& world_from_camera) {
  std::vector<Mark> marks;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 8; ++column) {
      const Eigen::Vector2d pixel(15.3 + column * (camera.width - 31.0) / 7, 15.7 + row * (camera.height - 31.0) / 5);
      const std::optional<Eigen::Vector2d> ideal = camera.Undistort(pixel);
      if (!ideal) continue;
      const double distance = 2 + 5 * ((3 * row + column) % 7);
      const Eigen::Vector3d place = world_from_camera * (distance * camera.pinhole.Ray(*ideal).normalized());
      marks.push_back(MarkAt(place, world_from_camera.translation, 10 * distance / camera.pinhole.fx));
    }
  }
  return marks;
}

TEST(Projection, PointsAreWhereTheLensShowsThem) {
  for (const CameraModel& camera : TestCameras()) {
    Scene scene = EmptyScene();
    const std::vector<Mark> marks = MarksAllOver(camera, SomePose());
    EXPECT_GT(marks.size(), 40U);
    for (const Mark& mark : marks) AddMark(mark, scene.fixed);
    const Renderer renderer({}, std::move(scene));
    const cv::Mat image = renderer.Render(camera, StillView(SomePose()));
    const RigidTransform camera_from_world = SomePose().inverse();
    for (const Mark& mark : marks) {
      const auto project = [&](const Eigen::Vector3d& x) { return *camera.Project(camera_from_world * x); };
      const Eigen::Vector2d expected = CentreOfArea(mark, project);
      EXPECT_LT((expected - project(mark.centre)).norm(), 0.3);
      EXPECT_LT((CentreOfLight(image, expected, 12) - expected).norm(), kTolerance)
          << static_cast<int>(camera.lens) << ": " << expected.transpose();
    }
  }
}

TEST(Projection, TextureCornersAreWhereTheLensShowsThem) {
  RigidTransform pose;
  pose.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(-0.7, Eigen::Vector3d::UnitX());
  pose.translation = {0.1, -1.7, -2};
  for (const CameraModel& camera : TestCameras()) {
    Scene scene = EmptyScene();
    AddRectangle({kChecker, 5, {0, 0}}, {-20, 0, -20}, {40, 0, 0}, {0, 0, 40}, scene.fixed);
    const Renderer renderer({}, std::move(scene));
    cv::Mat image = renderer.Render(camera, StillView(pose));
    cv::GaussianBlur(image, image, cv::Size(), 1.0);
    std::vector<cv::Point2f> corners;
    std::vector<Eigen::Vector2d> truth;
    for (double x = -10; x < 10; x += kField) {
      for (double z = -10; z < 10; z += kField) {
        const Eigen::Vector3d in_camera = pose.inverse() * Eigen::Vector3d(x, 0, z);
        // Nearer than this, fields are large enough to find the saddle between four of them.
        if (in_camera.norm() > 4.5) continue;
        const std::optional<Eigen::Vector2d> pixel = camera.Project(in_camera);
        if (!pixel || pixel->x() < 8 || pixel->y() < 8 || pixel->x() > camera.width - 9 ||
            pixel->y() > camera.height - 9)
          continue;
        truth.push_back(*pixel);
        corners.emplace_back(static_cast<float>(pixel->x()), static_cast<float>(pixel->y()));
      }
    }
    ASSERT_GT(corners.size(), 30U);
    cv::cornerSubPix(image, corners, cv::Size(4, 4), cv::Size(-1, -1),
                     cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-3));
    std::vector<double> errors;
    for (size_t i = 0; i < corners.size(); ++i)
      errors.push_back((Eigen::Vector2d(corners[i].x, corners[i].y) - truth[i]).norm());
    for (size_t i = 0; i < errors.size(); ++i) EXPECT_LT(errors[i], kTolerance) << truth[i].transpose();
  }
}

TEST(Projection, MirrorsShowPointsAtTheirMirroredPlaces) {
  const CameraModel camera = TestCameras()[0];
  RigidTransform pose;
  pose.translation = {0, -1.5, 0};
  const Eigen::Vector3d mirrored_eye(0, 1.5, 0);
  Scene scene = EmptyScene();
  AddRectangle({kMirror, 10, {0, 0}}, {-30, 0, 0}, {60, 0, 0}, {0, 0, 60}, scene.fixed);
  std::vector<Mark> marks;
  for (double x = -4; x <= 4; x += 2) marks.push_back(MarkAt({x, -0.8 - 0.3 * x, 10 + x}, mirrored_eye, 0.25));
  for (const Mark& mark : marks) AddMark(mark, scene.fixed);
  const Renderer renderer({}, std::move(scene));
  const cv::Mat image = renderer.Render(camera, StillView(pose));
  const auto project = [&](const Eigen::Vector3d& x) {
    return *camera.Project(pose.inverse() * Eigen::Vector3d(x.x(), -x.y(), x.z()));
  };
  for (const Mark& mark : marks) {
    const Eigen::Vector2d expected = CentreOfArea(mark, project);
    EXPECT_LT((CentreOfLight(image, expected, 12) - expected).norm(), kTolerance) << mark.centre.transpose();
  }
}

// A camera that drives past and turns, and a mark that moves as well.
RigidTransform MovingCamera(double time) {
  RigidTransform pose;
  pose.rotation = Eigen::AngleAxisd(0.5 * time, Eigen::Vector3d::UnitY());
  pose.translation = {6 * time, -1, 2 * time};
  return pose;
}

RigidTransform MovingMark(double time) {
  RigidTransform pose;
  pose.translation = {1 - 8 * time, -1 + time, 9};
  return pose;
}

// Where a rolling shutter shows a point: its row is exposed when the camera sees it in that row.
Eigen::Vector2d RollingProjection(const CameraModel& camera, double readout,
                                  const std::function<Eigen::Vector3d(double)>& place) {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double time = 0;
  for (int i = 0; i < 20; ++i) {
    pixel = *camera.Project(MovingCamera(time).inverse() * place(time));
    time = readout * (pixel.y() / (camera.height - 1) - 0.5);
  }
  return pixel;
}

TEST(Projection, RollingShutterSeesEachRowFromItsPose) {
  const CameraModel camera = TestCameras()[1];
  constexpr double kReadout = 0.05;
  Scene scene = EmptyScene();
  std::vector<Mark> marks;
  for (int i = 0; i < 9; ++i) {
    marks.push_back(MarkAt({-2.0 + (i % 3), -1 + 0.9 * (i - 4), 8}, {0, -1, 0}, 0.2));
    AddMark(marks.back(), scene.fixed);
  }
  const Mark moving = MarkAt({0, 0, 0}, {0, 0, -5}, 0.2);
  AddMark(moving, scene.movable.emplace_back());
  const Renderer renderer({}, std::move(scene));
  View view;
  view.world_from_camera = MovingCamera;
  view.world_from_movable = {MovingMark};
  view.shutter.readout = kReadout;
  const auto project = [&](const Eigen::Vector3d& x) {
    return RollingProjection(camera, kReadout, [&](double) { return x; });
  };
  const auto project_moving = [&](const Eigen::Vector3d& x) {
    return RollingProjection(camera, kReadout, [&](double time) -> Eigen::Vector3d { return MovingMark(time) * x; });
  };
  for (const double exposure : {0.0, 0.004}) {
    view.shutter.exposure = exposure;
    const cv::Mat image = renderer.Render(camera, view);
    for (const Mark& mark : marks) {
      const Eigen::Vector2d expected = CentreOfArea(mark, project);
      EXPECT_LT((CentreOfLight(image, expected, 12) - expected).norm(), kTolerance) << mark.centre.transpose();
      // At the frame's time it is elsewhere: the rows' times do matter.
      if (std::abs(mark.centre.y() + 1) < 2) continue;
      EXPECT_GT((expected - *camera.Project(MovingCamera(0).inverse() * mark.centre)).norm(), 1.0);
    }
    const Eigen::Vector2d expected = CentreOfArea(moving, project_moving);
    EXPECT_LT((CentreOfLight(image, expected, 12) - expected).norm(), kTolerance);
  }
}

TEST(Projection, MotionBlurIsAsLongAsTheMotion) {
  const CameraModel camera = TestCameras()[0];
  constexpr double kExposure = 0.02;
  constexpr double kSpeed = 20;
  constexpr double kDistance = 10;
  Scene scene = EmptyScene();
  AddMark(MarkAt({0, 0, kDistance}, {0, 0, 0}, 0.2), scene.fixed);
  RenderOptions options;
  options.blur_samples = 64;
  const Renderer renderer(options, std::move(scene));
  View view;
  view.world_from_camera = [](double time) {
    RigidTransform pose;
    pose.translation = {kSpeed * time, 0, 0};
    return pose;
  };
  view.shutter.exposure = kExposure;
  const cv::Mat image = renderer.Render(camera, view);
  cv::Mat profile;
  cv::reduce(image, profile, 0, cv::REDUCE_SUM, CV_64F);
  double peak = 0;
  cv::minMaxLoc(profile, nullptr, &peak);
  const double length = camera.pinhole.fx * kSpeed * kExposure / kDistance;
  ASSERT_GT(length, 15);
  // The profile is a trapezoid: as wide at half its height as the motion is long.
  EXPECT_NEAR(cv::sum(profile)[0] / peak, length, 1.0);
  const Eigen::Vector2d middle = *camera.Project({0, 0, kDistance});
  EXPECT_LT((CentreOfLight(image, middle, 20) - middle).norm(), kTolerance);
  // The light is that of the mark, spread out.
  view.shutter.exposure = 0;
  EXPECT_NEAR(cv::sum(image)[0], cv::sum(renderer.Render(camera, view))[0], 0.5);
}

}  // namespace
}  // namespace turnscale
