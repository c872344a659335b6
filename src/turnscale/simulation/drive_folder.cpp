// SPDX-License-Identifier: MIT
#include "turnscale/simulation/drive_folder.h"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/io/output_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMarker = "# Made by turnscale simulate, which replaces the drive in this folder when told to.";
constexpr const char* kMarkedFile = "drive.yaml";
constexpr const char* kImages = "image_0";
// Times and poses first: they say that the rest is whole.
constexpr const char* kFiles[] = {"times.txt", "poses.txt",   "truth.csv",    "floor_plan.csv",
                                  "calib.txt", "camera.yaml", "vehicle.yaml", "rig.yaml"};

bool Exists(const fs::path& path) {
  std::error_code error;
  return fs::exists(fs::symlink_status(path, error)) && !error;
}

bool IsOurs(const fs::path& folder) {
  std::ifstream stream(folder / kMarkedFile);
  std::string line;
  return std::getline(stream, line) && line == kMarker;
}

void RefuseForeign(const fs::path& folder) {
  std::error_code error;
  if (Exists(folder) && !fs::is_directory(folder, error)) {
    throw InputError(folder.string() + ": is a file, but the drive needs a folder; choose another --out");
  }
  if (IsOurs(folder)) return;
  const auto refuse = [&](const std::string& name) {
    throw InputError((folder / name).string() + ": does not belong to a simulated drive; choose another --out");
  };
  for (const char* name : kFiles) {
    if (Exists(folder / name)) refuse(name);
  }
  if (Exists(folder / kMarkedFile)) refuse(kMarkedFile);
  const fs::path images = folder / kImages;
  if (Exists(images) && !(fs::is_directory(images, error) && fs::is_empty(images, error))) refuse(kImages);
}

bool IsImageOfDrive(const fs::path& path) {
  // A recording that was killed leaves a part of one.
  const fs::path image = path.extension() == PartOf("").string() ? path.stem() : path;
  const std::string number = image.stem().string();
  return image.extension() == ".png" &&
         std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; });
}

void RemoveDrive(const fs::path& folder) {
  for (const char* name : kFiles) {
    RemoveOldFile(folder / name);
  }
  for (const auto& entry : fs::directory_iterator(folder / kImages)) {
    if (IsImageOfDrive(entry.path())) fs::remove(entry.path());
  }
}

std::string Quoted(const std::string& text) {
  std::string quoted(1, '"');
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace

std::string DriveText(const DriveOrigin& origin, unsigned seed) {
  std::string text = std::string(kMarker) + "\n";
  text += fmt::format("version: {}\nworld: {}\nseed: {}\n", Quoted(origin.version), Quoted(origin.world), seed);
  if (origin.seconds) text += fmt::format("seconds: {}\n", *origin.seconds);
  if (origin.follow) text += fmt::format("follow: {}\n", Quoted(origin.follow->string()));
  return text + fmt::format("texture_contrast: {}\n", origin.texture_contrast);
}

void PrepareDriveFolder(const fs::path& folder) {
  RefuseForeign(folder);
  std::error_code error;
  fs::create_directories(folder / kImages, error);
  if (error) throw InputError(folder.string() + ": cannot be made: " + error.message() + "; choose another --out");
  try {
    RemoveDrive(folder);
  } catch (const fs::filesystem_error& failure) {
    throw InputError(folder.string() + ": cannot be cleared: " + failure.code().message() + "; choose another --out");
  }
}

}  // namespace turnscale
