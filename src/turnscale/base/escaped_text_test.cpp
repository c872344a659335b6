// SPDX-License-Identifier: MIT
#include "turnscale/base/escaped_text.h"

#include <string>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(Printable, LeavesWhatATerminalShows) {
  for (const char* text : {"", "plain ~ text", "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x9a\x97", "C:\\drive", "\xc2\xa0"}) {
    EXPECT_EQ(Printable(text), text);
  }
}

TEST(Printable, EscapesWhatATerminalObeys) {
  EXPECT_EQ(Printable("\x1b[2J"), "\\x1b[2J");
  EXPECT_EQ(Printable("a\r\n\tb\x07\x7f"), "a\\x0d\\x0a\\x09b\\x07\\x7f");
  EXPECT_EQ(Printable(std::string_view("\0z", 2)), "\\x00z");
  EXPECT_EQ(Printable("\xc2\x9b"
                      "31m"),
            "\\xc2\\x9b31m")
      << "CSI in one character";
  EXPECT_EQ(Printable("two\nlines\t\x1b", "\n\t"), "two\nlines\t\\x1b");
}

TEST(Printable, EscapesWhatIsNoUtf8) {
  EXPECT_EQ(Printable("caf\xe9"), "caf\\xe9");
  EXPECT_EQ(Printable("\x9b"
                      "31m"),
            "\\x9b31m");
  EXPECT_EQ(Printable("\xe2\x82"), "\\xe2\\x82") << "cut off";
  EXPECT_EQ(Printable("\xe2\x1b["), "\\xe2\\x1b[") << "the escape is not swallowed";
  EXPECT_EQ(Printable("\xc0\x9b\xe0\x80\x9b"), "\\xc0\\x9b\\xe0\\x80\\x9b") << "longer than it has to be";
  EXPECT_EQ(Printable("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "half of a pair";
  EXPECT_EQ(Printable("\xf4\x90\x80\x80\xf5"), "\\xf4\\x90\\x80\\x80\\xf5") << "beyond Unicode";
}

TEST(Excerpt, IsPrintableAndShort) {
  EXPECT_EQ(Excerpt("1.5\x1b"), "1.5\\x1b");
  EXPECT_EQ(Excerpt(std::string(40, 'a')), std::string(40, 'a'));
  EXPECT_EQ(Excerpt(std::string(41, 'a')), std::string(40, 'a') + "...");
  EXPECT_EQ(Excerpt(std::string(39, 'a') + "\xe2\x82\xac" + "b"), std::string(39, 'a') + "\xe2\x82\xac...")
      << "no character is cut";
}

TEST(EscapedXml, HoldsOnlyWhatXmlCan) {
  EXPECT_EQ(EscapedXml("a < b & c ]]> caf\xc3\xa9"), "a &lt; b &amp; c ]]&gt; caf\xc3\xa9");
  EXPECT_EQ(EscapedXml("\x1b[2J\xff"), "\\x1b[2J\\xff");
  EXPECT_EQ(EscapedXml("\xef\xbf\xbe \xef\xbf\xbf \xef\xbf\xbd"), "\\xef\\xbf\\xbe \\xef\\xbf\\xbf \xef\xbf\xbd");
}

TEST(QuotedYaml, HoldsOnlyWhatYamlCan) {
  EXPECT_EQ(QuotedYaml("C:\\a \"drive\": caf\xc3\xa9"), "\"C:\\\\a \\\"drive\\\": caf\xc3\xa9\"");
  EXPECT_EQ(QuotedYaml("caf\xe9\n\x1b\xef\xbf\xbf"), "\"caf\\\\xe9\\\\x0a\\\\x1b\\\\xef\\\\xbf\\\\xbf\"");
}

}  // namespace
}  // namespace turnscale
