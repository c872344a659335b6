// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/text_lines.h"

namespace turnscale {

/// A comma-separated table with a heading, read line by line. Cells may be quoted; a quoted cell ends in its line.
/// Blanks around a cell and empty lines are passed over.
class CsvTable {
 public:
  /// `name` stands for the table in messages.
  CsvTable(std::istream& stream, std::string name) : lines_(stream, std::move(name)) { ReadHeading(); }

  /// Throws InputError where the file cannot be opened. `kind` says what it should be, such as "file of heights".
  CsvTable(const std::filesystem::path& path, std::string_view kind) : lines_(path, kind) { ReadHeading(); }

  /// The column's place. Throws InputError if there is none of that name.
  std::size_t Column(std::string_view column) const {
    const auto found = std::find(columns_.begin(), columns_.end(), column);
    if (found == columns_.end()) {
      // As spreadsheets write tables where the comma is the decimal point.
      const bool parted = columns_.size() == 1 && columns_[0].find_first_of(";\t") != std::string::npos;
      throw InputError(
          lines_.Name() + ": has no column '" + std::string(column) + "'" +
          (parted ? ", but '" + Excerpt(columns_[0]) + "'; separate columns by commas, and write decimal points"
                  : SimilarColumn(column)));
    }
    return static_cast<std::size_t>(found - columns_.begin());
  }

  bool HasColumn(std::string_view column) const {
    return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
  }

  /// Goes to the next line; false at the end. Throws InputError if it has more or fewer cells than the heading.
  bool Next() {
    if (!ReadLine()) return false;
    Split();
    if (cells_.size() != columns_.size()) {
      throw InputError(Where() + ": has " + std::to_string(cells_.size()) + " values, the first line has " +
                       std::to_string(columns_.size()));
    }
    return true;
  }

  const std::string& Text(std::size_t column) const { return cells_[column]; }

  /// The number in a cell. Throws InputError if it holds none.
  template <typename Number>
  Number Value(std::size_t column) const {
    const auto value = ParseNumber<Number>(cells_[column]);
    if (!value) throw InputError(Where() + ": '" + Excerpt(cells_[column]) + "' is not a number");
    return *value;
  }

  /// The same; nothing for an empty cell.
  template <typename Number>
  std::optional<Number> ValueOrNone(std::size_t column) const {
    return cells_[column].empty() ? std::nullopt : std::optional(Value<Number>(column));
  }

  /// "name:line" of the current line.
  std::string Where() const { return lines_.Where(); }

 private:
  static bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

  // One whose name is longer or shorter, such as "time_ms" for "time"; empty if there is none.
  std::string SimilarColumn(std::string_view column) const {
    const auto similar = std::find_if(columns_.begin(), columns_.end(), [&](const std::string& name) {
      return !name.empty() && (name.starts_with(column) || column.starts_with(name));
    });
    return similar == columns_.end() ? "" : ", but '" + Excerpt(*similar) + "'";
  }

  void ReadHeading() {
    if (ReadLine()) Split();
    columns_ = cells_;
  }

  // The next line that is not empty; false at the end.
  bool ReadLine() {
    while (lines_.Next())
      if (!std::all_of(lines_.Line().begin(), lines_.Line().end(), IsBlank)) return true;
    return false;
  }

  void Split() {
    const std::string& line = lines_.Line();
    cells_.assign(1, {});
    bool quoted = false;
    std::size_t length = 0;  // of the cell without the blanks that may be its last
    for (std::size_t i = 0; i < line.size(); ++i) {
      std::string& cell = cells_.back();
      if (line[i] == ',' && !quoted) {
        cell.resize(length);
        length = 0;
        cells_.emplace_back();
      } else if (IsBlank(line[i]) && !quoted) {
        if (!cell.empty()) cell += line[i];
      } else {
        const bool doubled = quoted && line.compare(i, 2, "\"\"") == 0;
        if (doubled || line[i] != '"') {
          cell += line[i];
          i += doubled ? 1 : 0;
        } else {
          quoted = !quoted;
        }
        length = cell.size();
      }
    }
    cells_.back().resize(length);
  }

  TextLines lines_;
  std::vector<std::string> columns_;
  std::vector<std::string> cells_;
};

}  // namespace turnscale
