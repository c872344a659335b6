// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/base/error.h"

namespace turnscale {

/// The field that `Options::Check` names after `change` was made to the defaults, for tests; empty where it accepts
/// all of them.
template <typename Options, typename Change>
std::string RefusedField(Change change) {
  Options options;
  change(options);
  try {
    options.Check();
  } catch (const InputError& error) {
    const std::string message = error.what();
    return message.substr(0, message.find(':'));
  }
  return "";
}

}  // namespace turnscale
