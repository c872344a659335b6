// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace turnscale {

/// Seconds per unit of the increasing times of a drive's poses or images: 1, unless they are beyond any clock's seconds
/// or too far apart for seconds. Then 1e-3, 1e-6 or 1e-9: the unit in which they are of this century and at most 10 s
/// apart, else the one in which they are closest to ten per second.
double SecondsPerUnit(const std::vector<double>& times);

/// The same times in seconds.
std::vector<double> InSeconds(std::vector<double> times);

}  // namespace turnscale
