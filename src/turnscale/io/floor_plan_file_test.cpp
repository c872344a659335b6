// SPDX-License-Identifier: MIT
#include "turnscale/io/floor_plan_file.h"

#include <fstream>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

FloorPlan PlanFrom(const std::string& text) {
  const std::string path = ScratchPath("floor_plan.csv");
  std::ofstream(path) << text;
  return ReadFloorPlan(path);
}

std::string PlanComplaint(const std::string& text) {
  try {
    PlanFrom(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(FloorPlan, WhatIsWrittenReadsBack) {
  const FloorPlan plan = {{{0, 0}, {0, 5}, {2.5, 5}}, {{-1, -2}, {-3.25, 4}}};
  EXPECT_EQ(PlanFrom(FloorPlanText(plan)), plan);
  EXPECT_TRUE(PlanFrom(FloorPlanText({})).empty());
}

TEST(FloorPlan, ComplaintsNameTheLine) {
  EXPECT_NE(PlanComplaint("outline,x_m,z_m\n0,1,2\n0,1\n").find("floor_plan.csv:3: '0,1' is not a corner"),
            std::string::npos);
  EXPECT_NE(PlanComplaint("outline,x_m,z_m\n0,nan,2\n").find(":2: "), std::string::npos);
  EXPECT_NE(PlanComplaint("").find("is not a floor plan"), std::string::npos);
  EXPECT_THROW(ReadFloorPlan("/nonexistent/plan.csv"), InputError);
  EXPECT_THROW(ReadFloorPlan("/"), InputError);
}

}  // namespace
}  // namespace turnscale
