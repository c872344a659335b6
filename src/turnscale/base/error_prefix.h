// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/base/error.h"

namespace turnscale {

/// Does `work`. An InputError of it gets the prefix before its message: checks of a part name what is wrong in the
/// part, only the owner knows where the part stands.
template <class Work>
void PrefixErrors(const std::string& prefix, const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    throw InputError(prefix + error.what());
  }
}

/// Checks options that are part of others. The message names the field as "`prefix`field".
template <class Options>
void CheckPart(const std::string& prefix, const Options& options) {
  PrefixErrors(prefix, [&] { options.Check(); });
}

}  // namespace turnscale
