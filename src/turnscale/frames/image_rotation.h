// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

#include <opencv2/core/mat.hpp>

#include "turnscale/camera/camera_model.h"

namespace turnscale {

/// Throws InputError that names --rotate if this is not 0, 90, 180 or 270.
void CheckRotation(int degrees);

/// The image turned clockwise by 0, 90, 180 or 270 degrees; an empty one stays empty.
cv::Mat Rotated(const cv::Mat& image, int degrees);

/// The camera that took the rotated images, from the one that took the stored ones. `rotated`: size of the rotated
/// images, pixels.
CameraModel Rotated(CameraModel stored, int degrees, const cv::Size& rotated);

/// The read direction of images that are turned by a function, where that of the stored ones is downwards.
ReadDirection ReadDirectionAfter(const std::function<cv::Mat(const cv::Mat&)>& turned);

/// The read direction of the rotated images, from that of the others.
ReadDirection Rotated(const ReadDirection& read, int degrees);

}  // namespace turnscale
