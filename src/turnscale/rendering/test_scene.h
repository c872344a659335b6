// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/rendering/renderer.h"

namespace turnscale {

/// Materials of the tests' scenes.
enum TestMaterial { kWhite, kBlack, kShining, kMirror, kChecker };

/// Size of the checkerboard's fields, metres.
inline constexpr double kField = 0.5;

/// A scene with nothing in it but these materials. Light comes from everywhere.
inline Scene EmptyScene() {
  Scene scene;
  cv::Mat checker(512, 512, CV_32F, cv::Scalar(0));
  checker(cv::Rect(0, 0, 256, 256)) = 1;
  checker(cv::Rect(256, 256, 256, 256)) = 1;
  scene.patterns.push_back({[] { return cv::Mat(1, 1, CV_32F, cv::Scalar(1)); }, 1});
  scene.patterns.push_back({[checker] { return checker; }, 2 * kField});
  scene.materials = {{0, 1, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 1}, {0, 0, 1, 0}, {1, 1, 0, 0}};
  scene.ambient = 1;
  return scene;
}

/// Camera matrix and size of KITTI-like images, and lenses that bend a lot.
inline std::vector<CameraModel> TestCameras() {
  CameraModel pinhole;
  pinhole.pinhole = {420, 415, 309.3, 251.8};
  pinhole.width = 640;
  pinhole.height = 480;
  CameraModel barrel = pinhole;
  barrel.lens = LensModel::kRadialTangential;
  barrel.distortion = {-0.28340811, 0.07395907, 0.00219359, -0.00176187, 0};
  CameraModel fisheye = pinhole;
  fisheye.lens = LensModel::kEquidistant;
  fisheye.distortion = {-0.0134, 0.0071, -0.0020, 0.00020, 0};
  fisheye.pinhole.fx = 290;
  fisheye.pinhole.fy = 288;
  return {pinhole, barrel, fisheye};
}

/// A camera that stands still.
inline View StillView(const RigidTransform& world_from_camera) {
  View view;
  view.world_from_camera = [world_from_camera](double) { return world_from_camera; };
  return view;
}

/// A small shining square.
struct Mark {
  Eigen::Vector3d centre;
  Eigen::Vector3d u;  ///< its sides
  Eigen::Vector3d v;
};

/// A mark around a point that faces `from`.
inline Mark MarkAt(const Eigen::Vector3d& at, const Eigen::Vector3d& from, double side) {
  const Eigen::Vector3d towards = (from - at).normalized();
  const Eigen::Vector3d u = side * towards.unitOrthogonal();
  return {at, u, towards.cross(u)};
}

inline void AddMark(const Mark& mark, Mesh& mesh) {
  AddRectangle({kShining, 10, {0, 0}}, mark.centre - 0.5 * (mark.u + mark.v), mark.u, mark.v, mesh);
}

/// Centre of the area that a mark fills in an image. It is not quite where its centre is: what is nearer to the image's
/// corners is drawn larger, or smaller.
template <typename Project>
Eigen::Vector2d CentreOfArea(const Mark& mark, const Project& project) {
  constexpr int kCells = 8;
  const auto corner = [&](int i, int j) -> Eigen::Vector2d {
    return project(mark.centre + (static_cast<double>(i) / kCells - 0.5) * mark.u +
                   (static_cast<double>(j) / kCells - 0.5) * mark.v);
  };
  double area = 0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  const auto add = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    const double twice = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
    area += twice;
    moment += twice * (a + b + c) / 3;
  };
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      add(corner(i, j), corner(i + 1, j), corner(i + 1, j + 1));
      add(corner(i, j), corner(i + 1, j + 1), corner(i, j + 1));
    }
  }
  return moment / area;
}

/// Centre of the brightness around a pixel.
inline Eigen::Vector2d CentreOfLight(const cv::Mat& image, const Eigen::Vector2d& near, int reach) {
  double sum = 0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  const int middle_row = static_cast<int>(std::lround(near.y()));
  const int middle_column = static_cast<int>(std::lround(near.x()));
  for (int row = std::max(0, middle_row - reach); row <= std::min(image.rows - 1, middle_row + reach); ++row) {
    for (int column = std::max(0, middle_column - reach); column <= std::min(image.cols - 1, middle_column + reach);
         ++column) {
      const double light = image.at<float>(row, column);
      sum += light;
      moment += light * Eigen::Vector2d(column, row);
    }
  }
  return moment / sum;
}

}  // namespace turnscale
