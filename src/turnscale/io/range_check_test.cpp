// SPDX-License-Identifier: MIT
#include "turnscale/io/range_check.h"

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

TEST(RangeCheckTest, NamesFieldValueRangeAndUnit) {
  try {
    CheckRange("mount.height", 11, 0.1, 10, "metres");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), "mount.height: is 11; it has to be in 0.1...10 metres");
  }
}

TEST(RangeCheckTest, TakesBothEndsAndRefusesWhatIsNoNumber) {
  EXPECT_NO_THROW(CheckRange("a.b", 1, 1, 2));
  EXPECT_NO_THROW(CheckRange("a.b", 2, 1, 2));
  EXPECT_THROW(CheckRange("a.b", std::numeric_limits<double>::quiet_NaN(), 1, 2), InputError);
}

}  // namespace
}  // namespace turnscale
