// SPDX-License-Identifier: MIT
#include <iostream>

#include <opencv2/core.hpp>
#include <turnscale/odometry/odometry.h>

int main() {
  turnscale::OdometryOptions options;
  options.vehicle.lever_arm = 1.0;
  turnscale::CameraModel camera;
  camera.pinhole = {300, 300, 159.5, 119.5};
  camera.width = 320;
  camera.height = 240;
  turnscale::Odometry odometry(options, camera);
  const turnscale::FrameResult result = odometry.Process(cv::Mat(240, 320, CV_8U, cv::Scalar(128)), 0.0);
  const bool has_pose = result.world_from_camera.has_value();
  std::cout << "a gray wall has " << (has_pose ? "a" : "no") << " pose\n";
  return has_pose ? 1 : 0;
}
