// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>

namespace turnscale {

/// What the user gave cannot be used: a file, a key, a value. The message is one line that says what, where, and what
/// to do about it. The command line prints it and exits with code 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The machine refused to keep a result (disk full, file vanished). One line; the command line exits with code 1.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace turnscale
