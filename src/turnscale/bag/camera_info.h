// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "turnscale/bag/messages.h"
#include "turnscale/camera/camera_model.h"

namespace turnscale {

/// The topic of the camera info that belongs to a topic of images: by ROS's convention it lies beside it.
std::string CameraInfoTopic(std::string_view image_topic);

/// Whether the images of the topic are rectified, by ROS's convention for its name (image_rect, image_rect_color).
bool IsRectified(std::string_view image_topic);

/// The camera of images as recorded, or of rectified ones; nothing where the camera is not calibrated (all zero).
/// Throws InputError, which begins with `where`, for a lens that CameraModel does not know, or for a part of an image.
std::optional<CameraModel> CameraOf(const BagCameraInfo& info, bool rectified, const std::string& where);

}  // namespace turnscale
