// SPDX-License-Identifier: MIT
#include "turnscale/base/csv_table.h"

#include <sstream>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

TEST(CsvTable, FindsColumnsAndQuotedCells) {
  std::istringstream stream("a,reason,b\r\n1,\"too slow, \"\"far\"\" too slow\",2.5\r\n,,3\n");
  CsvTable table(stream, "t.csv");
  ASSERT_TRUE(table.Next());
  EXPECT_EQ(table.Value<int>(table.Column("a")), 1);
  EXPECT_EQ(table.Text(table.Column("reason")), "too slow, \"far\" too slow");
  EXPECT_EQ(table.Value<double>(table.Column("b")), 2.5);
  ASSERT_TRUE(table.Next());
  EXPECT_FALSE(table.ValueOrNone<double>(0));
  EXPECT_EQ(table.ValueOrNone<double>(2), 3);
  EXPECT_FALSE(table.Next());
}

TEST(CsvTable, ReadsWhatPeopleAndSpreadsheetsWrite) {
  std::istringstream stream("\xEF\xBB\xBFtime, height ,note\r\n\r\n1 ,\t0.5, \" quoted, \" \n  \n2,, two words \n\n");
  CsvTable table(stream, "t.csv");
  ASSERT_TRUE(table.Next());
  EXPECT_EQ(table.Where(), "t.csv:3");
  EXPECT_EQ(table.Value<int>(table.Column("time")), 1);
  EXPECT_EQ(table.Value<double>(table.Column("height")), 0.5);
  EXPECT_EQ(table.Text(table.Column("note")), " quoted, ");
  ASSERT_TRUE(table.Next());
  EXPECT_EQ(table.Where(), "t.csv:5");
  EXPECT_FALSE(table.ValueOrNone<double>(1));
  EXPECT_EQ(table.Text(2), "two words");
  EXPECT_FALSE(table.Next());
  std::istringstream nothing("\n\n");
  CsvTable empty(nothing, "t.csv");
  EXPECT_FALSE(empty.HasColumn("time"));
  EXPECT_FALSE(empty.Next());
}

TEST(CsvTable, NamesWhatIsWrong) {
  std::istringstream stream("a,b\n1\nx,2\n");
  CsvTable table(stream, "t.csv");
  const auto message = [](const auto& call) {
    try {
      call();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(message([&] { table.Column("c"); }), "t.csv: has no column 'c'");
  EXPECT_EQ(message([&] { table.Next(); }), "t.csv:2: has 1 values, the first line has 2");
  std::istringstream semicolons("time;height\n1;0,5\n");
  EXPECT_EQ(message([&] { CsvTable(semicolons, "t.csv").Column("time"); }),
            "t.csv: has no column 'time', but 'time;height'; separate columns by commas, and write decimal points");
  EXPECT_TRUE(table.Next());
  EXPECT_EQ(message([&] { table.Value<double>(0); }), "t.csv:3: 'x' is not a number");
}

}  // namespace
}  // namespace turnscale
