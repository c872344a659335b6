// SPDX-License-Identifier: MIT
#include "turnscale/camera/camera_file.h"

#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

std::string Write(const std::string& text) {
  const std::string path = ScratchPath("camera_file_test.file");
  std::ofstream(path) << text;
  return path;
}

CameraModel Read(const std::string& text) { return ReadCameraFile(Write(text)); }

std::string Complaint(const std::string& text) {
  try {
    Read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

constexpr auto kKalibrWithReadout = R"(cam0:
  camera_model: pinhole
  intrinsics: [458, 457, 367, 248]
  distortion_model: none
  resolution: [752, 480]
)";

constexpr auto kKitti = "P0: 7.2e+02 0.0 6.1e+02 0.0 0.0 7.1e+02 1.7e+02 0.0 0.0 0.0 1.0 0.0\nP1: 1 2 3\n";

const std::string kOrbSlam2 = R"(%YAML:1.0
# a comment
Camera.fx: 458.654
Camera.fy: 457.296
Camera.cx: 367.215
Camera.cy: 248.375
Camera.k1: -0.28
Camera.k2: 0.07
Camera.p1: 0.0002
Camera.p2: 0.00002
Camera.fps: 20.0
Camera.RGB: 1
ORBextractor.nFeatures: 1000
Viewer.PointSize: 2
)";

const std::string kOrbSlam3 = R"(%YAML:1.0
File.version: "1.0"
Camera.type: "KannalaBrandt8"
Camera1.fx: 190.9
Camera1.fy: 190.8
Camera1.cx: 254.9
Camera1.cy: 256.8
Camera1.k1: 0.0034
Camera1.k2: 0.0007
Camera1.k3: -0.002
Camera1.k4: 0.0002
Camera.width: 512
Camera.height: 510
IMU.T_b_c1: !!opencv-matrix
   rows: 1
   cols: 2
   dt: f
   data: [1.0, 0.0]
)";

const std::string kOpenCv = R"(%YAML:1.0
---
calibration_time: "Thu"
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 500., 0., 320., 0., 501., 240., 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -0.3, 0.1, 0.001, 0.002, -0.01 ]
)";

const std::string kKalibr = R"(cam0:
  camera_model: pinhole
  intrinsics: [461.6, 460.3, 362.7, 248.1]
  distortion_model: radtan
  distortion_coeffs: [-0.27, 0.06, 0.001, 0.0002]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  camera_model: omni
)";

TEST(CameraFile, ReadsKitti) {
  const CameraModel camera = Read(kKitti);
  EXPECT_EQ(camera.pinhole.fx, 720);
  EXPECT_EQ(camera.pinhole.fy, 710);
  EXPECT_EQ(camera.pinhole.cx, 610);
  EXPECT_EQ(camera.pinhole.cy, 170);
  EXPECT_EQ(camera.lens, LensModel::kPinhole);
  EXPECT_EQ(camera.width, 0);
}

TEST(CameraFile, ReadsOrbSlam2) {
  const CameraModel camera = Read(kOrbSlam2);
  EXPECT_EQ(camera.pinhole.fy, 457.296);
  EXPECT_EQ(camera.lens, LensModel::kRadialTangential);
  EXPECT_EQ(camera.distortion, (std::array<double, 5>{-0.28, 0.07, 0.0002, 0.00002, 0}));
  EXPECT_EQ(Read(Replaced(Replaced(kOrbSlam2, "k1: -0.28", "k1: 0"), "k2: 0.07\nCamera.p1: 0.0002\nCamera.p2: 0.00002",
                          "k2: 0"))
                .lens,
            LensModel::kPinhole);
}

TEST(CameraFile, ReadsOrbSlam3Fisheye) {
  const CameraModel camera = Read(kOrbSlam3);
  EXPECT_EQ(camera.pinhole.cx, 254.9);
  EXPECT_EQ(camera.lens, LensModel::kEquidistant);
  EXPECT_EQ(camera.distortion, (std::array<double, 5>{0.0034, 0.0007, -0.002, 0.0002, 0}));
  EXPECT_EQ(camera.width, 512);
  EXPECT_EQ(camera.height, 510);
}

TEST(CameraFile, ReadsOpenCvAndRos) {
  const CameraModel camera = Read(kOpenCv);
  EXPECT_EQ(camera.pinhole.fy, 501);
  EXPECT_EQ(camera.pinhole.cy, 240);
  EXPECT_EQ(camera.distortion, (std::array<double, 5>{-0.3, 0.1, 0.001, 0.002, -0.01}));
  EXPECT_EQ(camera.height, 480);
  const CameraModel ros = Read(
      "image_width: 640\nimage_height: 480\ncamera_name: front\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: [500, 0, 320, 0, 500, 240, 0, 0, 1]\ndistortion_model: equidistant\ndistortion_coefficients:\n"
      "  rows: 1\n  cols: 4\n  data: [0.1, 0.2, 0.3, 0.4]\n");
  EXPECT_EQ(ros.lens, LensModel::kEquidistant);
  EXPECT_EQ(ros.distortion[3], 0.4);
}

TEST(CameraFile, ReadsKalibr) {
  const CameraModel camera = Read(kKalibr);
  EXPECT_EQ(camera.pinhole.fy, 460.3);
  EXPECT_EQ(camera.lens, LensModel::kRadialTangential);
  EXPECT_EQ(camera.distortion[3], 0.0002);
  EXPECT_EQ(camera.width, 752);
  EXPECT_EQ(Read(Replaced(kKalibr, "radtan", "equidistant")).lens, LensModel::kEquidistant);
  EXPECT_EQ(Read(Replaced(kKalibr, "radtan", "none")).lens, LensModel::kPinhole);
}

struct Mistake {
  std::string text;
  std::string complaint;
};

TEST(CameraFile, ComplaintsNameKeyValueAndRemedy) {
  const std::string kitti = kKitti;
  const Mistake mistakes[] = {
      {Replaced(kitti, "P0: 7.2e+02", "P0: nan"), ":1: P0: 'nan' at position 1"},
      {Replaced(kitti, "P0: 7.2e+02", "P0: -7.2e+02"), ":1: P0: focal length -7.2e+02 x 7.1e+02 is not above 0"},
      {"P0: 1 2 3\n", "P0 has 3 numbers"},
      {"P1: 1 2 3\n", "P0 is missing"},
      {Replaced(kitti, "0.0 6.1", "0.5 6.1"), "skewed"},
      {Replaced(kOrbSlam2, "458.654", ".nan"), ":3: Camera.fx: is '.nan'"},
      {Replaced(kOrbSlam2, "458.654", "-458.654"), "Camera.fx: is -458.654; give a number above 0"},
      {Replaced(kOrbSlam2, "Camera.fy: 457.296\n", ""), "Camera.fy: is missing"},
      {Replaced(kOrbSlam2, "Camera.p1", "Camera.q1"), ":9: Camera.q1: unknown key; did you mean 'Camera."},
      {Replaced(kOrbSlam2, "Camera.fps", "Camera.fsp"), "did you mean 'Camera.fps'?"},
      {Replaced(kOrbSlam3, "KannalaBrandt8", "Scaramuzza"), "Camera.type: 'Scaramuzza' is not supported"},
      {Replaced(kOrbSlam3, "Camera1.k4: 0.0002\n", ""), "Camera1.k4: is missing"},
      {Replaced(kOrbSlam3, "width: 512", "width: 0"), "Camera.width: is 0"},
      {Replaced(kOrbSlam3, "Camera.width: 512\n", ""), "Camera.width: is missing; give it as well as Camera.height"},
      {Replaced(kOrbSlam3, "Camera.height: 510\n", ""), "Camera.height: is missing; give it as well as Camera.width"},
      {Replaced(kOpenCv, "image_width: 640\n", ""), "image_width: is missing; give it as well as image_height"},
      {Replaced(kOpenCv, "image_height: 480\n", ""), "image_height: is missing; give it as well as image_width"},
      {Replaced(kOpenCv, "501.", ".nan"), "camera_matrix.data: has '.nan' at position 5"},
      {Replaced(kOpenCv, "501.", "-501."), "camera_matrix: focal length 500 x -501"},
      {Replaced(kOpenCv, "image_width", "image_with"), "image_with: unknown key; did you mean 'image_width'?"},
      {Replaced(kOpenCv, "-0.01 ]", "-0.01, 0.5, 0, 0 ]"), "holds 8 numbers"},
      {Replaced(kKalibr, "pinhole", "ds"), ":2: cam0.camera_model: 'ds' is not supported"},
      {Replaced(kKalibr, "radtan", "fov"), "'fov' is not supported"},
      {Replaced(kKalibr, "461.6, ", ""), "cam0.intrinsics: holds 3 numbers"},
      {Replaced(kKalibr, "  intrinsics", "  intrinsic"), "did you mean 'cam0.intrinsics'?"},
      {Replaced(kKalibr, "[752, 480]", "[752]"), "cam0.resolution"},
      {Replaced(kKalibr, "[752, 480]", "[752.7, 480]"), "cam0.resolution: give [width, height] in whole pixels"},
      {Replaced(kKalibr, "[752, 480]", "[752, 1e12]"), "cam0.resolution: give [width, height] in whole pixels"},
      {"camera_matrx: 3\n", "did you mean 'camera_matrix'?"},
      {"just words\n", "has no keys"},
  };
  for (const Mistake& mistake : mistakes) {
    const std::string complaint = Complaint(mistake.text);
    EXPECT_NE(complaint.find(mistake.complaint), std::string::npos) << complaint << "\nwanted: " << mistake.complaint;
    EXPECT_NE(complaint.find("camera_file_test.file"), std::string::npos) << complaint;
    EXPECT_EQ(complaint.find('\n'), std::string::npos) << complaint;
  }
}

TEST(CameraFile, MissingFileAndFolder) {
  EXPECT_THROW(ReadCameraFile("/nonexistent/calib.txt"), InputError);
  EXPECT_THROW(ReadCameraFile(::testing::TempDir()), InputError);
}

TEST(CameraFile, WhatIsWrittenReadsBackToTheSameBits) {
  CameraModel camera;
  camera.pinhole = {718.856, 700.0 / 3, 607.1928, 185.2157};
  camera.width = 1241;
  camera.height = 376;
  const auto expect_same = [&] {
    const CameraModel read = Read(CameraFileText(camera));
    EXPECT_EQ(read.pinhole.fx, camera.pinhole.fx);
    EXPECT_EQ(read.pinhole.fy, camera.pinhole.fy);
    EXPECT_EQ(read.pinhole.cx, camera.pinhole.cx);
    EXPECT_EQ(read.pinhole.cy, camera.pinhole.cy);
    EXPECT_EQ(read.lens, camera.lens);
    EXPECT_EQ(read.distortion, camera.distortion);
    EXPECT_EQ(read.width, camera.width);
    EXPECT_EQ(read.height, camera.height);
    EXPECT_EQ(read.focal_sigma, camera.focal_sigma);
    EXPECT_EQ(read.aspect_sigma, camera.aspect_sigma);
    EXPECT_NEAR(read.readout, camera.readout, 1e-15);
    EXPECT_NEAR(read.readout_sigma, camera.readout_sigma, 1e-15);
    EXPECT_EQ(read.read_direction, camera.read_direction);
  };
  expect_same();
  camera.focal_sigma = 20.0 / 3;
  camera.aspect_sigma = 0.1 / 3;
  camera.lens = LensModel::kRadialTangential;
  camera.distortion = {-0.3, 0.1, 1e-4, -2e-4, 1.0 / 30};
  expect_same();
  camera.lens = LensModel::kEquidistant;
  camera.distortion = {-0.01, 0.002, 0, 1e-5, 0};
  expect_same();
  for (const ReadDirection& direction : {ReadDirection{0, 1}, {0, -1}, {1, 0}, {-1, 0}}) {
    camera.readout = 0.02 / 3;
    camera.readout_sigma = 0.001 / 3;
    camera.read_direction = direction;
    expect_same();
  }
  camera.readout = -0.02;
  expect_same();
  camera.readout = 0;
  expect_same();
}

// Of images that were rotated by a quarter, the usual direction is not that of the stored rows.
TEST(CameraFile, ADirectionIsStatedWithEachReadout) {
  CameraModel camera{.pinhole = {600, 600, 320, 180}, .width = 640, .height = 360};
  EXPECT_FALSE(Read(CameraFileText(camera)).is_read_direction_stated);
  camera.readout = 0.02;
  EXPECT_NE(CameraFileText(camera).find("readout_direction: down\n"), std::string::npos);
  EXPECT_TRUE(Read(CameraFileText(camera)).is_read_direction_stated);
}

TEST(CameraFile, AReadoutMayBeGivenByHand) {
  const std::string opencv = CameraFileText({.pinhole = {600, 600, 320, 180}, .width = 640, .height = 360});
  EXPECT_EQ(opencv.find("readout"), std::string::npos) << "of a camera without";
  EXPECT_EQ(Read(opencv).readout, 0);
  EXPECT_EQ(Read(opencv).readout_sigma, 0) << "not known";
  EXPECT_NEAR(Read(opencv + "readout_ms: 0\n").readout_sigma, 0.0005, 1e-15) << "a global shutter";
  EXPECT_GT(Read(opencv + "readout_ms: 0\nreadout_sigma_ms: 0\n").readout_sigma, 0);
  for (const std::string& text : {opencv, std::string(kKalibrWithReadout)}) {
    const std::string indent = text == opencv ? "" : "  ";
    std::string with_readout = text;
    with_readout.append(indent).append("readout_ms: 21\n");
    const CameraModel camera = Read(with_readout);
    with_readout.append(indent);
    EXPECT_NEAR(camera.readout, 0.021, 1e-15);
    EXPECT_NEAR(camera.readout_sigma, 0.0005, 1e-15) << "if it is not stated";
    EXPECT_EQ(camera.read_direction, ReadDirection());
    EXPECT_FALSE(camera.is_read_direction_stated);
    EXPECT_EQ(Read(with_readout + "readout_direction: left\n").read_direction, (ReadDirection{-1, 0}));
    EXPECT_EQ(Read(with_readout + "readout_sigma_ms: 0\n").readout_sigma, 0);
  }
  const auto complaint = [&](const std::string& lines) { return Complaint(opencv + lines); };
  EXPECT_NE(complaint("readout_ms: 21\nreadout_direction: sideways\n").find("down, up, right or left"),
            std::string::npos);
  EXPECT_NE(complaint("readout_ms: 21000\n").find("readout_ms"), std::string::npos) << "microseconds";
  EXPECT_NE(complaint("readout_ms: 21\nreadout_sigma_ms: -1\n").find("readout_sigma_ms"), std::string::npos);
  EXPECT_NE(complaint("readout_direction: left\n").find("needs readout_ms"), std::string::npos);
}

TEST(CameraFile, TheLineDelayOfKalibrIsAReadout) {
  const std::string kalibr = kKalibrWithReadout;
  const int height = Read(kalibr).height;
  const int width = Read(kalibr).width;
  EXPECT_NEAR(Read(kalibr + "  line_delay: 3.0e-05\n").readout, 3e-5 * height, 1e-12);
  EXPECT_NEAR(Read(kalibr + "  line_delay: 3.0e-05\n  readout_ms: 21\n").readout, 0.021, 1e-15);
  EXPECT_NEAR(Read(kalibr + "  line_delay: 3.0e-05\n  readout_direction: left\n").readout, 3e-5 * width, 1e-12);
  EXPECT_NE(Complaint(kalibr + "  line_delay: 30\n").find("line_delay"), std::string::npos) << "microseconds";
}

TEST(CameraFile, KittiCalibrationReadsBackToTheSameBits) {
  const CameraModel read = Read(KittiCalibrationText({718.856, 700.0 / 3, 607.1928, 185.2157}));
  EXPECT_EQ(read.pinhole.fx, 718.856);
  EXPECT_EQ(read.pinhole.fy, 700.0 / 3);
  EXPECT_EQ(read.pinhole.cx, 607.1928);
  EXPECT_EQ(read.pinhole.cy, 185.2157);
  EXPECT_EQ(read.lens, LensModel::kPinhole);
}

TEST(CameraFile, ACarsFileIsNamedAsOne) {
  for (const char* car : {"# A car\nyaw_deg: 1\npitch_deg: 0\nroll_deg: 0\n", "# A car\nlever_arm: 1.45\n"})
    EXPECT_NE(Complaint(car).find("is of a car's file, which --vehicle takes; give --camera a camera's"),
              std::string::npos)
        << Complaint(car);
  EXPECT_NE(Complaint("vehicle:\n  lever_arm: 1.45\n").find("is of a file of settings, which --settings takes"),
            std::string::npos);
  // As rostopic prints a CameraInfo.
  EXPECT_EQ(Complaint("height: 480\nwidth: 640\nK: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n").find("of a car's file"),
            std::string::npos);
}

TEST(CameraFile, MayBeginWithAByteOrderMark) {
  EXPECT_EQ(Read(std::string("\xEF\xBB\xBF") + kKitti).pinhole.fx, 720);
  EXPECT_EQ(Read("\xEF\xBB\xBF" + kOrbSlam2).pinhole.fx, 458.654);
}

TEST(CameraFile, InUtf16IsNamedSo) {
  std::string wide = "\xFF\xFE";
  for (const char c : std::string(kKitti)) wide += {c, '\0'};
  EXPECT_NE(Complaint(wide).find("is text in UTF-16; save it as UTF-8"), std::string::npos);
}

TEST(CameraFile, FourCoefficientsThatMayBeOfAFisheyeAreDoubted) {
  const auto doubt_of = [](const std::string& text) { return DoubtOfLens(Write(text)); };
  const auto with_last = [](const std::string& last) {
    return Replaced(Replaced(kOpenCv, "rows: 5", "rows: 4"), "0.001, 0.002, -0.01", last);
  };
  EXPECT_EQ(doubt_of(kKitti), "");
  EXPECT_EQ(doubt_of(kOrbSlam3), "");
  EXPECT_EQ(doubt_of(kKalibr), "");
  EXPECT_EQ(doubt_of(kOpenCv), "");
  EXPECT_EQ(doubt_of(with_last("0.001, -0.015")), "");
  const std::string doubt = doubt_of(with_last("0.001, -0.03"));
  EXPECT_NE(doubt.find(": distortion_coefficients are read as k1 k2 p1 p2, but p1 = 0.001 and p2 = -0.03 are unusually "
                       "large; if they are of a fisheye lens, add distortion_model: equidistant"),
            std::string::npos)
      << doubt;
  EXPECT_NE(doubt_of(with_last("0.03, 0")), "");
  EXPECT_EQ(doubt_of(with_last("0.03, 0") + "distortion_model: plumb_bob\n"), "");
  EXPECT_EQ(doubt_of(with_last("0.03, 0") + "fisheye_model: 1\n"), "");
  EXPECT_EQ(doubt_of(Replaced(kOpenCv, "0.001, 0.002", "0.03, 0.03")), "") << "a fisheye has no fifth one";
}

}  // namespace
}  // namespace turnscale
