// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace turnscale {

/// Bounds of the parts that points are processed in: part i has points bounds[i]...bounds[i + 1]. They follow from the
/// number of points alone, so that sums over parts are the same for any number of threads.
std::vector<std::size_t> PointParts(std::size_t points);

/// Calls `work` for each part with its number and its bounds, on as many threads as OpenCV is set to use.
void ForEachPointPart(const std::vector<std::size_t>& bounds,
                      const std::function<void(std::size_t part, std::size_t first, std::size_t last)>& work);

}  // namespace turnscale
