// SPDX-License-Identifier: MIT
#include "turnscale/io/range_check.h"

#include <fmt/format.h>

#include "turnscale/base/error.h"

namespace turnscale {

void CheckRange(const char* field, double value, double low, double high, const char* unit) {
  // Refuses what is not a number, too.
  if (value >= low && value <= high) return;
  const char* space = *unit == '\0' ? "" : " ";
  throw InputError(fmt::format("{}: is {}; it has to be in {}...{}{}{}", field, value, low, high, space, unit));
}

}  // namespace turnscale
