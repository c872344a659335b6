// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "turnscale/base/error.h"

namespace turnscale {

/// A sub-command that this build comes without: not in the help, and its call, whatever its arguments, says what
/// enables it.
inline void AddMissingCommand(CLI::App& app, const std::string& name, const std::string& what,
                              const std::string& option) {
  CLI::App* command = app.add_subcommand(name)->group("")->prefix_command();
  command->set_help_flag();
  command->parse_complete_callback([name, what, option] {
    throw InputError(name + ": this build has no " + what + "; configure it with -D" + option + "=ON");
  });
}

}  // namespace turnscale
