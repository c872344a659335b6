// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/keyframe_table.h"

#include <sstream>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

std::vector<KeyframeRow> Read(const std::string& text) {
  std::istringstream table(text);
  return ReadKeyframes(table, "trajectory.csv");
}

std::string ProblemOf(const std::string& text) {
  try {
    Read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(KeyframeTable, FindsColumnsByNameAndKeepsKeyframes) {
  const std::vector<KeyframeRow> rows = Read(
      "turning,time,state,frame,keyframe,psi_deg\n"
      "0,0.5,tracked,5,1,\n"
      "0,0.6,tracked,6,0,\n"
      "1,0.7,tracked,7,1,-2.5\r\n");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].frame, 5);
  EXPECT_EQ(rows[0].time, 0.5);
  EXPECT_FALSE(rows[0].turning);
  EXPECT_EQ(rows[1].frame, 7);
  EXPECT_TRUE(rows[1].turning);
}

TEST(KeyframeTable, SaysWhatIsWrong) {
  EXPECT_EQ(ProblemOf("frame,time,keyframe\n"), "trajectory.csv: has no column 'turning'");
  EXPECT_EQ(ProblemOf(""), "trajectory.csv: has no column 'frame'");
  EXPECT_EQ(ProblemOf("frame,time,keyframe,turning\n1,0.1,1\n"),
            "trajectory.csv:2: has 3 values, the first line has 4");
  EXPECT_EQ(ProblemOf("frame,time,keyframe,turning\n1,0.1,1,0\n1,x,1,0\n"), "trajectory.csv:3: 'x' is not a number");
}

}  // namespace
}  // namespace turnscale
