// SPDX-License-Identifier: MIT
#include "turnscale/base/text_lines.h"

#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

std::vector<std::string> LinesOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> all;
  for (TextLines lines(stream, "a.txt"); lines.Next();) all.push_back(lines.Line());
  return all;
}

std::string LinesComplaint(const std::string& text) {
  try {
    LinesOf(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

using Lines = std::vector<std::string>;

TEST(TextLines, LineEndsOfAllSystems) {
  EXPECT_EQ(LinesOf(""), Lines());
  EXPECT_EQ(LinesOf("a\nb\n"), (Lines{"a", "b"}));
  EXPECT_EQ(LinesOf("a\r\n\r\nb"), (Lines{"a", "", "b"}));
  EXPECT_EQ(LinesOf("\n"), (Lines{""}));
}

TEST(TextLines, LongLinesAreWhole) {
  for (const size_t size : {1022, 1023, 1024, 2046, 5000}) {
    const std::string line(size, 'x');
    const std::string ended = line + "\n";
    EXPECT_EQ(LinesOf(ended + line), (Lines{line, line})) << size;
    EXPECT_EQ(LinesOf(ended), (Lines{line})) << size;
  }
}

TEST(TextLines, ByteOrderMarkIsPassedOver) {
  EXPECT_EQ(LinesOf("\xEF\xBB\xBF"
                    "0.5\n1\n"),
            (Lines{"0.5", "1"}));
  EXPECT_EQ(LinesOf("\xEF\xBB\xBF\n"), (Lines{""}));
}

TEST(TextLines, WhatIsNoTextIsRefused) {
  EXPECT_EQ(LinesComplaint(std::string("\xFF\xFE"
                                       "0\0\n\0",
                                       6)),
            "a.txt: is text in UTF-16; save it as UTF-8");
  EXPECT_EQ(LinesComplaint(std::string("\xFE\xFF\0"
                                       "0\0\n",
                                       6)),
            "a.txt: is text in UTF-16; save it as UTF-8");
  const std::string refusal = ": is not text in UTF-8; give a text file, saved as UTF-8";
  EXPECT_EQ(LinesComplaint(std::string("a\nb\0c\n", 6)), "a.txt:2" + refusal);
  EXPECT_EQ(LinesComplaint(std::string(2 << 20, 'x')), "a.txt:1" + refusal);
}

TEST(TextLines, KnowWhereTheyAre) {
  std::istringstream stream("a\nb\n");
  TextLines lines(stream, "a.txt");
  lines.Next();
  lines.Next();
  EXPECT_EQ(lines.Number(), 2);
  EXPECT_EQ(lines.Where(), "a.txt:2");
}

}  // namespace
}  // namespace turnscale
