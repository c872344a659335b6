// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace turnscale {

/// Decompresses one frame of "lz4", "zstd" or "bz2" into `out`, which then has `size` bytes. Memory grows with what the
/// data really hold, not with what `size` says. Throws MalformedData for another compression, damaged data, or data
/// that do not have that size.
void Decompress(std::string_view compression, std::span<const uint8_t> compressed, size_t size,
                std::vector<uint8_t>& out);

}  // namespace turnscale
