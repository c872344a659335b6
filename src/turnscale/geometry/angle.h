// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

constexpr double kDegreesPerRadian = 57.295779513082320877;
constexpr double InDegrees(double radians) { return radians * kDegreesPerRadian; }

}  // namespace turnscale
