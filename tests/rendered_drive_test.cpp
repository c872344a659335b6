// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "command_line.h"
#include "turnscale/base/test_files.h"
#include "turnscale/config/yaml_map.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

using Row = std::map<std::string, double>;

// The leading columns of numbers of a table; what follows the first cell that is none is left out.
std::vector<Row> ReadTable(const fs::path& path) {
  std::ifstream stream(path);
  std::string line;
  std::getline(stream, line);
  const std::string header = line;
  std::vector<Row> rows;
  while (std::getline(stream, line)) {
    std::istringstream names(header);
    std::istringstream cells(line);
    Row& row = rows.emplace_back();
    std::string name;
    for (std::string cell; std::getline(names, name, ',') && std::getline(cells, cell, ',');) {
      if (!cell.empty() && cell.front() == '"') break;
      row[name] = cell.empty() ? std::nan("") : std::stod(cell);
    }
  }
  return rows;
}

struct Stretch {
  double first_frame = 0;
  double last_frame = 0;
};

// Stretches of the true drive that turn one way, at 2 deg/s at least, by 30 degrees or more, and end so long before the
// last frame that the turn's end can be seen.
std::vector<Stretch> TrueTurns(const fs::path& truth) {
  constexpr double kLeastRate = 2;
  constexpr double kLeastAngle = 30;
  constexpr double kSecondsAfter = 1.5;
  const std::vector<Row> rows = ReadTable(truth);
  std::vector<Stretch> turns;
  for (size_t i = 0; i < rows.size();) {
    const double side = std::copysign(1, rows[i].at("yaw_rate_degps"));
    double angle = 0;
    size_t end = i;
    for (; end < rows.size() && side * rows[end].at("yaw_rate_degps") >= kLeastRate; ++end) {
      if (end > i) angle += rows[end].at("yaw_rate_degps") * (rows[end].at("time_s") - rows[end - 1].at("time_s"));
    }
    if (std::abs(angle) >= kLeastAngle && rows[end - 1].at("time_s") <= rows.back().at("time_s") - kSecondsAfter) {
      turns.push_back({rows[i].at("frame"), rows[end - 1].at("frame")});
    }
    i = std::max(end, i + 1);
  }
  return turns;
}

// A drive through a rendered world, from nothing to its score, as a user makes it who knows the car.
class RenderedDriveTest : public ::testing::Test {
 protected:
  RenderedDriveTest() : folder_(ScratchPath("rendered")) {
    fs::create_directories(folder_);
    // Half the size of the default camera: a quarter of its pixels.
    std::ofstream(folder_ / "rig.yaml") << "camera: {width: 516, height: 386, fx: 307.5, fy: 307.5, cx: 257.5, "
                                           "cy: 192.5}\n";
  }
  ~RenderedDriveTest() override { fs::remove_all(folder_); }

  void Run(const std::string& command, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), command);
    const CommandResult result = RunCommand(arguments, folder_);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }

  void Drive(const std::string& world, int frames) {
    frames_ = frames;
    const std::string drive = (folder_ / "drive").string();
    const std::string out = (folder_ / "out").string();
    ASSERT_NO_FATAL_FAILURE(Run("simulate", {world, "--seconds", "30", "--max-frames", std::to_string(frames), "--rig",
                                             (folder_ / "rig.yaml").string(), "--out", drive, "--quiet"}));
    const YamlMap car(drive + "/vehicle.yaml");
    ASSERT_NO_FATAL_FAILURE(Run("run", {drive, "--lever-arm", car.Text("lever_arm"), "--side-slip",
                                        car.Text("side_slip"), "--out", out, "--quiet"}));
    Run("evaluate", {out + "/trajectory.tum", drive + "/poses.txt", "--json", Score().string()});
  }

  // Without the calibration, from a field of view of 60 degrees where the drive has 80.
  void ExpectTheCameraFromTheDrive() const {
    const fs::path out = folder_ / "estimated";
    const std::string drive = (folder_ / "drive").string();
    ASSERT_NO_FATAL_FAILURE(Run("run", {drive, "--fov", "60", "--out", out.string(), "--quiet"}));
    const Json intrinsics = Read(out / "summary.json")["intrinsics"];
    EXPECT_EQ(intrinsics["source"], "estimated");
    const double focal_length = intrinsics["focal_length"][0];
    EXPECT_NEAR(focal_length / 307.5, 1, 0.02);
    EXPECT_LT(intrinsics["focal_length_sigma"].get<double>(), 0.02 * focal_length);
    EXPECT_NEAR(YamlMap((out / "camera.yaml").string()).Number("focal_length_sigma"), intrinsics["focal_length_sigma"],
                1e-9);
    ASSERT_NO_FATAL_FAILURE(Run("run", {drive, "--camera", (out / "camera.yaml").string(), "--max-frames", "20",
                                        "--out", (folder_ / "next").string(), "--quiet"}));
    EXPECT_EQ(Read(folder_ / "next" / "summary.json")["intrinsics"]["source"], "given");
  }

  // Its first part, which has no turn, as the next drive of the car that is known from the whole one.
  void ExpectMetresWithoutATurn() const {
    const std::string drive = (folder_ / "drive").string();
    const fs::path out = folder_ / "straight";
    ASSERT_NO_FATAL_FAILURE(Run("run", {drive, "--vehicle", (folder_ / "out" / "car.yaml").string(), "--max-frames",
                                        "80", "--out", out.string(), "--quiet"}));
    const Json summary = Read(out / "summary.json");
    EXPECT_EQ(summary["turns"]["used"], 0);
    EXPECT_EQ(summary["scale"]["state"], "road");
    const double sigma = summary["path_sigma"];
    EXPECT_LT(sigma, 0.05);
    ASSERT_NO_FATAL_FAILURE(
        Run("evaluate", {(out / "trajectory.tum").string(), drive + "/poses.txt", "--json", Score().string()}));
    EXPECT_NEAR(Read(Score())["as_given"]["path_length_error_percent"], 0, 100 * sigma);
  }

  fs::path Score() const { return folder_ / "score.json"; }
  static Json Read(const fs::path& path) { return Json::parse(std::ifstream(path)); }

  // `turns`: how many there are at least.
  void ExpectAllFound(size_t turns) const {
    EXPECT_EQ(Read(folder_ / "out" / "summary.json")["frames"]["tracked"], frames_);
    const std::vector<Stretch> wanted = TrueTurns(folder_ / "drive" / "truth.csv");
    EXPECT_GE(wanted.size(), turns);
    const std::vector<Row> found = ReadTable(folder_ / "out" / "turns.csv");
    for (const Stretch& turn : wanted) {
      EXPECT_TRUE(std::any_of(found.begin(), found.end(),
                              [&](const Row& row) {
                                return row.at("used") == 1 && row.at("first_frame") <= turn.last_frame &&
                                       row.at("last_frame") >= turn.first_frame;
                              }))
          << "the turn of frames " << turn.first_frame << " to " << turn.last_frame;
    }
  }

  fs::path folder_;
  int frames_ = 0;  // of the drive
};

TEST_F(RenderedDriveTest, GarageComesOutInMetres) {
  ASSERT_NO_FATAL_FAILURE(Drive("garage", 210));
  ExpectAllFound(2);
  const Json score = Read(Score());
  EXPECT_LT(score["as_given"]["scale_error_ratio"]["all"]["rmse_percent"], 1.2);
  EXPECT_LT(score["position_error"]["sim3"]["rmse_m"], 0.02);
  EXPECT_LT(score["turning_angle"]["turning"]["rmse_deg"], 0.015);
  ExpectTheCameraFromTheDrive();
}

TEST_F(RenderedDriveTest, StreetComesOutInMetres) {
  ASSERT_NO_FATAL_FAILURE(Drive("street", 175));
  ExpectAllFound(1);
  const Json score = Read(Score());
  EXPECT_LT(score["as_given"]["scale_error_ratio"]["all"]["rmse_percent"], 4.2);
  EXPECT_LT(score["position_error"]["sim3"]["rmse_m"], 0.35);
  EXPECT_LT(score["turning_angle"]["turning"]["rmse_deg"], 0.012);
  ExpectMetresWithoutATurn();
}

}  // namespace
}  // namespace turnscale
