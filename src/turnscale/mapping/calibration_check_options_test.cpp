// SPDX-License-Identifier: MIT
#include "turnscale/mapping/calibration_check_options.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"

namespace turnscale {
namespace {

TEST(CalibrationCheckOptions, NameTheFieldThatMakesNoSense) {
  using Options = CalibrationCheckOptions;
  EXPECT_EQ(RefusedField<Options>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.window = 2; }), "window");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_turn_deg = 0; }), "min_turn_deg");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.focal_prior_sigma = std::nan(""); }), "focal_prior_sigma");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.significance = -1; }), "significance");
}

}  // namespace
}  // namespace turnscale
