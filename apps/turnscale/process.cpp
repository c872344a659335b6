// SPDX-License-Identifier: MIT
#include "process.h"

#include <cerrno>
#include <system_error>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "turnscale/base/error.h"

namespace turnscale {

std::filesystem::path ProgramFile() {
  std::error_code error;
  std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) throw InternalError("the program cannot find itself: " + error.message());
  return program;
}

std::filesystem::path FindBesideProgram(const std::filesystem::path& installed, const std::filesystem::path& built) {
  const std::filesystem::path folder = ProgramFile().parent_path();
  for (const std::filesystem::path& candidate : {folder / installed, folder / built}) {
    std::error_code none;
    if (std::filesystem::exists(candidate, none)) return candidate;
  }
  return {};
}

CLI::App* AddUnparsedCommand(CLI::App& app, const std::string& name, const std::string& what) {
  CLI::App* command = app.add_subcommand(name, what)->prefix_command();
  command->set_help_flag();
  return command;
}

std::string ReplaceProcess(std::vector<std::string> words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  execvp(pointers[0], pointers.data());
  return std::system_category().message(errno);
}

}  // namespace turnscale
