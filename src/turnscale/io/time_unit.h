// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace turnscale {

/// Seconds per unit of the increasing times of a drive's poses or images: 1, unless they are beyond any clock's seconds
/// or more than 1000 s apart. Then the one of 1e-3, 1e-6 and 1e-9 in which they are between 0.5 ms and 1.5 s apart; if
/// several or none do that, the one in which they are of this century, or closest to ten per second. Milliseconds from
/// a start of zero cannot be told from seconds.
double SecondsPerUnit(const std::vector<double>& times);

/// The same times in seconds.
std::vector<double> InSeconds(std::vector<double> times);

/// Throws InputError where the median of the steps is above kLongestFrameInterval, as where times are milliseconds from
/// a start of zero: no camera drives with such images. `name` is that of the file.
void RefuseSparseTimes(const std::string& name, const std::vector<double>& seconds,
                       const std::string& remedy = "Give seconds");

/// Whether times that a format has in nanoseconds can be such: at most 10,000 per second.
bool AreNanoseconds(const std::vector<double>& times);

}  // namespace turnscale
