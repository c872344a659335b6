// SPDX-License-Identifier: MIT
#include "turnscale/bag/camera_info.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

BagCameraInfo InfoOf(const std::string& model, const std::vector<double>& d) {
  BagCameraInfo info;
  info.width = 64;
  info.height = 48;
  info.distortion_model = model;
  info.d = d;
  info.k = {50, 0, 31.5, 0, 51, 23.5, 0, 0, 1};
  info.p = {40, 0, 30, 0, 0, 41, 22, 0, 0, 0, 1, 0};
  return info;
}

std::string InfoComplaint(const std::function<void(BagCameraInfo&)>& change) {
  BagCameraInfo info = InfoOf("plumb_bob", {0.1, 0, 0, 0, 0});
  change(info);
  try {
    CameraOf(info, false, "a.bag: /camera_info");
  } catch (const InputError& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("a.bag: /camera_info: ")) << error.what();
    EXPECT_TRUE(std::string(error.what()).ends_with("; give --camera FILE")) << error.what();
    return error.what();
  }
  return "no error";
}

TEST(CameraInfo, LiesBesideTheImages) {
  EXPECT_EQ(CameraInfoTopic("/camera/image_raw"), "/camera/camera_info");
  EXPECT_EQ(CameraInfoTopic("/camera/image_raw/compressed"), "/camera/camera_info");
  EXPECT_EQ(CameraInfoTopic("/image"), "/camera_info");
  EXPECT_EQ(CameraInfoTopic("image"), "camera_info");
  EXPECT_FALSE(IsRectified("/camera/image_raw"));
  EXPECT_TRUE(IsRectified("/camera/image_rect_color/compressed"));
}

TEST(CameraInfo, LensModels) {
  const CameraModel radial = CameraOf(InfoOf("plumb_bob", {-0.3, 0.1, 0.001, 0.002, 0.01}), false, "").value();
  EXPECT_EQ(radial.lens, LensModel::kRadialTangential);
  EXPECT_EQ(radial.distortion[4], 0.01);
  EXPECT_EQ(radial.pinhole.fx, 50);
  EXPECT_EQ(radial.pinhole.cy, 23.5);
  EXPECT_EQ(radial.width, 64);
  EXPECT_EQ(CameraOf(InfoOf("rational_polynomial", {-0.3, 0.1, 0, 0, 0.01, 0, 0, 0}), false, "")->lens,
            LensModel::kRadialTangential);
  EXPECT_EQ(CameraOf(InfoOf("equidistant", {0, 0, 0, 0}), false, "")->lens, LensModel::kEquidistant);
  EXPECT_EQ(CameraOf(InfoOf("", {}), false, "")->lens, LensModel::kPinhole);
  EXPECT_EQ(CameraOf(InfoOf("plumb_bob", {0, 0, 0, 0, 0}), false, "")->lens, LensModel::kPinhole);
}

TEST(CameraInfo, RectifiedImagesHaveTheProjection) {
  const CameraModel camera = CameraOf(InfoOf("plumb_bob", {-0.3, 0.1, 0, 0, 0}), true, "").value();
  EXPECT_EQ(camera.lens, LensModel::kPinhole);
  EXPECT_EQ(camera.pinhole.fx, 40);
  EXPECT_EQ(camera.pinhole.cy, 22);
}

TEST(CameraInfo, ACameraWithoutCalibrationIsNone) {
  BagCameraInfo info = InfoOf("", {});
  info.k.fill(0);
  EXPECT_FALSE(CameraOf(info, false, "").has_value());
}

TEST(CameraInfo, WhatCannotBeUsedIsNamed) {
  const auto holds = [](const std::function<void(BagCameraInfo&)>& change, const std::string& part) {
    const std::string complaint = InfoComplaint(change);
    EXPECT_NE(complaint.find(part), std::string::npos) << complaint;
  };
  holds([](auto& info) { info.distortion_model = "thin_prism"; }, "'thin_prism' is not supported");
  holds([](auto& info) { info.distortion_model = "thin\nprism"; }, "'thin\\x0aprism' is not supported");
  holds([](auto& info) { info.d = {0.1, 0, 0, 0, 0, 0.2, 0, 0}; }, "more than k1 k2 p1 p2 k3");
  holds([](auto& info) { info.distortion_model = "equidistant"; }, "equidistant has 4 coefficients, not 5");
  holds([](auto& info) { info.d = {1}; }, "5 coefficients, not 1");
  holds([](auto& info) { info.k[0] = -1; }, "focal length");
  holds([](auto& info) { info.k[1] = 0.1; }, "not of the form");
  holds([](auto& info) { info.k[2] = std::nan(""); }, "not a finite number");
  holds([](auto& info) { info.binning_x = 2; }, "binning");
  holds([](auto& info) { info.roi = {8, 0, 40, 40}; }, "region of interest");
  holds([](auto& info) { info.roi = {0, 0, 48, 64}; }, "no error");
}

}  // namespace
}  // namespace turnscale
