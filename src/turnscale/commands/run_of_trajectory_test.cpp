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
  int left_out;
  std::vector<int> gaps;
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
  for (const Expected& expected : std::vector<Expected>{{{t, b, b, b, t, t}, 3, {}},
                                                        {{t, b, b, b, b, b, t, t}, 5, {1}},
                                                        {{t, u, u, u, u, u, u, t}, 6, {}},
                                                        {{t, r, t, b, b, r, b, b, b, t, t}, 6, {3}},
                                                        {{"initializing", "initializing", t, t}, 0, {}}}) {
    std::ofstream(table) << TableOf(expected.states);
    const int count = static_cast<int>(expected.states.size());
    const MeasuredPath path = MeasuredPartOf(tum, Poses(count));
    SCOPED_TRACE(count);
    EXPECT_EQ(path.left_out, expected.left_out);
    EXPECT_EQ(static_cast<int>(path.poses.size()), count - expected.left_out);
    std::vector<int> gaps;
    for (const PathGap& gap : path.gaps) gaps.push_back(gap.pose);
    EXPECT_EQ(gaps, expected.gaps);
    EXPECT_EQ(MeasuredPartOf(folder.Path() / RunFiles::kLiveTum, Poses(count)).left_out, 0) << "as it was online";
  }
  std::ofstream(table) << "x,y\n1,2\n";
  EXPECT_EQ(MeasuredPartOf(tum, Poses(5)).poses.size(), 5U) << "a table of another program";
}

}  // namespace
}  // namespace turnscale
