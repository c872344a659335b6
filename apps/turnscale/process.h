// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace turnscale {

/// The executable of this process.
std::filesystem::path ProgramFile();

/// Goes on as the program that the first word names, by path or by a name in PATH, with the words as its arguments.
/// Returns only if that fails: the cause.
std::string ReplaceProcess(std::vector<std::string> words);

}  // namespace turnscale
