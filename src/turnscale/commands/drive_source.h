// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/calibration/camera_axes.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/commands/command_hooks.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/frames/image_scaling.h"
#include "turnscale/frames/image_source.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/io/terminal.h"

namespace turnscale {

/// Threads that OpenCV may use by default. The library leaves the number to the program.
constexpr int kImageThreads = 2;

/// A camera that is given, and where.
struct GivenCamera {
  std::string name;  ///< of the file, or of the bag and its topic; empty where no camera is given
  CameraModel model;
  /// It came with the images, so that it is that of the images as they are stored. `--camera` is that of the rotated
  /// ones.
  bool is_of_stored = false;
};

/// Arguments common to the commands that run the odometry on images, by the names of the program's options.
struct ImageArguments {
  std::vector<std::filesystem::path> inputs;  ///< one, or videos or bags that continue one another
  std::string topic;                          ///< of a bag's images; empty: the only one
  std::optional<std::filesystem::path> camera;
  std::optional<GivenCamera> camera_object;  ///< in place of a file, where a program has it
  std::optional<double> field_of_view;       ///< horizontal, degrees; estimate the intrinsics, starting there
  bool refine_camera = false;                ///< estimate the intrinsics, starting from the given ones
  std::optional<std::filesystem::path> timestamps;
  std::optional<double> fps;
  int rotate = 0;  ///< of the images, degrees clockwise
  std::optional<std::filesystem::path> settings;
  std::optional<std::filesystem::path> mask;  ///< of the rotated images
  std::string start;  ///< of the part of the drive to process, as ParseDriveTime reads it; empty: the drive's
  std::string end;    ///< of the part; empty: the drive's
  std::optional<int> max_frames;
  bool quiet = false;

  /// The input for messages and reports.
  std::string Name() const;
};

/// Throws InputError where arguments exclude one another, or one is out of range.
void CheckImageArguments(const ImageArguments& arguments);

/// How the images of a drive are read, as the arguments have it.
ImageSourceOptions SourceOptions(const ImageArguments& arguments, const GivenCamera& given,
                                 const ImageOptions& image_options);

/// The images of a drive and their camera.
struct DriveImages {
  DriveInput drive;
  GivenCamera given;  ///< that of the rotated images, at full size
  ImageSource source;
  cv::Size full_size;    ///< of the images; empty where not one can be read
  ImageScaling scaling;  ///< of the images, the mask and the camera
  CameraModel camera;    ///< that is given, later the estimated one; at the size that is processed
  cv::Mat mask;          ///< at the same size; pixels to leave out are 0 (ReadMask); empty where none is given
  int expected = 0;      ///< number of frames, limited by `max_frames`; 0 if unknown
};

/// `image_options`: how the images are scaled. Throws InputError where there are no images or no times, or the mask
/// cannot be read or is not of their size.
DriveImages OpenImages(const ImageArguments& arguments, const ImageOptions& image_options);

/// Warnings before the first frame, one line each: clips that are left out; images that are missing; a calibration
/// beside the input that is not used, or that contradicts the one that is; images that are too small; coefficients that
/// may be of a fisheye lens (DoubtOfLens); a principal point far from their centre where the calibration has no image
/// size to check; pixels of another shape than the video says.
std::vector<std::string> WarningsOf(const ImageArguments& arguments, const DriveImages& images);

struct TimedTrajectory {
  Trajectory poses;
  bool timed = true;  ///< else the poses carry their frames' numbers as times
  /// The file's own times are whole numbers: of seconds, or of frames.
  bool whole_numbers = false;
};

/// Reads a trajectory with its times, seconds: its own (TUM, EuRoC), or for KITTI's poses those of `timestamps`, of so
/// many frames a second, or of the times.txt that FindPoseTimes finds. Own times that are whole numbers may be those of
/// frames, so many a second. Throws InputError, also where times are given for a file that has its own.
TimedTrajectory ReadTimedTrajectory(const std::filesystem::path& path,
                                    const std::optional<std::filesystem::path>& timestamps, std::optional<double> fps);

/// Camera motion of a drive, from images or from a trajectory file.
struct DriveMotion {
  std::string input;                  ///< as the user named it
  std::vector<Trajectory> stretches;  ///< segments of uninterrupted tracking, in one unit of length
  bool timed = true;                  ///< false: times are assumed
  /// Of lengths across turns, due to the errors of the intrinsics and to blended images; relative, a standard
  /// deviation.
  double calibration_sigma = 0;
  std::string incomplete;          ///< why the path length is incomplete; empty if complete
  std::optional<Failure> stopped;  ///< why the drive was not processed to its end; empty if it was
  std::string note;                ///< one line for the user; may be empty
};

/// Reads a TUM, KITTI or EuRoC trajectory and converts vehicle axes, given or detected, to camera axes.
/// KITTI poses without timestamps are assumed to be 10 per second. Throws InputError.
DriveMotion MotionFromTrajectory(const std::filesystem::path& path,
                                 const std::optional<std::filesystem::path>& timestamps, std::optional<double> fps,
                                 std::optional<AxisConvention> axes);

/// Runs the odometry on the images, without lever arm and camera height: the result is up to scale. An interrupt or an
/// exception ends the drive there; the exception is thrown on if there is no motion yet. Throws Interruption while the
/// camera is estimated.
DriveMotion MotionFromImages(const ImageArguments& arguments, const CommandHooks& hooks);

}  // namespace turnscale
