// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/keyframe_table.h"

#include <algorithm>
#include <string_view>

#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"

namespace turnscale {
namespace {

std::vector<std::string_view> Cells(std::string_view line) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  std::vector<std::string_view> cells;
  for (size_t start = 0; start <= line.size();) {
    const size_t comma = std::min(line.find(',', start), line.size());
    cells.push_back(line.substr(start, comma - start));
    start = comma + 1;
  }
  return cells;
}

size_t Column(const std::vector<std::string_view>& header, std::string_view column, const std::string& name) {
  const auto found = std::find(header.begin(), header.end(), column);
  if (found == header.end()) throw InputError(name + ": has no column '" + std::string(column) + "'");
  return static_cast<size_t>(found - header.begin());
}

template <typename Number>
Number Value(std::string_view cell, const std::string& where) {
  const auto value = ParseNumber<Number>(cell);
  if (!value) throw InputError(where + ": '" + std::string(cell) + "' is not a number");
  return *value;
}

}  // namespace

std::vector<KeyframeRow> ReadKeyframes(std::istream& table, const std::string& name) {
  std::string header_line;
  std::getline(table, header_line);
  const std::vector<std::string_view> header = Cells(header_line);
  const size_t frame = Column(header, "frame", name);
  const size_t time = Column(header, "time", name);
  const size_t keyframe = Column(header, "keyframe", name);
  const size_t turning = Column(header, "turning", name);

  std::vector<KeyframeRow> keyframes;
  std::string line;
  for (int number = 2; std::getline(table, line); ++number) {
    const std::vector<std::string_view> cells = Cells(line);
    const std::string where = name + ":" + std::to_string(number);
    if (cells.size() != header.size()) {
      throw InputError(where + ": has " + std::to_string(cells.size()) + " values, the first line has " +
                       std::to_string(header.size()));
    }
    if (Value<int>(cells[keyframe], where) == 0) continue;
    keyframes.push_back(
        {Value<int>(cells[frame], where), Value<double>(cells[time], where), Value<int>(cells[turning], where) != 0});
  }
  return keyframes;
}

}  // namespace turnscale
