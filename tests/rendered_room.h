// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

#include "turnscale/geometry/pinhole.h"
#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Image size and camera of the rendered drives.
constexpr int kRoomWidth = 320;
constexpr int kRoomHeight = 240;
constexpr Pinhole kRoomPinhole = {200, 200, 159.5, 119.5};

/// What the camera sees in a square hall of 40 m with patterned floor, ceiling and walls.
cv::Mat RenderRoom(const RigidTransform& world_from_camera);

/// Writes `frames` images of a drive through the hall (ahead, then to the right), 10 frames a second, as a KITTI
/// folder.
void WriteRoomDrive(const std::filesystem::path& folder, int frames);

}  // namespace turnscale
