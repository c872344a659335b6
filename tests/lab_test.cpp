// SPDX-License-Identifier: MIT
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "command_line.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

class LabTest : public ::testing::Test {
 protected:
  LabTest() : folder_(ScratchPath("lab")) { fs::create_directories(folder_); }
  ~LabTest() override { fs::remove_all(folder_); }

  CommandResult Run(const std::string& out, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"lab", "--out", (folder_ / out).string()});
    return RunCommand(arguments, folder_);
  }

  std::string Text(const fs::path& file) const { return TextOf(folder_ / file); }

  fs::path folder_;
};

TEST_F(LabTest, DrawsWhatIsAskedForAndKeepsItsNumbers) {
  const CommandResult result = Run("a", {"--only", "fig4,fig6,fig7"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(Text("a/lab.json"));
  for (const char* name : {"fig4", "fig6", "fig7"}) EXPECT_TRUE(json.contains(name)) << name;
  EXPECT_FALSE(json.contains("table1"));
  EXPECT_TRUE(json["fig4"]["pictures"].contains("fig4b"));
  for (const char* name : {"a/fig4b.svg", "a/fig6.svg", "a/fig7.svg"}) EXPECT_EQ(Text(name).find("<svg"), 0U) << name;
}

TEST_F(LabTest, NumbersDoNotDependOnTheJobs) {
  ASSERT_EQ(Run("one", {"--only", "fig9", "--runs", "2", "--jobs", "1"}).exit_code, 0);
  ASSERT_EQ(Run("three", {"--only", "fig9", "--runs", "2", "--jobs", "3"}).exit_code, 0);
  EXPECT_EQ(Text("one/lab.json"), Text("three/lab.json"));
}

TEST_F(LabTest, RefusesWhatItCannotDo) {
  ExpectComplaint(Run("a", {"--runs", "1"}), 2, {"--runs 1"});
  ExpectComplaint(Run("a", {"--jobs", "0"}), 2, {"--jobs 0"});
  ExpectComplaint(Run("a", {"--only", "fig99"}), 2, {"fig99"});
}

}  // namespace
}  // namespace turnscale
