// SPDX-License-Identifier: MIT
#include "turnscale/bundle/parts.h"

#include <algorithm>

#include <opencv2/core/utility.hpp>

namespace turnscale {

std::vector<std::size_t> PartsOf(std::size_t count, std::size_t least) {
  constexpr std::size_t kMostParts = 4;
  const std::size_t parts = std::clamp(count / least, std::size_t{1}, kMostParts);
  std::vector<std::size_t> bounds;
  for (std::size_t i = 0; i <= parts; ++i) bounds.push_back(count * i / parts);
  return bounds;
}

void ForEachPart(const std::vector<std::size_t>& bounds,
                 const std::function<void(std::size_t part, std::size_t first, std::size_t last)>& work) {
  cv::parallel_for_(cv::Range(0, static_cast<int>(bounds.size()) - 1), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) work(static_cast<std::size_t>(i), bounds[i], bounds[i + 1]);
  });
}

}  // namespace turnscale
