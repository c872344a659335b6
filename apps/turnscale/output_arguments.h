// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <system_error>

#include "turnscale/base/error.h"

namespace turnscale {

/// Throws InputError where a file to be written is one of those that are read; empty paths are none.
inline void RefuseToOverwrite(const char* option, const std::filesystem::path& output,
                              std::initializer_list<std::filesystem::path> inputs) {
  for (const std::filesystem::path& input : inputs) {
    std::error_code none;
    if (output.empty() || input.empty() || !std::filesystem::equivalent(output, input, none)) continue;
    throw InputError(std::string(option) + " " + output.string() + ": is read as well; name another file");
  }
}

}  // namespace turnscale
