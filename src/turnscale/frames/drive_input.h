// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "turnscale/frames/bag_drive.h"

namespace turnscale {

/// Times of the frames in seconds, one per line; lines that are empty or begin with # are passed over.
struct FrameTimes {
  std::vector<double> times;
  std::vector<int> lines;  ///< where each stands in the file, from 1
};

/// Times that cannot be seconds are converted (SecondsPerUnit). Throws as RefuseSparseTimes, and InputError that names
/// the line where a time is no number, is NaN, goes back or repeats.
FrameTimes ReadFrameTimes(const std::filesystem::path& path);

/// Throws InputError that names the line where the file has fewer or more times than there are frames.
void CheckTimesMatch(const FrameTimes& times, const std::filesystem::path& path, size_t frames,
                     const std::string& frames_of);

/// Tells when a frame was taken.
struct FrameClock {
  std::vector<double> times;  ///< of every frame; empty where the rate tells
  double fps = 0;

  double At(size_t index) const { return times.empty() ? static_cast<double>(index) / fps : times[index]; }
};

/// What INPUT turned out to be: images in natural order, videos, or bags; and the files that came with them.
struct DriveInput {
  std::filesystem::path path;  ///< the folder that holds the images or videos, or the video or bag
  std::vector<std::filesystem::path> images;
  std::vector<std::filesystem::path> videos;  ///< one, or several that continue one another
  std::optional<BagDrive> bags;               ///< a topic of one, or of several that continue one another
  bool several_folders = false;               ///< the videos were found in more than one folder
  bool several_recordings = false;            ///< those found are of more than one, as their names tell (Chapter)
  std::optional<std::filesystem::path> camera_file;         ///< `calib.txt`, else `camera.yaml`, beside the images
  std::optional<std::filesystem::path> unused_camera_file;  ///< `camera.yaml`, where `calib.txt` is beside it
  std::optional<std::filesystem::path> times_file;          ///< `times.txt` beside the images
};

/// The order that people give numbered names: runs of digits compare as numbers, so 9.png comes before 10.png.
bool NaturalLess(std::string_view a, std::string_view b);

/// Detects the kind of INPUT: a KITTI folder (`image_0/` or `images/`, with `calib.txt` or
/// `camera.yaml`, and `times.txt`), a folder of images, a folder with videos, which continue one another in the
/// order of their names (ClipNameLess), the folder of a memory card with such folders in it, a video file, a bag, or
/// the folder that ROS 2 keeps a bag in (`metadata.yaml`). Images named like the videos beside them are passed over as
/// thumbnails. `topic`: of a bag's images, where it has several. `mask`: an image file that is not of the drive,
/// wherever it lies. Throws InputError where it is none of these, or holds both kinds, or images of several cameras
/// (RefuseSeveralSeries).
DriveInput FindDrive(const std::filesystem::path& input, const std::string& topic = {},
                     const std::filesystem::path& mask = {});

/// The same for several INPUTs, which have to be video files, or bags, that continue one another.
DriveInput FindDrive(const std::vector<std::filesystem::path>& inputs, const std::string& topic = {},
                     const std::filesystem::path& mask = {});

/// The value of an option that is a time of a drive: HH:MM:SS, MM:SS or seconds, each with or without decimals. Throws
/// InputError that names the option.
double ParseDriveTime(const std::string& option, std::string_view text);

}  // namespace turnscale
