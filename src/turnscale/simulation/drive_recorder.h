// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "turnscale/simulation/rig.h"
#include "turnscale/simulation/world.h"

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

/// Makes the folder and, if it is for `images`, its `image_0/`, and removes the drive that a recording has left there;
/// `drive.yaml` stays. Throws InputError, and touches nothing, where it has the results of a run, or files named like
/// those of a drive without a `drive.yaml` of ours, or where it cannot be made or cleared.
void PrepareDriveFolder(const std::filesystem::path& folder, bool images);

struct RecordOptions {
  std::filesystem::path folder;
  std::optional<int> max_frames = {};  ///< stop the recording early
  int threads = 2;                     ///< that draw an image; the files do not depend on them
  DriveOrigin origin = {};             ///< of the world, for `drive.yaml`
};

/// Summary of a recording.
struct Recording {
  int frames = 0;      ///< written
  double seconds = 0;  ///< from the first image to the last
  double metres = 0;   ///< path length of the camera
  double turned = 0;   ///< angle that the car has turned through, to either side, radians
  bool complete = false;
};

/// Is told the frames written so far and those to come in all; says whether to go on. It is asked with 0 frames twice,
/// before the scene is lit and after.
using RecordProgress = std::function<bool(int frames_done, int frames)>;

/// Drives a rig through a world and writes what its camera sees as a KITTI folder: `image_0/`, or `video.mp4` if the
/// rig records one; `calib.txt` (where the lens has no distortion), `times.txt` (of exposure; the video's stamps may
/// stray) and `poses.txt`; beside them `camera.yaml`, `vehicle.yaml`, `truth.csv`, `floor_plan.csv`, `rig.yaml` and
/// `drive.yaml`. `times.txt` and `poses.txt` come last, so that a folder without them is of no use to anybody. An
/// earlier recording in the folder is replaced.
///
/// Throws InputError where the rig or the options make no sense, the car cannot drive the world's legs (naming
/// `origin.follow` where there is one), or the folder cannot be made or holds such files of another origin, OutputError
/// where the system refuses to write. What is there of an earlier recording is then untouched, but for OutputError.
Recording RecordDrive(World world, const Rig& rig, unsigned seed, const RecordOptions& options,
                      const RecordProgress& progress);

}  // namespace turnscale
