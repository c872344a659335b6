// SPDX-License-Identifier: MIT
#include "process.h"

#include <cerrno>
#include <system_error>

#include <unistd.h>

#include "turnscale/base/error.h"

namespace turnscale {

std::filesystem::path ProgramFile() {
  std::error_code error;
  std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) throw InternalError("the program cannot find itself: " + error.message());
  return program;
}

std::string ReplaceProcess(std::vector<std::string> words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  execvp(pointers[0], pointers.data());
  return std::system_category().message(errno);
}

}  // namespace turnscale
