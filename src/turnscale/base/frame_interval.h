// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

/// Longest usual time between two images of a drive, seconds. Where all are further apart, the times are in another
/// unit, such as milliseconds.
inline constexpr double kLongestFrameInterval = 10;
/// Highest plausible frame rate of a drive, images per second.
inline constexpr double kHighestFrameRate = 1000;

}  // namespace turnscale
