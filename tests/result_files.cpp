// SPDX-License-Identifier: MIT
#include "result_files.h"

#include <algorithm>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/test_files.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/run/settings.h"
#include "turnscale/run/vehicle_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

void ExpectWholeTable(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  std::string header;
  std::getline(lines, header);
  EXPECT_FALSE(header.empty()) << name;
  for (std::string line; std::getline(lines, line);) {
    // Reasons stand in quotes and hold no commas.
    EXPECT_EQ(std::ranges::count(line, ','), std::ranges::count(header, ',')) << name << ": " << line;
  }
}

void ExpectWholeMap(const std::string& text) {
  const std::string count = "element vertex ";
  const std::string end = "end_header\n";
  const size_t body = text.find(end);
  ASSERT_NE(body, std::string::npos);
  constexpr size_t kVertexBytes = 15;
  EXPECT_EQ(text.size() - body - end.size(), kVertexBytes * std::stoul(text.substr(text.find(count) + count.size())));
}

}  // namespace

const std::vector<std::string>& NamesOfResults() {
  static const std::vector<std::string> names = {"live.tum",       "trajectory.tum", "trajectory.kitti.txt",
                                                 "trajectory.csv", "turns.csv",      "camera_rotation.csv",
                                                 "map.ply"};
  return names;
}

void ExpectWholeFiles(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& path = entry.path();
    const std::string name = path.filename().string();
    if (path.extension() == ".part" || entry.is_directory()) continue;
    const std::string text = TextOf(path);
    if (path.extension() == ".ply") {
      ExpectWholeMap(text);
      continue;
    }
    EXPECT_TRUE(text.empty() || text.ends_with('\n')) << name;
    if (path.extension() == ".html") {
      EXPECT_TRUE(text.ends_with("</html>\n")) << name;
      continue;
    }
    if (path.extension() == ".csv") {
      ExpectWholeTable(text, name);
    } else if (path.extension() == ".json") {
      EXPECT_TRUE(nlohmann::json::accept(text)) << name;
    } else if (name == "car.yaml") {
      VehicleOptions vehicle;
      EXPECT_NO_THROW(ReadVehicleFile(path, vehicle)) << name;
    } else if (path.extension() == ".yaml") {
      EXPECT_NO_THROW(ReadSettings(path)) << name;
    } else if (!text.empty()) {
      EXPECT_NO_THROW(ReadTrajectory(path)) << name;
    }
  }
}

}  // namespace turnscale
