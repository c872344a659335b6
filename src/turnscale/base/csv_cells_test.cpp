// SPDX-License-Identifier: MIT
#include "turnscale/base/csv_cells.h"

#include <cmath>
#include <sstream>

#include <gtest/gtest.h>

#include "turnscale/base/csv_table.h"

namespace turnscale {
namespace {

TEST(CsvCells, QuotedTextReadsBack) {
  EXPECT_EQ(QuotedCell(""), "");
  EXPECT_EQ(QuotedCell("too fast"), "\"too fast\"");
  for (const char* text : {"too fast, \"by far\"", " blanks ", "\"", ","}) {
    std::istringstream stream("reason,next\n" + QuotedCell(text) + ",1\n");
    CsvTable table(stream, "t.csv");
    ASSERT_TRUE(table.Next());
    EXPECT_EQ(table.Text(0), text);
  }
}

TEST(CsvCells, OnlyPositiveNumbersFillACell) {
  EXPECT_EQ(PositiveCell(0.012345678), "0.0123457");
  EXPECT_EQ(PositiveCell(12345678), "1.23457e+07");
  EXPECT_EQ(PositiveCell(1e-7), "1e-07");
  EXPECT_EQ(PositiveCell(1.0 / 3, 9), "0.333333333");
  EXPECT_EQ(PositiveCell(2), "2");
  for (const double value : {0.0, -1.0, std::nan(""), HUGE_VAL}) EXPECT_EQ(PositiveCell(value), "") << value;
}

}  // namespace
}  // namespace turnscale
