// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/base/test_files.h"

namespace turnscale {

/// What a run of the built command line left behind.
struct CommandResult {
  int exit_code = -1;  ///< -1 where a signal ended it
  std::string out;
  std::string err;

  /// Lines of `err` that begin with "turnscale: ".
  std::vector<std::string> Complaints() const;
};

/// A run of the built `turnscale` that goes on beside the test.
class Command {
 public:
  /// Keeps what it prints in files below `folder`; where `out` is given, standard output goes there and is not kept.
  /// No file of it grows beyond `largest_file` bytes, as if the disk were full then. `nohup`: it ignores SIGHUP.
  Command(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
          const std::filesystem::path& out = {}, std::optional<unsigned> largest_file = {}, bool nohup = false);
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;
  ~Command();

  /// Waits until standard error holds the text; false where the run ends, or minutes pass, without it.
  bool WaitForError(const std::string& text) const;
  void Signal(int signal) const;
  CommandResult Wait();

 private:
  std::filesystem::path out_;
  std::filesystem::path err_;
  int process_ = -1;
};

/// Runs `turnscale` to its end.
CommandResult RunCommand(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                         const std::filesystem::path& out = {});

/// Fails the test unless the command ended with the code, and all of standard error is one line that holds the parts.
void ExpectComplaint(const CommandResult& result, int exit_code, const std::vector<std::string>& parts);

}  // namespace turnscale
