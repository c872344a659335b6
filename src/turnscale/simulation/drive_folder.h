// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace turnscale {

/// What a recorded drive was made from, its rig apart.
struct DriveOrigin {
  std::string version;  ///< of the program
  std::string world;    ///< garage or street
  std::optional<double> seconds = {};
  std::optional<std::filesystem::path> follow = {};  ///< file of the path that the street is laid along
  double texture_contrast = 1;
};

/// `drive.yaml`: the origin, and a first line that tells a folder of ours from any other.
std::string DriveText(const DriveOrigin& origin, unsigned seed);

/// Makes the folder and its `image_0/`, and removes the drive that a recording has left there; `drive.yaml` stays.
/// Throws InputError, and touches nothing, where it holds files named like those of a drive and a `drive.yaml` of ours
/// is not among them, or where it cannot be made or cleared.
void PrepareDriveFolder(const std::filesystem::path& folder);

}  // namespace turnscale
