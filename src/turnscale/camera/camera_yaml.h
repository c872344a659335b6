// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/camera/camera_model.h"
#include "turnscale/config/yaml_map.h"

namespace turnscale {

/// Camera of a YAML file in the dialect of Kalibr, OpenCV, ROS or ORB-SLAM. Throws InputError.
CameraModel CameraFromYaml(const YamlMap& file);

}  // namespace turnscale
