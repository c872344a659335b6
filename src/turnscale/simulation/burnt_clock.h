// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <opencv2/core.hpp>

namespace turnscale {

/// Date and time of day that a dashcam shows this many seconds after the start of a drive: whole seconds. All simulated
/// drives start at the same time.
std::string ClockText(double seconds);

/// Burns the clock into the upper left of an 8-bit gray image, where there is scene behind it: white, outlined in
/// black, its letters 1/36 of the image's height.
void BurnClock(double seconds, cv::Mat& image);

}  // namespace turnscale
