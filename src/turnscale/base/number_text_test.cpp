// SPDX-License-Identifier: MIT
#include "turnscale/base/number_text.h"

#include <limits>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(NumberText, IsShort) {
  EXPECT_EQ(NumberText(0), "0");
  EXPECT_EQ(NumberText(-1.5), "-1.5");
  EXPECT_EQ(NumberText(718.856), "718.856");
  EXPECT_EQ(NumberText(100000), "100000");
  EXPECT_EQ(NumberText(0.0001), "0.0001");
}

TEST(NumberText, ReadsBackAsTheSameNumber) {
  for (const double value : {1.0 / 3, -2.5e-17, 6.02214076e23, 0.1 + 0.2, std::numeric_limits<double>::lowest(),
                             std::numeric_limits<double>::denorm_min()}) {
    EXPECT_EQ(ParseNumber<double>(NumberText(value)), value) << NumberText(value);
  }
}

TEST(NumberText, ListsHaveCommas) {
  using Numbers = std::vector<double>;
  EXPECT_EQ(ParseNumbers("1,-2.5,+3"), Numbers({1, -2.5, 3}));
  EXPECT_EQ(ParseNumbers(" 1 , 2"), Numbers({1, 2}));
  EXPECT_EQ(ParseNumbers("7"), Numbers({7}));
  for (const char* text : {"", ",", "1,", "1,,2", "1;2", "1 2", "x"})
    EXPECT_EQ(ParseNumbers(text), std::nullopt) << text;
}

}  // namespace
}  // namespace turnscale
