// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "turnscale/bag/bag_reader.h"

namespace turnscale {

/// Reads a bag of ROS 2 in the format of rosbag2's sqlite3 storage; as OpenBag.
std::unique_ptr<BagReader> OpenDb3(const std::filesystem::path& path, std::vector<std::string> topics);

}  // namespace turnscale
