// SPDX-License-Identifier: MIT
#include "turnscale/simulation/rig.h"

#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/run/settings.h"

namespace turnscale {
namespace {

std::string Write(const std::string& text) {
  const std::string path = ScratchPath("rig.yaml");
  std::ofstream(path) << text;
  return path;
}

Rig Read(const std::string& text) { return ReadRig(Write(text)); }

std::string Complaint(const std::string& text) {
  try {
    Read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Rig, PresetsAreThoseOfThePaperAndOfKitti) {
  const Rig paper = MakeRig(RigPreset::kPaper);
  EXPECT_NO_THROW(paper.Check());
  EXPECT_EQ(paper.camera.width, 1032);
  EXPECT_EQ(paper.camera.height, 772);
  EXPECT_NEAR(2 * std::atan(516 / paper.camera.pinhole.fx) * kDegreesPerRadian, 80, 0.1);
  EXPECT_EQ(paper.rate_hz, 10);
  const Rig kitti = MakeRig(RigPreset::kKitti);
  EXPECT_NO_THROW(kitti.Check());
  EXPECT_EQ(kitti.camera.width, 1241);
  EXPECT_EQ(kitti.camera.height, 376);
  EXPECT_EQ(kitti.camera.pinhole.fx, 718.856);
  EXPECT_EQ(kitti.camera.pinhole.cx, 607.1928);
  EXPECT_EQ(kitti.camera.pinhole.cy, 185.2157);
}

TEST(Rig, DashcamIsThatOfItsDescription) {
  const Rig rig = MakeRig(RigPreset::kDashcam);
  EXPECT_NO_THROW(rig.Check());
  EXPECT_EQ(rig.preset, RigPreset::kDashcam);
  EXPECT_EQ(rig.camera.width, 1920);
  EXPECT_EQ(rig.camera.height, 1080);
  EXPECT_EQ(rig.rate_hz, 30);
  EXPECT_EQ(rig.camera.lens, LensModel::kEquidistant);
  const auto angle = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const Eigen::Vector3d first = rig.camera.pinhole.Ray(*rig.camera.Undistort(a)).normalized();
    const Eigen::Vector3d second = rig.camera.pinhole.Ray(*rig.camera.Undistort(b)).normalized();
    return std::acos(first.dot(second)) * kDegreesPerRadian;
  };
  EXPECT_NEAR(angle({-0.5, 533}, {1919.5, 533}), 120, 0.2);
  EXPECT_NEAR(angle({-0.5, -0.5}, {1919.5, 1079.5}), 138, 1);
  EXPECT_GT(rig.ImageShutter().readout, 0.01);
  EXPECT_GT(rig.windscreen.dashboard, 0.1);
  EXPECT_GT(rig.windscreen.reflection, 0);
  EXPECT_GT(rig.windscreen.defocus, 0);
  EXPECT_TRUE(rig.recorder.video);
  EXPECT_TRUE(rig.recorder.clock);
  EXPECT_GT(rig.recorder.stalls_per_minute, 0);
  EXPECT_GT(rig.recorder.stamp_jitter_ms, 0);
}

TEST(Rig, PresetsAreFoundByTheirNames) {
  EXPECT_EQ(FindRigPreset("paper"), RigPreset::kPaper);
  EXPECT_EQ(FindRigPreset("kitti"), RigPreset::kKitti);
  EXPECT_EQ(FindRigPreset("dashcam"), RigPreset::kDashcam);
  EXPECT_EQ(FindRigPreset("rig.yaml"), std::nullopt);
}

TEST(Rig, FileChangesWhatItNames) {
  const Rig rig = Read(
      "preset: kitti\nrate_hz: 20\ncamera:\n  lens: radtan\n  distortion: [-0.3, 0.1]\nmount:\n  lever_arm: 0.9\n"
      "sensor:\n  exposure_ms: 8\n  readout_ms: 20\nvehicle:\n  slip_deg_per_g: 0\n");
  EXPECT_EQ(rig.camera.pinhole.fx, 718.856);
  EXPECT_EQ(rig.camera.lens, LensModel::kRadialTangential);
  EXPECT_EQ(rig.camera.distortion, (std::array<double, 5>{-0.3, 0.1, 0, 0, 0}));
  EXPECT_EQ(rig.rate_hz, 20);
  EXPECT_EQ(rig.mount.lever_arm, 0.9);
  EXPECT_EQ(rig.vehicle.slip_deg_per_g, 0);
  EXPECT_DOUBLE_EQ(rig.ImageShutter().exposure, 0.008);
  EXPECT_DOUBLE_EQ(rig.ImageShutter().readout, 0.02);
  EXPECT_EQ(Read("mount:\n  height: 2\n").camera.width, 1032) << "the paper's unless it says otherwise";
  EXPECT_EQ(ReadRig(Write("mount:\n  height: 2\n"), RigPreset::kKitti).camera.width, 1241);
}

TEST(Rig, WrittenOnesReadBack) {
  for (const RigPreset preset : {RigPreset::kPaper, RigPreset::kKitti, RigPreset::kDashcam}) {
    Rig rig = MakeRig(preset);
    EXPECT_EQ(RigText(Read(RigText(rig))), RigText(rig));
    rig.camera.lens = LensModel::kEquidistant;
    rig.camera.distortion = {1.0 / 3, 0.2, 0, -1e-7, 0};
    rig.mount = {1.1, -0.2, 1.3, 0.5, -1, 0.25};
    rig.vehicle.wheelbase = 2.9;
    rig.sensor.read_noise = 3;
    rig.windscreen.defocus = 7;
    rig.recorder = {.video = false, .megabits_per_second = 3, .clock = true, .stalls_per_minute = 1.5};
    const Rig read = Read(RigText(rig));
    EXPECT_EQ(RigText(read), RigText(rig));
    EXPECT_EQ(read.camera.distortion, rig.camera.distortion);
    EXPECT_EQ(read.mount.yaw_deg, 0.5);
    EXPECT_EQ(read.vehicle.wheelbase, 2.9);
    EXPECT_EQ(read.sensor.read_noise, 3);
  }
}

TEST(Rig, CameraSitsWhereTheMountSays) {
  const CameraMount mount{1.5, 0.3, 1.4, 2, -3, 1};
  const RigidTransform vehicle_from_camera = mount.VehicleFromCamera();
  EXPECT_LT((vehicle_from_camera.translation - Eigen::Vector3d(0.3, -1.1, 1.5)).norm(), 1e-12);
  EXPECT_LT(vehicle_from_camera.rotation.angularDistance(ReadCameraRotation("2,-3,1")), 1e-12);
  const Eigen::Vector3d ahead = vehicle_from_camera.rotation * Eigen::Vector3d::UnitZ();
  EXPECT_GT(ahead.x(), 0) << "yaw to the right";
  EXPECT_GT(ahead.y(), 0) << "pitched down";
}

TEST(Rig, ComplaintsNameLineKeyAndNearestKey) {
  EXPECT_NE(Complaint("mount:\n  lever_arn: 1\n")
                .find("rig.yaml:2: mount.lever_arn: unknown key; did you mean 'mount.lever_arm'?"),
            std::string::npos);
  EXPECT_NE(Complaint("sensors:\n  blur: 1\n").find(":1: sensors: unknown key; did you mean 'sensor'?"),
            std::string::npos);
  EXPECT_NE(Complaint("lever_arm: 1\n").find(":1: lever_arm: unknown key; it belongs below 'mount'"),
            std::string::npos);
  EXPECT_NE(Complaint("preset: kiti\n").find(":1: preset: is 'kiti'; give paper or kitti or dashcam"),
            std::string::npos);
  EXPECT_NE(Complaint("mount:\n  lever_arm: -1\n").find("rig.yaml:2: mount.lever_arm: is -1;"), std::string::npos);
  EXPECT_NE(Complaint("camera:\n  width: 3\n").find("rig.yaml:2: camera.width: is 3;"), std::string::npos);
  EXPECT_NE(Complaint("camera:\n  distortion: [0.1]\n").find("lens: radtan"), std::string::npos);
  EXPECT_NE(Complaint("camera:\n  distortion: [1,2,3,4,5,6]\n").find("holds 6 numbers"), std::string::npos);
  EXPECT_NE(Complaint("sensor:\n  exposure_ms: 150\n").find("longer than the 100 ms of a frame"), std::string::npos);
  EXPECT_NE(Complaint("windscreen:\n  dashboard: 2\n").find("rig.yaml:2: windscreen.dashboard: is 2;"),
            std::string::npos);
  EXPECT_NE(Complaint("recorder:\n  stalled_frames: 0\n").find("recorder.stalled_frames: is 0"), std::string::npos);
  EXPECT_NE(Complaint("preset: kitti\nrecorder:\n  video: true\n").find("even numbers of pixels, not 1241x376"),
            std::string::npos);
  EXPECT_NE(Complaint("rate_hz: 0\n").find("rate_hz"), std::string::npos);
  EXPECT_NE(Complaint("vehicle:\n  wheelbase: -1\n").find("vehicle.wheelbase"), std::string::npos);
}

TEST(Rig, CamerasThatMakeNoSense) {
  EXPECT_NE(
      Complaint("camera: {width: 516, height: 386}\n").find("rig.yaml: camera.cx: is 515.5; it has to be in 0...515"),
      std::string::npos)
      << "a crop whose principal point lies at its edge";
  EXPECT_NE(Complaint("camera: {cx: 5155}\n").find("camera.cx: is 5155"), std::string::npos);
  EXPECT_NE(Complaint("camera: {cy: -1}\n").find("camera.cy: is -1"), std::string::npos);
  EXPECT_NE(Complaint("camera: {fx: 1e-3}\n").find("camera.fx: is 0.001"), std::string::npos);
  EXPECT_NE(Complaint("camera: {fy: 1e6}\n").find("camera.fy: is 1000000"), std::string::npos);
  EXPECT_NE(Complaint("camera: {lens: radtan, distortion: [-2]}\n").find("camera.distortion: cannot be inverted at"),
            std::string::npos);
  EXPECT_NE(Complaint("camera: {lens: equidistant, distortion: [-1]}\n").find("camera.distortion: cannot be inverted"),
            std::string::npos);
  EXPECT_EQ(Complaint("camera: {lens: equidistant, distortion: [-0.01, 0.007]}\n"), "no error");
}

}  // namespace
}  // namespace turnscale
