// SPDX-License-Identifier: MIT
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "command_line.h"
#include "turnscale/base/scratch_path.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kFrames = 210;

// A drive through a rendered world, from nothing to its score, as a user makes it. The car's tyres slip by the default
// 3 degrees per g, which is the c that `run` is told.
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

  void Drive(const std::string& world) const {
    const std::string drive = (folder_ / "drive").string();
    const std::string out = (folder_ / "out").string();
    Run("simulate", {world, "--seconds", "30", "--max-frames", std::to_string(kFrames), "--rig",
                     (folder_ / "rig.yaml").string(), "--out", drive, "--quiet"});
    Run("run", {drive, "--lever-arm", "1.5", "--side-slip", "0.0053374", "--out", out, "--quiet"});
    Run("evaluate", {out + "/trajectory.tum", drive + "/poses.txt", "--json", Score().string()});
  }

  fs::path Score() const { return folder_ / "score.json"; }
  static Json Read(const fs::path& path) { return Json::parse(std::ifstream(path)); }

  void ExpectAllTracked(int turns) const {
    const Json summary = Read(folder_ / "out" / "summary.json");
    EXPECT_EQ(summary["frames"]["tracked"], kFrames);
    EXPECT_GE(summary["turns"]["used"], turns);
  }

  fs::path folder_;
};

TEST_F(RenderedDriveTest, GarageComesOutInMetres) {
  ASSERT_NO_FATAL_FAILURE(Drive("garage"));
  ExpectAllTracked(2);
  const Json score = Read(Score());
  EXPECT_LT(score["as_given"]["scale_error_ratio"]["all"]["rmse_percent"], 4);
  EXPECT_LT(score["position_error"]["sim3"]["rmse_m"], 0.3);
  EXPECT_LT(score["turning_angle"]["turning"]["rmse_deg"], 0.05);
}

TEST_F(RenderedDriveTest, StreetComesOutInMetres) {
  ASSERT_NO_FATAL_FAILURE(Drive("street"));
  ExpectAllTracked(1);
  const Json score = Read(Score());
  EXPECT_LT(score["as_given"]["scale_error_ratio"]["all"]["rmse_percent"], 8);
  EXPECT_LT(score["position_error"]["sim3"]["rmse_m"], 1);
  EXPECT_LT(score["turning_angle"]["turning"]["rmse_deg"], 0.05);
}

}  // namespace
}  // namespace turnscale
