// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <system_error>

#include "turnscale/base/error.h"

namespace turnscale {

/// Throws InputError if the output file is also an input file; empty paths are ignored.
inline void RefuseToOverwrite(const char* option, const std::filesystem::path& output,
                              std::initializer_list<std::filesystem::path> inputs) {
  for (const std::filesystem::path& input : inputs) {
    std::error_code none;
    if (output.empty() || input.empty() || !std::filesystem::equivalent(output, input, none)) continue;
    throw InputError(std::string(option) + " " + output.string() + ": is also an input file; name another one");
  }
}

}  // namespace turnscale
