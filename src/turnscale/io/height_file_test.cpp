// SPDX-License-Identifier: MIT
#include "turnscale/io/height_file.h"

#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

std::vector<PathHeight> Read(const std::string& text) {
  const std::filesystem::path path = ScratchPath("heights.csv");
  std::ofstream(path) << text;
  return ReadHeightFile(path);
}

std::string ErrorOf(const std::string& text) {
  try {
    Read(text);
  } catch (const InputError& error) {
    const std::string what = error.what();
    return what.substr(what.find("heights.csv") + std::string("heights.csv").size());
  }
  return "none";
}

TEST(HeightFile, ReadsHeightsWithAndWithoutSigma) {
  const std::vector<PathHeight> with = Read("height,time,sigma,other\n0.5,1.5,0.01,x\n0.25,2,0.01,y\n");
  ASSERT_EQ(with.size(), 2u);
  EXPECT_EQ(with[0].time, 1.5);
  EXPECT_EQ(with[0].height, 0.5);
  EXPECT_EQ(with[0].sigma, 0.02) << "relative";
  EXPECT_EQ(with[1].sigma, 0.04);
  const std::vector<PathHeight> without = Read("time,height\n1403636580.5,0.5\n");
  ASSERT_EQ(without.size(), 1u);
  EXPECT_EQ(without[0].time, 1403636580.5);
  EXPECT_EQ(without[0].sigma, kUsualHeightSigma);
}

TEST(HeightFile, ReadsFilesMadeByHandOrBySpreadsheets) {
  const std::vector<PathHeight> heights =
      Read("\xEF\xBB\xBFtime, height, sigma\r\n1.5, 0.5, 0.01\r\n\r\n2, 0.25, 0.01\r\n\r\n");
  ASSERT_EQ(heights.size(), 2u);
  EXPECT_EQ(heights[0].time, 1.5);
  EXPECT_EQ(heights[0].height, 0.5);
  EXPECT_EQ(heights[1].sigma, 0.04);
}

TEST(HeightFile, TimesMayBeMicroseconds) {
  EXPECT_EQ(Read("time,height\n1403636580000000,1\n1403636580100000,1\n")[0].time, 1403636580);
}

TEST(HeightFile, RefusesWhatMakesNoSense) {
  EXPECT_EQ(ErrorOf("time,heights\n1,2\n"), ": has no column 'height', but 'heights'");
  EXPECT_EQ(ErrorOf("time_ms,height\n1,2\n"), ": has no column 'time', but 'time_ms'");
  EXPECT_EQ(ErrorOf("time,height\n"), ": holds no heights");
  EXPECT_EQ(ErrorOf(""), ": has no column 'time'");
  EXPECT_EQ(ErrorOf("time,height\n1,2\n1,2\n"), ":3: time 1 does not come after 1");
  EXPECT_EQ(ErrorOf("time,height\n1,-2\n"), ":2: '1, -2' is not a time and a height");
  EXPECT_EQ(ErrorOf("time,height\n1,nan\n"), ":2: '1, nan' is not a time and a height");
  EXPECT_EQ(ErrorOf("time,height\n1,x\n"), ":2: 'x' is not a number");
  EXPECT_EQ(ErrorOf("time,height\n1\n"), ":2: has 1 values, the first line has 2");
  EXPECT_EQ(ErrorOf("time,height,sigma\n1,2,0\n"), ":2: sigma 0 has to be positive");
  EXPECT_THROW(ReadHeightFile("/no/such/heights.csv"), InputError);
}

}  // namespace
}  // namespace turnscale
