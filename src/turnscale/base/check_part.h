// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/base/error.h"

namespace turnscale {

/// Throws InputError with `what` unless the condition holds: "field: why", as below.
inline void Require(bool holds, const std::string& what) {
  if (!holds) throw InputError(what);
}

/// Checks options that are part of others. Throws InputError that names the field as "`prefix`field": the check of a
/// part knows its fields, only the owner knows where the part stands.
///
/// The Check() of any options says "field: why". `why` either begins with the value ("is 3; give ...", "3 has to be
/// ...") or leaves it out, best in words that go on after "it" ("has to be above 0", "must not be negative"): for
/// options from a file, the reader of the file puts "is 3; it" before these words (config/yaml_map.h).
template <class Options>
void CheckPart(const std::string& prefix, const Options& options) {
  try {
    options.Check();
  } catch (const InputError& error) {
    throw InputError(prefix + error.what());
  }
}

}  // namespace turnscale
