// SPDX-License-Identifier: MIT
#include "turnscale/io/speed_file.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

SpeedLog SpeedsFrom(const std::string& text) {
  const std::string path = ScratchPath("speed.csv");
  std::ofstream(path) << text;
  struct Remover {
    std::string path;
    ~Remover() { std::filesystem::remove(path); }
  } remover{path};
  return ReadSpeedFile(path);
}

TEST(SpeedFile, GivesDistances) {
  const SpeedLog log = SpeedsFrom("time_s,speed_mps\n0,0\n1,2\n# a comment\n3 2\n");
  EXPECT_DOUBLE_EQ(log.Distance(0, 1).value(), 1);
  EXPECT_DOUBLE_EQ(log.Distance(0.5, 2).value(), 0.75 + 2);
  EXPECT_DOUBLE_EQ(log.Distance(0, 3).value(), 5);
  EXPECT_FALSE(log.Distance(2, 3.1));
  EXPECT_FALSE(log.Distance(-0.1, 1));
}

TEST(SpeedFile, TimesMayBeMicroseconds) {
  EXPECT_NEAR(SpeedsFrom("1403636580000000,1\n1403636580100000,3\n").Distance(1403636580, 1403636580.1).value(), 0.2,
              1e-6);
}

TEST(SpeedFile, TakesTheColumnsThatAreNamed) {
  const SpeedLog log = SpeedsFrom("frame,t_s,speed_mps,yaw\n0,10,2,0\n1,11,4,0\n");
  EXPECT_DOUBLE_EQ(log.Distance(10, 11).value(), 3);
  for (const char* text : {"frame,t_s,velocity\n0,10,2\n1,11,4\n", "0,10,2\n1,11,4\n"}) {
    try {
      SpeedsFrom(text);
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("has 3 columns"), std::string::npos) << error.what();
    }
  }
}

TEST(SpeedFile, NamesTheLineItCannotRead) {
  for (const char* text : {"0,1\n1,x\n", "0,1\n1,nan\n", "0,1\n0,2\n", "0,1\n1,-2\n", "0,1\n2\n"}) {
    try {
      SpeedsFrom(text);
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(":2: "), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(SpeedsFrom("0,1\n"), InputError);
}

}  // namespace
}  // namespace turnscale
