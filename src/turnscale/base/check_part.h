// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/base/error.h"

namespace turnscale {

/// Checks options that are part of others. Throws InputError that names the field as "`prefix`field": the check of a
/// part knows its fields, only the owner knows where the part stands.
template <class Options>
void CheckPart(const std::string& prefix, const Options& options) {
  try {
    options.Check();
  } catch (const InputError& error) {
    throw InputError(prefix + error.what());
  }
}

}  // namespace turnscale
