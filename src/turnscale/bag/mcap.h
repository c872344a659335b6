// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "turnscale/bag/bag_reader.h"

namespace turnscale {

constexpr std::string_view kMcapMagic = "\x89MCAP0\r\n";

/// Reads an MCAP file (mcap.dev/spec) with ROS 1 or ROS 2 messages, with or without chunks and index; as OpenBag.
std::unique_ptr<BagReader> OpenMcap(const std::filesystem::path& path, std::vector<std::string> topics);

}  // namespace turnscale
