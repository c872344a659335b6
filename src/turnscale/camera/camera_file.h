// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "turnscale/camera/camera_model.h"

namespace turnscale {

/// Reads a camera's calibration; the kind of file is found from its contents: KITTI `calib.txt` (its P0), ORB-SLAM2 and
/// ORB-SLAM3 settings, OpenCV and ROS camera YAML, Kalibr camchain YAML (its cam0).
/// Throws InputError that names file, key and value where the camera is incomplete, makes no sense, or has a lens that
/// CameraModel does not know.
CameraModel ReadCameraFile(const std::filesystem::path& path);

}  // namespace turnscale
