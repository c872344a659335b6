// SPDX-License-Identifier: MIT
#include "turnscale/export/utc_time.h"

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(UtcTime, TellsClocksFromTimesOfADrive) {
  EXPECT_TRUE(AreSince1970(ParseUtcTime("1995-01-01T00:00:00Z").value()));
  EXPECT_FALSE(AreSince1970(1e7));
}

TEST(UtcTime, ReadsOffsetsAndDecimals) {
  EXPECT_EQ(ParseUtcTime("1970-01-01T00:00:00Z"), 0);
  EXPECT_EQ(ParseUtcTime("2000-03-01T12:00:00Z"), 951912000);
  EXPECT_EQ(ParseUtcTime("2026-03-22T07:14:05+01:00"), ParseUtcTime("2026-03-22T06:14:05Z"));
  EXPECT_EQ(ParseUtcTime("2026-03-21T20:14:05.5-10:00"), *ParseUtcTime("2026-03-22T06:14:05Z") + 0.5);
  EXPECT_EQ(ParseUtcTime("1969-12-31T23:59:59Z"), -1);
}

TEST(UtcTime, RefusesOtherText) {
  for (const char* text : {"", "now", "2026-03-22", "2026-03-22T07:14:05", "2026-13-22T07:14:05Z",
                           "2026-02-30T07:14:05Z", "2026-03-22T24:14:05Z", "2026-03-22T07:14:05Zx",
                           "2026-03-22T07:14:05.Z", "2026-03-22T07:14:05+1:00", "2026-03-2 T07:14:05Z"}) {
    EXPECT_FALSE(ParseUtcTime(text)) << text;
  }
}

TEST(UtcTime, WritesMilliseconds) {
  for (const char* text :
       {"2026-03-22T06:14:05.250Z", "1970-01-01T00:00:00.000Z", "1969-12-31T23:59:59.999Z", "2024-02-29T23:59:59.001Z"})
    EXPECT_EQ(UtcTimeText(ParseUtcTime(text).value()), text);
}

}  // namespace
}  // namespace turnscale
