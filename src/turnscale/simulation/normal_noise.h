// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

namespace turnscale {

/// Fills the values with independent normal numbers of mean 0 and standard deviation 1 (no larger than 4.33). They
/// depend on the key and their place alone.
void FillNormalNoise(std::uint64_t key, std::span<float> values);

}  // namespace turnscale
