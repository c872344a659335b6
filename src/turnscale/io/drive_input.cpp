// SPDX-License-Identifier: MIT
#include "turnscale/io/drive_input.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

#include "turnscale/base/error.h"
#include "turnscale/io/natural_order.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

bool HasExtension(const fs::path& path, std::initializer_list<std::string_view> extensions) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

bool IsImageName(const fs::path& path) {
  return HasExtension(path, {".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm", ".pnm", ".tif", ".tiff"});
}

bool IsVideoName(const fs::path& path) {
  return HasExtension(path, {".mp4", ".mkv", ".avi", ".mov", ".webm", ".m4v", ".mpg", ".mpeg", ".ts", ".wmv"});
}

template <class Predicate>
std::vector<fs::path> FilesIn(const fs::path& folder, const Predicate& wanted) {
  std::error_code error;
  std::vector<fs::path> files;
  fs::directory_iterator entries(folder, error);
  for (; !error && entries != fs::directory_iterator(); entries.increment(error)) {
    // A folder named like an image, and the hidden companions that some file systems write, are no frames.
    const fs::path& path = entries->path();
    if (wanted(path) && !entries->is_directory() && !path.filename().string().starts_with('.')) files.push_back(path);
  }
  if (error) throw InputError(folder.string() + ": cannot be listed: " + error.message());
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return NaturalLess(a.filename().string(), b.filename().string());
  });
  return files;
}

std::optional<fs::path> FileIn(const fs::path& folder, const char* name) {
  std::error_code error;
  return fs::is_regular_file(folder / name, error) ? std::optional(folder / name) : std::nullopt;
}

DriveInput FindInFolder(const fs::path& folder) {
  DriveInput drive;
  drive.path = folder;
  drive.camera_file = FileIn(folder, "calib.txt");
  if (!drive.camera_file) drive.camera_file = FileIn(folder, "camera.yaml");
  drive.times_file = FileIn(folder, "times.txt");
  if (FileIn(folder, "drive.yaml") && !drive.times_file) {
    throw InputError(folder.string() + ": is an incomplete simulated drive; simulate it again");
  }
  std::error_code error;
  for (const char* name : {"image_0", "images"}) {
    if (!fs::is_directory(folder / name, error)) continue;
    drive.path = folder / name;
    break;
  }
  drive.images = FilesIn(drive.path, IsImageName);
  if (!drive.images.empty()) return drive;
  const std::vector<fs::path> videos = FilesIn(folder, IsVideoName);
  if (videos.size() == 1 && drive.path == folder) {
    drive.path = videos.front();
    drive.is_video = true;
    return drive;
  }
  if (videos.size() > 1 && drive.path == folder) {
    throw InputError(folder.string() + ": holds " + std::to_string(videos.size()) + " videos; give one, such as " +
                     videos.front().string());
  }
  throw InputError(drive.path.string() +
                   ": holds no images; give a folder of png, jpg, bmp, pgm or tiff files, a KITTI "
                   "folder with image_0/, or a video file");
}

}  // namespace

DriveInput FindDrive(const fs::path& input) {
  std::error_code error;
  const fs::file_status status = fs::status(input, error);
  if (status.type() == fs::file_type::not_found) throw InputError(input.string() + ": no such file or folder");
  if (error) throw InputError(input.string() + ": cannot be opened: " + error.message());
  if (fs::is_directory(status)) return FindInFolder(input);
  if (IsImageName(input)) throw InputError(input.string() + ": is a single image; give the folder of the drive");
  DriveInput drive;
  drive.path = input;
  drive.is_video = true;
  return drive;
}

}  // namespace turnscale
