// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

constexpr double Square(double value) { return value * value; }

}  // namespace turnscale
