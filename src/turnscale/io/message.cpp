// SPDX-License-Identifier: MIT
#include "turnscale/io/message.h"

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <new>
#include <system_error>

#include <opencv2/core.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/printable.h"

namespace turnscale {
namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;

// Libraries complain in several lines.
std::string InOneLine(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\n' || c == '\r' || c == '\t';
    if (!blank) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  if (line.ends_with(' ')) line.pop_back();
  return line;
}

Failure OutOfMemory() { return {kFailed, "out of memory; close other programs, or use a machine with more"}; }

Failure Internal(std::string_view what) {
  return {kFailed, "internal error: " + InOneLine(what) + "; please report it with the command and its input"};
}

}  // namespace

void PrintMessage(std::string_view line) {
  const std::string text = Printable(line) + "\n";
  std::fwrite(text.data(), 1, text.size(), stderr);
}

void PrintText(std::string_view lines) { WriteStandardOutput(Printable(lines, "\n")); }

void WriteStandardOutput(std::string_view text) {
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    throw OutputError("standard output: cannot be written: " + std::generic_category().message(errno));
  }
}

Failure FailureOf(const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const InputError& error) {
    return {kBadInput, error.what()};
  } catch (const OutputError& error) {
    return {kFailed, error.what()};
  } catch (const std::filesystem::filesystem_error& error) {
    return {kFailed, error.path1().string() + ": " + error.code().message()};
  } catch (const std::bad_alloc&) {
    return OutOfMemory();
  } catch (const cv::Exception& error) {
    return error.code == cv::Error::StsNoMem ? OutOfMemory() : Internal(error.what());
  } catch (const std::exception& error) {
    return Internal(error.what());
  } catch (...) {
    return Internal("something was thrown that is no exception");
  }
}

int Report(const Failure& failure) {
  PrintMessage("turnscale: " + failure.message);
  return failure.exit_code;
}

}  // namespace turnscale
