// SPDX-License-Identifier: MIT
#include "turnscale/io/message.h"

#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

template <class Exception>
Failure Of(const Exception& exception) {
  return FailureOf(std::make_exception_ptr(exception));
}

void ExpectInternal(const Failure& failure, const std::string& part) {
  EXPECT_EQ(failure.exit_code, 1);
  EXPECT_TRUE(failure.message.starts_with("internal error: ")) << failure.message;
  EXPECT_NE(failure.message.find(part), std::string::npos) << failure.message;
  EXPECT_NE(failure.message.find("please report it"), std::string::npos) << failure.message;
  EXPECT_EQ(failure.message.find('\n'), std::string::npos) << failure.message;
}

TEST(Failure, OfTheInputAndTheMachineSaysItsMessage) {
  EXPECT_EQ(Of(InputError("cam.yaml:1: bad")).exit_code, 2);
  EXPECT_EQ(Of(InputError("cam.yaml:1: bad")).message, "cam.yaml:1: bad");
  EXPECT_EQ(Of(OutputError("map.ply: full")).exit_code, 1);
  EXPECT_EQ(Of(OutputError("map.ply: full")).message, "map.ply: full");
  const Failure denied = Of(
      std::filesystem::filesystem_error("status", "/secret/file", std::make_error_code(std::errc::permission_denied)));
  EXPECT_EQ(denied.exit_code, 1);
  EXPECT_EQ(denied.message, "/secret/file: Permission denied");
  for (const Failure& memory : {Of(std::bad_alloc()), Of(cv::Exception(cv::Error::StsNoMem, "no", "f", "file", 1))}) {
    EXPECT_EQ(memory.exit_code, 1);
    EXPECT_TRUE(memory.message.starts_with("out of memory")) << memory.message;
  }
}

TEST(Failure, OfOursOrOfALibrarySaysWhere) {
  ExpectInternal(Of(InternalError("the map is empty")), "the map is empty at io/message_test.cpp:");
  ExpectInternal(Of(cv::Exception(cv::Error::StsAssert, "size > 0", "resize", "resize.cpp", 4052)), "resize.cpp:4052");
  ExpectInternal(Of(std::out_of_range("vector::at\n  twice")), "vector::at twice;");
  ExpectInternal(Of(NumericalError("a pose is not a number")), "a pose is not a number");
  ExpectInternal(Of(42), "no exception");
}

TEST(Message, IsOneLineThatATerminalDoesNotObey) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(Report({2, "a\x1b[2J\nb"}), 2);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "turnscale: a\\x1b[2J\\x0ab\n");
  ::testing::internal::CaptureStdout();
  PrintText("folder \x1b[31m\nlast\n");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "folder \\x1b[31m\nlast\n");
}

}  // namespace
}  // namespace turnscale
