// SPDX-License-Identifier: MIT
#pragma once

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include "turnscale/base/error.h"

namespace turnscale {

/// Throws InputError unless there is a file that is no folder. `kind` says what it should be, such as "camera file".
inline void CheckInputFile(const std::filesystem::path& path, std::string_view kind) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found)
    throw InputError(path.string() + ": no such " + std::string(kind));
  if (error) throw InputError(path.string() + ": cannot be read: " + error.message());
  if (is_directory(status)) throw InputError(path.string() + ": is a folder, not a " + std::string(kind));
}

/// The file opened for reading. Throws InputError that says why it cannot be.
inline std::ifstream OpenInputFile(const std::filesystem::path& path, std::string_view kind) {
  CheckInputFile(path, kind);
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (stream) return stream;
  const int cause = errno;
  throw InputError(path.string() + ": cannot be read" +
                   (cause == 0 ? std::string() : ": " + std::generic_category().message(cause)));
}

}  // namespace turnscale
