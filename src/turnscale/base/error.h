// SPDX-License-Identifier: MIT
#pragma once

#include <exception>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

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
/// without the result catches it. Where none can, the command line exits with code 1.
class NumericalError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A place in the source. As a default argument, `Here` is where the function is called. (Clang 14 has no
/// std::source_location.)
struct SourcePlace {
  const char* file;
  int line;

  static constexpr SourcePlace Here(const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    return {file, line};
  }

  /// "module/file.cpp:12": the path of the sources on the machine that compiled them is left out.
  std::string Text() const {
    std::string_view name = file;
    const size_t base = name.rfind('/');
    const size_t folder = base == std::string_view::npos || base == 0 ? base : name.rfind('/', base - 1);
    if (folder != std::string_view::npos) name.remove_prefix(folder + 1);
    return std::string(name) + ":" + std::to_string(line);
  }
};

/// Something that always holds does not: a bug of turnscale, or of code that calls the library. The message says what
/// and where in the source. Nobody catches it but to save results; the command line exits with code 1.
class InternalError : public std::logic_error {
 public:
  explicit InternalError(std::string_view what, SourcePlace where = SourcePlace::Here())
      : std::logic_error(std::string(what) + " at " + where.Text()) {}
};

/// Throws InternalError, with the place of the call, unless the condition holds. `broken` says what is wrong.
inline void Ensure(bool holds, std::string_view broken, SourcePlace where = SourcePlace::Here()) {
  if (!holds) throw InternalError(broken, where);
}

/// Does one thing after another whatever becomes of each, and keeps what they threw.
class Attempts {
 public:
  /// Returns whether `work` came to its end.
  template <class Work>
  bool Try(const Work& work) {
    try {
      work();
      return true;
    } catch (...) {
      failures_.push_back(std::current_exception());
      return false;
    }
  }

  /// In the order of time.
  const std::vector<std::exception_ptr>& failures() const { return failures_; }

  /// Throws the first failure, if there was one.
  void RethrowFirst() const {
    if (!failures_.empty()) std::rethrow_exception(failures_.front());
  }

 private:
  std::vector<std::exception_ptr> failures_;
};

}  // namespace turnscale
