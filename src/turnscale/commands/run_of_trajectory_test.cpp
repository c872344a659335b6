// SPDX-License-Identifier: MIT
#include "turnscale/commands/run_of_trajectory.h"

#include <gtest/gtest.h>

#include "turnscale/base/test_files.h"
#include "turnscale/io/run_files.h"

namespace turnscale {
namespace {

Trajectory Poses(int count) {
  Trajectory poses;
  for (int i = 0; i < count; ++i) poses.push_back({0.1 * i, {}});
  return poses;
}

std::string TableOf(const std::vector<std::string>& states) {
  std::string table = "frame,time,state,x\n";
  for (size_t i = 0; i < states.size(); ++i)
    table += std::to_string(i) + "," + std::to_string(0.1 * static_cast<double>(i)) + "," + states[i] + ",0\n";
  return table;
}

struct Expected {
  std::vector<std::string> states;
  std::string restarts;
  int left_out;
  std::vector<PathGap> gaps;
};

TEST(MeasuredPart, LeavesOutWhatWasLostAndNamesWhereTheMapBeganAnew) {
  const ScratchFolder folder;
  const std::filesystem::path tum = folder.Path() / RunFiles::kTrajectoryTum;
  const std::filesystem::path table = folder.Path() / RunFiles::kTrajectoryTable;
  EXPECT_EQ(MeasuredPartOf(tum, Poses(5)).poses.size(), 5U) << "no table";
  const std::string t = "tracked";
  const std::string b = "bridged";
  const std::string r = "repeated";
  const std::string u = "unreadable";
  const std::string at_3 = R"({"frame": 3, "time_s": 0.3, "unit_sigma": 0.3})";
  const std::string at_3_and_4 =
      R"({"frame": 3, "time_s": 0.3, "unit_sigma": 0.3}, {"frame": 4, "time_s": 0.4, "unit_sigma": 0.4})";
  for (const Expected& expected : std::vector<Expected>{{{t, b, b, t, t}, "", 2, {}},
                                                        {{t, b, b, t, t}, at_3, 2, {{1, 0.3}}},
                                                        {{t, u, u, b, r, t}, at_3_and_4, 4, {{1, 0.5}}},
                                                        {{t, b, b, t, b, t}, at_3, 3, {{1, 0.3}}},
                                                        {{"initializing", "initializing", t, t}, "", 0, {}},
                                                        {{t, b, t, t, t}, R"({"frame": "3"}, 3)", 1, {}}}) {
    std::ofstream(table) << TableOf(expected.states);
    std::ofstream(folder.Path() / RunFiles::kSummary) << R"({"missing": {"restarts": [)" + expected.restarts + "]}}";
    const int count = static_cast<int>(expected.states.size());
    const MeasuredPath path = MeasuredPartOf(tum, Poses(count));
    SCOPED_TRACE(expected.restarts);
    EXPECT_EQ(path.left_out, expected.left_out);
    EXPECT_EQ(static_cast<int>(path.poses.size()), count - expected.left_out);
    ASSERT_EQ(path.gaps.size(), expected.gaps.size());
    for (size_t i = 0; i < path.gaps.size(); ++i) {
      EXPECT_EQ(path.gaps[i].pose, expected.gaps[i].pose);
      EXPECT_NEAR(path.gaps[i].sigma, expected.gaps[i].sigma, 1e-12);
    }
    EXPECT_EQ(MeasuredPartOf(folder.Path() / RunFiles::kLiveTum, Poses(count)).left_out, 0) << "as it was online";
  }
  std::ofstream(table) << TableOf({t, b, t, u, t});
  std::ofstream(folder.Path() / RunFiles::kSummary) << R"({"missing": {"parts": 2}})";
  EXPECT_EQ(MeasuredPartOf(tum, Poses(5)).gaps.size(), 2U) << "of an earlier version";
  std::ofstream(table) << "x,y\n1,2\n";
  EXPECT_EQ(MeasuredPartOf(tum, Poses(5)).poses.size(), 5U) << "a table of another program";
}

TEST(PathLengthOfRun, IsThatOfTheSummaryInMetresOrUnits) {
  const ScratchFolder folder;
  const std::filesystem::path tum = folder.Path() / RunFiles::kTrajectoryTum;
  EXPECT_FALSE(PathLengthOfRun(tum));
  std::ofstream(folder.Path() / RunFiles::kSummary) << R"({"distance_m": 12.5, "distance_units": null})";
  EXPECT_EQ(PathLengthOfRun(tum), 12.5);
  EXPECT_FALSE(PathLengthOfRun(folder.Path() / RunFiles::kLiveTum));
  EXPECT_FALSE(PathLengthOfRun(folder.Path() / "other.tum"));
  std::ofstream(folder.Path() / RunFiles::kSummary) << R"({"distance_m": null, "distance_units": 3})";
  EXPECT_EQ(PathLengthOfRun(folder.Path() / RunFiles::kTrajectoryKitti), 3);
}

}  // namespace
}  // namespace turnscale
