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

TEST(MeasuredPart, LeavesOutWhatWasLostAndNamesWhereTheMapBeganAnew) {
  const ScratchFolder folder;
  const std::filesystem::path tum = folder.Path() / RunFiles::kTrajectoryTum;
  const std::filesystem::path table = folder.Path() / RunFiles::kTrajectoryTable;
  EXPECT_EQ(MeasuredPartOf(tum, Poses(5)).poses.size(), 5U) << "no table";
  std::ofstream(table) << TableOf(
      {"tracked", "bridged", "tracked", "repeated", "bridged", "bridged", "bridged", "tracked"});
  const MeasuredPath path = MeasuredPartOf(tum, Poses(8));
  EXPECT_EQ(path.left_out, 4);
  ASSERT_EQ(path.poses.size(), 4U);
  EXPECT_DOUBLE_EQ(path.poses[3].time, 0.7);
  ASSERT_EQ(path.gaps.size(), 1U);
  EXPECT_EQ(path.gaps[0].pose, 3);
  EXPECT_GT(path.gaps[0].sigma, 0.1);
  // Online, without the first two frames.
  Trajectory live = Poses(8);
  live.erase(live.begin(), live.begin() + 2);
  EXPECT_EQ(MeasuredPartOf(folder.Path() / RunFiles::kLiveTum, live).left_out, 3);
  EXPECT_TRUE(MeasuredPartOf(folder.Path() / "other.tum", Poses(8)).gaps.empty());
}

}  // namespace
}  // namespace turnscale
