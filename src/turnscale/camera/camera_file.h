// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "turnscale/camera/camera_model.h"
#include "turnscale/config/yaml_map.h"

namespace turnscale {

/// Reads a camera's calibration; the kind of file is found from its contents: KITTI `calib.txt` (its P0), ORB-SLAM2 and
/// ORB-SLAM3 settings, OpenCV and ROS camera YAML, Kalibr camchain YAML (its cam0).
/// Throws InputError that names file, key and value where the camera is incomplete, makes no sense, or has a lens that
/// CameraModel does not know.
CameraModel ReadCameraFile(const std::filesystem::path& path);

/// One line where the lens of a camera file is uncertain: an OpenCV file with four coefficients and without
/// `distortion_model`, of which the third or fourth is larger than tangential distortion is, as a fisheye's may be.
/// Else empty. Throws as ReadCameraFile.
std::string DoubtOfLens(const std::filesystem::path& path);

/// Throws InputError where a file that is to be of another kind is a camera's: a run writes several kinds side by side.
/// `wanted`: what to give instead.
void RefuseCameraFile(const YamlMap& file, const std::string& wanted = "a car's file here, such as car.yaml");

/// The calibration as YAML of ROS's camera_info, which OpenCV reads too and ReadCameraFile gives back to the same bits.
/// `focal_length_sigma` (pixels), `pixel_aspect_sigma` and the readout of a rolling shutter are added where the camera
/// has them; the readout in milliseconds, to rounding.
std::string CameraFileText(const CameraModel& camera);

/// The word for it in a camera file: down, up, right or left.
std::string ReadDirectionName(const ReadDirection& direction);

/// KITTI's `calib.txt`: the camera stands for all four. Only for a camera whose lens has no distortion, which the file
/// has no room for.
std::string KittiCalibrationText(const Pinhole& pinhole);

}  // namespace turnscale
