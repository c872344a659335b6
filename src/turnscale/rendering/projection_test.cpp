// SPDX-License-Identifier: MIT
// Known points are where the camera model says, to a twentieth of a pixel: with every lens, in motion, and in mirrors.
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "turnscale/rendering/renderer.h"
#include "turnscale/rendering/test_scene.h"

namespace turnscale {
namespace {

constexpr double kTolerance = 0.05;
// The rims of small marks are known well enough by so many samples of a pixel.
constexpr int kManySamples = 64;

RigidTransform PlaceOfCamera() {
  RigidTransform pose;
  pose.rotation = Eigen::AngleAxisd(0.6, Eigen::Vector3d(0.1, 1, 0.15).normalized());
  pose.translation = {120, -1.6, 340};
  return pose;
}

// Marks all over the image, the corners too, some near and some far, about `side` pixels wide.
std::vector<Mark> MarksAllOver(const CameraModel& camera, const RigidTransform& world_from_camera, double side) {
  std::vector<Mark> marks;
  const double margin = 1.5 * side + 0.3;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 8; ++column) {
      const Eigen::Vector2d pixel(margin + column * (camera.width - 1 - 2 * margin) / 7,
                                  margin + row * (camera.height - 1 - 2 * margin) / 5);
      const double distance = 2 + 5 * ((3 * row + column) % 7);
      const Eigen::Vector3d ray = camera.pinhole.Ray(camera.Undistort(pixel).value()).normalized();
      marks.push_back(MarkAt(world_from_camera * (distance * ray), world_from_camera.translation,
                             side * distance / camera.pinhole.fx));
    }
  }
  return marks;
}

void ExpectMarksInPlace(const CameraModel& camera, double side, int edge_samples) {
  Scene scene = EmptyScene();
  const std::vector<Mark> marks = MarksAllOver(camera, PlaceOfCamera(), side);
  for (const Mark& mark : marks) AddMark(mark, scene.fixed);
  RenderOptions options;
  options.edge_samples = edge_samples;
  const Renderer renderer(options, std::move(scene));
  const cv::Mat image = renderer.Render(camera, StillView(PlaceOfCamera()));
  const RigidTransform camera_from_world = PlaceOfCamera().inverse();
  const auto project = [&](const Eigen::Vector3d& x) { return *camera.Project(camera_from_world * x); };
  for (const Mark& mark : marks) {
    const Eigen::Vector2d expected = CentreOfArea(mark, project);
    EXPECT_LT((CentreOfLight(image, expected, static_cast<int>(1.2 * side)) - expected).norm(), kTolerance)
        << static_cast<int>(camera.lens) << ": " << expected.transpose();
  }
}

TEST(Projection, PointsAreWhereTheLensShowsThem) {
  for (const CameraModel& camera : TestCameras()) {
    // Few samples per pixel know the rim of a mark roughly: small marks need more of them, on large ones they average.
    ExpectMarksInPlace(camera, 10, kManySamples);
    ExpectMarksInPlace(camera, 20, RenderOptions().edge_samples);
  }
}

cv::Point Nearest(const Eigen::Vector2d& pixel) {
  return {static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))};
}

// Corners are compared so many pixels to each side, and are so far from the image's border at least: the window, its
// slopes and what is blurred into it are inside.
constexpr int kWindow = 6;
constexpr int kMargin = 10;

// How far a pattern is displaced around a pixel: least squares, a step of Lucas and Kanade (1981).
Eigen::Vector2d Displacement(const cv::Mat& expected, const cv::Mat& image, const Eigen::Vector2d& around) {
  const cv::Point middle = Nearest(around);
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int y = middle.y - kWindow; y <= middle.y + kWindow; ++y) {
    for (int x = middle.x - kWindow; x <= middle.x + kWindow; ++x) {
      const Eigen::Vector2d slope(0.5 * (expected.at<float>(y, x + 1) - expected.at<float>(y, x - 1)),
                                  0.5 * (expected.at<float>(y + 1, x) - expected.at<float>(y - 1, x)));
      information += slope * slope.transpose();
      sum += slope * (expected.at<float>(y, x) - image.at<float>(y, x));
    }
  }
  return information.ldlt().solve(sum);
}

// White or black of the checkerboard on the ground, where a pixel shows it.
double CheckerAt(const CameraModel& camera, const RigidTransform& world_from_camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = world_from_camera.rotation * camera.pinhole.Ray(camera.Undistort(pixel).value());
  if (ray.y() <= 0) return 0;
  const Eigen::Vector3d place = world_from_camera.translation - ray * (world_from_camera.translation.y() / ray.y());
  const int field = static_cast<int>(std::floor(place.x() / kField) + std::floor(place.z() / kField));
  return field % 2 == 0 ? 1 : 0;
}

// The checkerboard around its corners, each pixel the mean of many points of it.
cv::Mat ExactCheckerboard(const CameraModel& camera, const RigidTransform& world_from_camera,
                          const std::vector<Eigen::Vector2d>& corners) {
  constexpr int kSteps = 6;
  cv::Mat wanted(camera.height, camera.width, CV_8U, cv::Scalar(0));
  const cv::Point reach(kMargin, kMargin);
  for (const Eigen::Vector2d& corner : corners)
    cv::rectangle(wanted, Nearest(corner) - reach, Nearest(corner) + reach, cv::Scalar(1), cv::FILLED);
  cv::Mat image(wanted.size(), CV_32F, cv::Scalar(0));
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      if (wanted.at<uchar>(row, column) == 0) continue;
      double sum = 0;
      for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j)
          sum +=
              CheckerAt(camera, world_from_camera, {column + (j + 0.5) / kSteps - 0.5, row + (i + 0.5) / kSteps - 0.5});
      image.at<float>(row, column) = static_cast<float>(sum / (kSteps * kSteps));
    }
  }
  return image;
}

// Corners of the fields nearer than this are large enough to be seen one by one.
std::vector<Eigen::Vector2d> CheckerboardCorners(const CameraModel& camera, const RigidTransform& world_from_camera) {
  constexpr double kReach = 4.5;
  std::vector<Eigen::Vector2d> corners;
  for (double x = -10; x < 10; x += kField) {
    for (double z = -10; z < 10; z += kField) {
      const Eigen::Vector3d in_camera = world_from_camera.inverse() * Eigen::Vector3d(x, 0, z);
      const std::optional<Eigen::Vector2d> pixel = camera.Project(in_camera);
      if (!pixel || in_camera.norm() > kReach) continue;
      if (pixel->x() < kMargin || pixel->y() < kMargin) continue;
      if (pixel->x() > camera.width - 1 - kMargin || pixel->y() > camera.height - 1 - kMargin) continue;
      corners.push_back(*pixel);
    }
  }
  return corners;
}

// Against an exact drawing, as corner detectors err by a tenth of a pixel in the exact drawing itself.
TEST(Projection, TextureCornersAreWhereTheLensShowsThem) {
  RigidTransform pose;
  pose.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(-0.7, Eigen::Vector3d::UnitX());
  pose.translation = {0.1, -1.7, -2};
  for (const CameraModel& camera : TestCameras()) {
    Scene scene = EmptyScene();
    AddRectangle({kChecker, 5, {0, 0}}, {-20, 0, -20}, {40, 0, 0}, {0, 0, 40}, scene.fixed);
    const Renderer renderer({}, std::move(scene));
    cv::Mat image = renderer.Render(camera, StillView(pose));
    const std::vector<Eigen::Vector2d> corners = CheckerboardCorners(camera, pose);
    ASSERT_GT(corners.size(), 30U);
    cv::Mat exact = ExactCheckerboard(camera, pose, corners);
    cv::GaussianBlur(image, image, cv::Size(7, 7), 1.0);
    cv::GaussianBlur(exact, exact, cv::Size(7, 7), 1.0);
    for (const Eigen::Vector2d& corner : corners)
      EXPECT_LT(Displacement(exact, image, corner).norm(), kTolerance)
          << static_cast<int>(camera.lens) << ": " << corner.transpose();
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
  for (double x = -4; x <= 4; x += 2) marks.push_back(MarkAt({x, -0.8 - 0.1 * x, 10 + x}, mirrored_eye, 0.25));
  for (const Mark& mark : marks) AddMark(mark, scene.fixed);
  RenderOptions options;
  options.edge_samples = kManySamples;
  const Renderer renderer(options, std::move(scene));
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
  RenderOptions options;
  options.edge_samples = options.blur_samples = kManySamples;
  const Renderer renderer(options, std::move(scene));
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
  options.edge_samples = options.blur_samples = kManySamples;
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
  EXPECT_NEAR(cv::sum(image)[0], cv::sum(renderer.Render(camera, view))[0], 0.01 * cv::sum(image)[0]);
}

}  // namespace
}  // namespace turnscale
