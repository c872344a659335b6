// SPDX-License-Identifier: MIT
#include "turnscale/rendering/renderer.h"

#include <cmath>
#include <limits>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/rendering/pattern.h"
#include "turnscale/rendering/test_scene.h"

namespace turnscale {
namespace {

RigidTransform At(const Eigen::Vector3d& place, double yaw = 0, double pitch = 0) {
  RigidTransform pose;
  pose.rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX());
  pose.translation = place;
  return pose;
}

// A bit of everything: sun, sky, lamps, mirrors, textures, things that move.
Scene BusyScene() {
  Scene scene = EmptyScene();
  PatternOptions options;
  options.side = 256;
  scene.patterns.push_back({[options] { return PavementPattern(options); }, 4});
  scene.materials.push_back({2, 1, 0.05F, 0});
  AddRectangle({5, 1, {0, 0}}, {-20, 0, -5}, {40, 0, 0}, {0, 0, 50}, scene.fixed);
  for (int i = 0; i < 12; ++i) {
    AddBox({i % 2 == 0 ? 5 : int{kChecker}, 1, {0.3 * i, 0}}, At({-9.0 + 2 * i, 0, 6.0 + i % 4}, 0.3 * i),
           {{1, 2, 1.5}}, scene.fixed);
    AddPrism({5, 1, {0, 0}}, At({-8.0 + 2 * i, 0, 12}), {}, scene.fixed);
  }
  AddBox({5, 1, {0, 0}}, {}, {{1.8, 1.4, 4}}, scene.movable.emplace_back());
  scene.sun = Sun();
  scene.sky = 0.8F;
  scene.ambient = 0.4F;
  scene.lamps.push_back({{0, -3, 5}, 1.2F, 0.2F, 4});
  return scene;
}

View BusyView(const Shutter& shutter) {
  View view;
  view.world_from_camera = [](double time) { return At({3 * time, -1.5, 0}, 0.2 + time, 0.05); };
  view.world_from_movable = {[](double time) { return At({2 - 5 * time, 0, 9}, 1 + time); }};
  view.shutter = shutter;
  return view;
}

TEST(Renderer, SameBitsOnAnyNumberOfThreads) {
  const CameraModel camera = TestCameras()[1];
  RenderOptions options;
  options.threads = 1;
  const Renderer one(options, BusyScene());
  options.threads = 3;
  const Renderer three(options, BusyScene());
  for (const Shutter& shutter : {Shutter{}, Shutter{0, 0.03}, Shutter{0.01, 0}, Shutter{0.01, 0.03}}) {
    const cv::Mat first = one.Render(camera, BusyView(shutter));
    EXPECT_EQ(cv::norm(first, three.Render(camera, BusyView(shutter)), cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(first, one.Render(camera, BusyView(shutter)), cv::NORM_INF), 0);
    EXPECT_TRUE(cv::checkRange(first, true, nullptr, 0, 100));
  }
}

TEST(Renderer, ABlurredImageOfNoMotionIsTheSharpOne) {
  const CameraModel camera = TestCameras()[0];
  RenderOptions options;
  options.blur_samples = 16;
  options.edge_samples = 16;
  const Renderer renderer(options, BusyScene());
  View view = BusyView({});
  view.world_from_camera = [](double) { return At({0, -1.5, 0}, 0.2); };
  view.world_from_movable = {[](double) { return At({2, 0, 9}, 1); }};
  const cv::Mat sharp = renderer.Render(camera, view);
  view.shutter.exposure = 0.01;
  EXPECT_LT(cv::norm(sharp, renderer.Render(camera, view), cv::NORM_L1), 0.02 * cv::norm(sharp, cv::NORM_L1));
}

TEST(Renderer, DistanceIsAlongTheRay) {
  Scene scene = EmptyScene();
  AddRectangle({kWhite, 10, {0, 0}}, {-30, -30, 12}, {30, 0, 0}, {0, 60, 0}, scene.fixed);
  AddBox({kWhite, 10, {0, 0}}, {}, {{1, 1, 1}}, scene.movable.emplace_back());
  const Renderer renderer({}, std::move(scene));
  View view = StillView(At({0, 0, 2}));
  view.world_from_movable = {[](double time) { return At({-2, 0.5, 5 + 100 * time}); }};
  view.shutter = {0.01, 0.02};
  for (const CameraModel& camera : TestCameras()) {
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(20.5, 30), Eigen::Vector2d(250, 40), Eigen::Vector2d(30, 450)}) {
      const Eigen::Vector3d ray = camera.pinhole.Ray(*camera.Undistort(pixel)).normalized();
      EXPECT_NEAR(renderer.Distance(camera, view, pixel), 10 / ray.z(), 1e-4);
    }
    const Eigen::Vector2d near = *camera.Project({-2, 0, 2.5});
    EXPECT_NEAR(renderer.Distance(camera, view, near), Eigen::Vector3d(-2, 0, 2.5).norm(), 1e-4);
    EXPECT_EQ(renderer.Distance(camera, view, {600, 240}), std::numeric_limits<double>::infinity());
  }
}

TEST(Renderer, WhatIsCoveredStaysBlackAndNothingElseChanges) {
  const CameraModel camera = TestCameras()[0];
  const Renderer renderer({}, BusyScene());
  cv::Mat covered(camera.height, camera.width, CV_8U, cv::Scalar(0));
  covered.rowRange(300, camera.height) = 255;
  covered.rowRange(310, 320) = 0;
  for (const double exposure : {0.0, 0.01}) {
    View view = BusyView({exposure, 0.01});
    const cv::Mat whole = renderer.Render(camera, view);
    view.covered = covered;
    const cv::Mat image = renderer.Render(camera, view);
    EXPECT_EQ(cv::norm(image, cv::NORM_INF, covered), 0);
    // At the border of what is covered, pixels count as edges and are sampled more finely.
    cv::Mat far_from_border;
    cv::erode(covered == 0, far_from_border, {});
    EXPECT_EQ(cv::norm(image, whole, cv::NORM_INF, far_from_border), 0);
    EXPECT_GT(cv::norm(whole, cv::NORM_INF, covered), 0.1);
  }
  View view = BusyView({});
  view.covered = cv::Mat(10, 10, CV_8U, cv::Scalar(0));
  EXPECT_THROW(renderer.Render(camera, view), InternalError);
}

TEST(Renderer, ShadowsFallAwayFromTheSun) {
  Scene scene = EmptyScene();
  scene.ambient = 0;
  scene.sun = Sun{{1, -2, 0.5F}, 0.8F};
  AddRectangle({kWhite, 5, {0, 0}}, {-20, 0, -20}, {40, 0, 0}, {0, 0, 40}, scene.fixed);
  // A plate two metres up, one metre wide.
  AddRectangle({kWhite, 5, {0, 0}}, {-0.5, -2, 5.5}, {1, 0, 0}, {0, 0, 1}, scene.fixed);
  const Renderer renderer({}, std::move(scene));
  const CameraModel camera = TestCameras()[0];
  const RigidTransform pose = At({0, -4, 2}, 0, -0.8);
  const cv::Mat image = renderer.Render(camera, StillView(pose));
  const double cosine = 2 / std::sqrt(1 + 4 + 0.25);
  int shaded = 0;
  int lit = 0;
  for (double x = -2; x < 1; x += 0.05) {
    for (double z = 4; z < 7; z += 0.05) {
      // Towards the sun by two metres of height: one along x, half a metre along z.
      const double plate_x = x + 1;
      const double plate_z = z + 0.5 - 6;
      const double outside = std::max(std::abs(plate_x), std::abs(plate_z)) - 0.5;
      const Eigen::Vector3d in_camera = pose.inverse() * Eigen::Vector3d(x, 0, z);
      const Eigen::Vector2d pixel = *camera.Project(in_camera);
      const cv::Point at(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())));
      // Not at the shadow's edge, and not behind the plate.
      if (std::abs(outside) < 0.04 || !cv::Rect(0, 0, camera.width, camera.height).contains(at)) continue;
      if (std::abs(renderer.Distance(camera, StillView(pose), {at.x, at.y}) - in_camera.norm()) > 0.05) continue;
      EXPECT_NEAR(image.at<float>(at), outside < 0 ? 0 : 0.8 * cosine, 1e-5) << x << " " << z;
      ++(outside < 0 ? shaded : lit);
    }
  }
  EXPECT_GT(shaded, 100);
  EXPECT_GT(lit, 1000);
}

// A box that comes nearer while the rows are read is lit alike on all of them: shadow rays see it where it is then.
TEST(Renderer, ShadowsAreOfTheMomentAtWhichTheyAreSeen) {
  Scene scene = EmptyScene();
  scene.ambient = 0;
  scene.sun = Sun{{0, -1, -1}, 0.8F};
  AddBox({kWhite, 10, {0, 0}}, {}, {{4, 4, 1}}, scene.movable.emplace_back());
  const Renderer renderer({}, std::move(scene));
  View view = StillView({});
  view.world_from_movable = {[](double time) { return At({0, 2, 8 - 20 * time}); }};
  for (const Shutter& shutter : {Shutter{0, 0.05}, Shutter{0.02, 0}, Shutter{0.02, 0.03}}) {
    view.shutter = shutter;
    const cv::Mat face = renderer.Render(TestCameras()[0], view)(cv::Rect(250, 170, 120, 160));
    double least = 0;
    double most = 0;
    cv::minMaxLoc(face, &least, &most);
    EXPECT_NEAR(least, 0.8 * M_SQRT1_2, 1e-5);
    EXPECT_NEAR(most, 0.8 * M_SQRT1_2, 1e-5);
  }
}

// Where fields are smaller than pixels there is no pattern of false ones.
TEST(Renderer, AFarCheckerboardIsGray) {
  Scene scene = EmptyScene();
  AddRectangle({kChecker, 100, {0, 0}}, {-3000, 0, 0}, {6000, 0, 0}, {0, 0, 3000}, scene.fixed);
  const Renderer renderer({}, std::move(scene));
  const CameraModel camera = TestCameras()[0];
  const cv::Mat image = renderer.Render(camera, StillView(At({0.2, -1.5, 1})));
  // So many rows below the horizon the floor is `fx 1.5 m / rows` away, and a pixel `1.5 m fx / rows^2` long: fields
  // fill a pixel 35 rows down, and their width is 12 pixels there.
  const auto deviation = [&](int rows_down) {
    cv::Scalar mean;
    cv::Scalar deviation_of_rows;
    const int row = static_cast<int>(camera.pinhole.cy) + rows_down;
    cv::meanStdDev(image.rowRange(row, row + 2), mean, deviation_of_rows);
    EXPECT_NEAR(mean[0], 0.5, 0.05) << rows_down;
    return deviation_of_rows[0];
  };
  EXPECT_GT(deviation(150), 0.4);
  EXPECT_LT(deviation(16), 0.1);
  EXPECT_LT(deviation(8), 0.02);
  EXPECT_LT(deviation(3), 0.01);
}

// Along an edge that is nearly upright, each row shows where it is: as well as 8 samples of a pixel can tell.
TEST(Renderer, EdgesAreSmooth) {
  Scene scene = EmptyScene();
  AddRectangle({kShining, 100, {0, 0}}, {0, -20, 10}, {-40, 0, 0}, {-4, 40, 0}, scene.fixed);
  const Renderer renderer({}, std::move(scene));
  const CameraModel camera = TestCameras()[0];
  const cv::Mat image = renderer.Render(camera, StillView({}));
  double sum = 0;
  double squares = 0;
  for (int row = 0; row < image.rows; ++row) {
    const double y = 10 * (row - camera.pinhole.cy) / camera.pinhole.fy;
    const double edge = camera.pinhole.fx * (-0.1 * (y + 20)) / 10 + camera.pinhole.cx;
    const double error = cv::sum(image.row(row))[0] - (edge + 0.5);
    // Samples stand an eighth of a pixel apart, more where the edge leans from one pixel into the next.
    EXPECT_LT(std::abs(error), 0.17) << row;
    sum += error;
    squares += error * error;
  }
  // One sample of a pixel would make it 0.29.
  EXPECT_LT(std::sqrt(squares / image.rows), 0.06);
  EXPECT_NEAR(sum / image.rows, 0, 0.005);
}

TEST(Renderer, ALensThatSeesNothingIsBlack) {
  Scene scene = EmptyScene();
  scene.sky = 1;
  CameraModel camera = TestCameras()[2];
  camera.pinhole.fx = camera.pinhole.fy = 150;
  const Renderer renderer({}, std::move(scene));
  const cv::Mat image = renderer.Render(camera, StillView({}));
  EXPECT_EQ(image.at<float>(10, 10), 0);
  EXPECT_GT(image.at<float>(240, 320), 0.5F);
  EXPECT_EQ(renderer.Distance(camera, StillView({}), {10, 10}), std::numeric_limits<double>::infinity());
}

TEST(Renderer, MirrorsShareTheLight) {
  // A mirror of a tenth, seen from straight above: nine tenths of its own white, a tenth of a shining ceiling.
  Scene scene = EmptyScene();
  scene.ambient = 0.5F;
  scene.materials.push_back({0, 1, 0.1F, 0});
  Mesh& mesh = scene.fixed;
  AddRectangle({5, 10, {0, 0}}, {-5, 0, -5}, {10, 0, 0}, {0, 0, 10}, mesh);
  AddRectangle({kShining, 10, {0, 0}}, {-5, -6, -5}, {0, 0, 10}, {10, 0, 0}, mesh);
  const Renderer renderer({}, std::move(scene));
  const CameraModel camera = TestCameras()[0];
  const cv::Mat image = renderer.Render(camera, StillView(At({0, -1, 0}, 0, -0.5 * M_PI)));
  EXPECT_NEAR(image.at<float>(252, 309), 0.9 * 0.5 + 0.1, 1e-3);
}

TEST(Renderer, RefusesScenesThatDoNotFitTogether) {
  const auto refused = [](const std::function<void(Scene&)>& change) {
    Scene scene = BusyScene();
    change(scene);
    EXPECT_THROW(Renderer({}, std::move(scene)), InternalError);
  };
  refused([](Scene& scene) { scene.materials[0].pattern = 9; });
  refused([](Scene& scene) { scene.fixed.triangles[0].material = 99; });
  refused([](Scene& scene) { scene.fixed.triangles[0].vertices[1] = -1; });
  refused([](Scene& scene) { scene.movable[0].triangles[0].frame = 77; });
  refused([](Scene& scene) { scene.fixed.light = {1, 2}; });
  const Renderer renderer({}, BusyScene());
  EXPECT_THROW(renderer.Render(TestCameras()[0], StillView({})), InternalError);
  EXPECT_THROW(renderer.Render(CameraModel(), BusyView({})), InternalError);
}

TEST(RenderOptions, ChecksItsFields) {
  const auto refused = [](const auto& change) { return RefusedField<RenderOptions>(change); };
  EXPECT_EQ(refused([](RenderOptions&) {}), "");
  EXPECT_EQ(refused([](RenderOptions& options) { options.edge_samples = 0; }), "render.edge_samples");
  EXPECT_EQ(refused([](RenderOptions& options) { options.blur_samples = 0; }), "render.blur_samples");
  EXPECT_EQ(refused([](RenderOptions& options) { options.threads = 0; }), "render.threads");
}

}  // namespace
}  // namespace turnscale
