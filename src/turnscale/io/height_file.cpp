// SPDX-License-Identifier: MIT
#include "turnscale/io/height_file.h"

#include <cmath>

#include <fmt/format.h>

#include "turnscale/base/csv_table.h"
#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/io/time_unit.h"

namespace turnscale {

std::vector<PathHeight> ReadHeightFile(const std::filesystem::path& path) {
  CsvTable table(path, "file of heights");
  const std::size_t time = table.Column("time");
  const std::size_t height = table.Column("height");
  const bool has_sigma = table.HasColumn("sigma");
  const std::size_t sigma = has_sigma ? table.Column("sigma") : height;
  std::vector<PathHeight> heights;
  while (table.Next()) {
    PathHeight row = {table.Value<double>(time), table.Value<double>(height), kUsualHeightSigma};
    if (!std::isfinite(row.time) || !(row.height > 0 && std::isfinite(row.height)))
      throw InputError(fmt::format("{}: '{}, {}' is not a time and a height", table.Where(), Excerpt(table.Text(time)),
                                   Excerpt(table.Text(height))));
    if (has_sigma) row.sigma = table.Value<double>(sigma) / row.height;
    if (!(row.sigma > 0 && std::isfinite(row.sigma)))
      throw InputError(fmt::format("{}: sigma {} has to be positive", table.Where(), Excerpt(table.Text(sigma))));
    if (!heights.empty() && row.time <= heights.back().time)
      throw InputError(fmt::format("{}: time {} does not come after {}", table.Where(), row.time, heights.back().time));
    heights.push_back(row);
  }
  if (heights.empty()) throw InputError(path.string() + ": holds no heights");
  std::vector<double> times;
  for (const PathHeight& row : heights) times.push_back(row.time);
  const double unit = SecondsPerUnit(times);
  for (PathHeight& row : heights) row.time *= unit;
  return heights;
}

}  // namespace turnscale
