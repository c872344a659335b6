// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace turnscale {

/// The executable of this process.
std::filesystem::path ProgramFile();

/// A file that the program needs, by its path from the program's folder: `installed`, or `built` in the build folder.
/// Empty where neither exists.
std::filesystem::path FindBesideProgram(const std::filesystem::path& installed, const std::filesystem::path& built);

/// Adds a sub-command that another program carries out: its arguments, --help among them, stay as they are.
CLI::App* AddUnparsedCommand(CLI::App& app, const std::string& name, const std::string& what);

/// Goes on as the program that the first word names, by path or by a name in PATH, with the words as its arguments.
/// Returns only if that fails: the cause.
std::string ReplaceProcess(std::vector<std::string> words);

}  // namespace turnscale
