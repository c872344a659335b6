// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/keyframe_table.h"

#include <cstddef>

#include "turnscale/base/csv_table.h"

namespace turnscale {

std::vector<KeyframeRow> ReadKeyframes(std::istream& table, const std::string& name) {
  CsvTable rows(table, name);
  const size_t frame = rows.Column("frame");
  const size_t time = rows.Column("time");
  const size_t keyframe = rows.Column("keyframe");
  const size_t turning = rows.Column("turning");
  std::vector<KeyframeRow> keyframes;
  while (rows.Next()) {
    if (rows.Value<int>(keyframe) == 0) continue;
    keyframes.push_back({rows.Value<int>(frame), rows.Value<double>(time), rows.Value<int>(turning) != 0});
  }
  return keyframes;
}

}  // namespace turnscale
