// SPDX-License-Identifier: MIT
#pragma once

#include <exception>
#include <string>
#include <string_view>

namespace turnscale {

/// Prints a line on standard error. Control characters, which the names and contents of bad files may hold, are escaped
/// (base/printable.h). A terminal that is gone is no reason to stop: nothing is thrown.
void PrintMessage(std::string_view line);

/// Prints lines for people on standard output, control characters other than line ends escaped. Throws OutputError
/// where the system refuses.
void PrintText(std::string_view lines);

/// Writes to standard output as it is, to the end. Throws OutputError where the system refuses.
void WriteStandardOutput(std::string_view text);

/// What an exception means to whoever started the program.
struct Failure {
  int exit_code = 1;    ///< 2 where the input cannot be used; 1 where the machine or we failed
  std::string message;  ///< one line: what, where, what to do
};

Failure FailureOf(const std::exception_ptr& thrown);

/// Prints "turnscale: " and the message, and returns the exit code.
int Report(const Failure& failure);

}  // namespace turnscale
