// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace turnscale {

/// Bounds of the parts that points or blocks are processed in: part i has bounds[i]...bounds[i + 1]. They follow from
/// their number alone, so that sums over parts are the same for any number of threads. `least`: what is worth the
/// handover to a thread.
std::vector<std::size_t> PartsOf(std::size_t count, std::size_t least = 50);

/// Calls `work` for each part with its number and its bounds, on as many threads as OpenCV is set to use.
void ForEachPart(const std::vector<std::size_t>& bounds,
                 const std::function<void(std::size_t part, std::size_t first, std::size_t last)>& work);

}  // namespace turnscale
