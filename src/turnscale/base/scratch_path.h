// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

namespace turnscale {

/// A path in the tests' folder that no other test, running at the same time, has.
inline std::string ScratchPath(const std::string& name) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  return ::testing::TempDir() + test->test_suite_name() + "_" + test->name() + "_" + std::to_string(getpid()) + "_" +
         name;
}

}  // namespace turnscale
