// SPDX-License-Identifier: MIT
#pragma once

#include <source_location>
#include <stdexcept>
#include <string>
#include <string_view>

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

/// A computation came to numbers that are none, or to a problem without a solution. Nobody's fault: whoever can do
/// without the result catches it. Where nobody can, the command line exits with code 1.
class NumericalError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Something that always holds does not: a mistake of ours, or of code that calls the library. The message says what
/// and where in the source. Nobody catches it but to save results; the command line exits with code 1.
class InternalError : public std::logic_error {
 public:
  explicit InternalError(std::string_view what, std::source_location where = std::source_location::current())
      : std::logic_error(std::string(what) + " at " + Place(where)) {}

 private:
  // "module/file.cpp:12": where the sources lie on the machine that compiled them is nobody's business.
  static std::string Place(const std::source_location& where) {
    std::string_view file = where.file_name();
    const size_t name = file.rfind('/');
    const size_t folder = name == std::string_view::npos || name == 0 ? name : file.rfind('/', name - 1);
    if (folder != std::string_view::npos) file.remove_prefix(folder + 1);
    return std::string(file) + ":" + std::to_string(where.line());
  }
};

/// Throws InternalError, with the place of the call, unless the condition holds. `broken` says what is wrong.
inline void Ensure(bool holds, std::string_view broken, std::source_location where = std::source_location::current()) {
  if (!holds) throw InternalError(broken, where);
}

}  // namespace turnscale
