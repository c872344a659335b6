// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "turnscale/bag/bag_reader.h"

namespace turnscale {

constexpr std::string_view kRos1Magic = "#ROSBAG V2.0\n";

/// Reads a bag of ROS 1, format 2.0 (wiki.ros.org/Bags/Format/2.0), with or without index; as OpenBag.
std::unique_ptr<BagReader> OpenRos1Bag(const std::filesystem::path& path, std::vector<std::string> topics);

}  // namespace turnscale
