// SPDX-License-Identifier: MIT
#include "turnscale/base/error.h"

#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(Ensure, SaysWhatIsBrokenAndWhere) {
  EXPECT_NO_THROW(Ensure(true, "never"));
  const int line = __LINE__ + 2;
  try {
    Ensure(false, "the map has no keyframe");
    FAIL();
  } catch (const InternalError& error) {
    EXPECT_EQ(error.what(), "the map has no keyframe at base/error_test.cpp:" + std::to_string(line));
  }
}

TEST(Ensure, NobodyTakesItForTheUsersFault) {
  EXPECT_THROW(
      {
        try {
          Ensure(false, "broken");
        } catch (const std::runtime_error&) {
          // As InputError, OutputError and NumericalError are.
        }
      },
      InternalError);
}

TEST(Attempts, GoOnAfterAFailureAndKeepTheFirst) {
  Attempts attempts;
  EXPECT_NO_THROW(attempts.RethrowFirst());
  int done = 0;
  EXPECT_TRUE(attempts.Try([&] { ++done; }));
  EXPECT_FALSE(attempts.Try([] { throw InputError("first"); }));
  EXPECT_FALSE(attempts.Try([] { throw 42; }));
  EXPECT_TRUE(attempts.Try([&] { ++done; }));
  EXPECT_EQ(done, 2);
  EXPECT_EQ(attempts.failures().size(), 2u);
  EXPECT_THROW(attempts.RethrowFirst(), InputError);
}

}  // namespace
}  // namespace turnscale
