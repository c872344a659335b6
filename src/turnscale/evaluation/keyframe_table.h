// SPDX-License-Identifier: MIT
#pragma once

#include <istream>
#include <string>
#include <vector>

namespace turnscale {

/// One keyframe of the table that `turnscale run` writes as trajectory.csv.
struct KeyframeRow {
  int frame = 0;
  double time = 0;       ///< seconds
  bool turning = false;  ///< the step that led to it belongs to a turning region
};

/// The keyframes among the rows of a comma-separated table with the columns frame, time, keyframe and turning, found
/// by the names in its first line; other columns are passed over. `name` stands for the table in messages.
/// Throws InputError, with the line, when a column is missing or a value cannot be read.
std::vector<KeyframeRow> ReadKeyframes(std::istream& table, const std::string& name);

}  // namespace turnscale
