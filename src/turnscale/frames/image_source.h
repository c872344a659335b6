// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/frames/drive_input.h"
#include "turnscale/frames/image_scaling.h"

namespace turnscale {

/// One frame of a drive.
struct SourceFrame {
  int index = 0;        ///< from 0 at the first one read, without gaps, whatever the file names count
  double time = 0;      ///< seconds
  cv::Mat gray;         ///< 8-bit gray; empty if the image is unusable
  std::string problem;  ///< why there is no image: "name: why"
  std::string notice;   ///< what the user should know about the drive before this frame, such as a gap; may be empty
};

/// A video or bag of a drive, as far as it was read.
struct ClipPart {
  std::string file;
  double start = 0;  ///< time of its first frame in the drive, seconds
  double end = 0;    ///< time of its last frame
  int frames = 0;
  double gap_before = 0;  ///< seconds between the clip before and this one that are not recorded
  /// Images seem to be missing between the clip before and this one, and nothing tells for how long.
  bool unknown_gap_before = false;
  /// Seconds that may be missing between the clip before and this one, by names that are known to the second. The
  /// times do not include them, as the images do not show that any is missing.
  double likely_gap_before = 0;
};

struct ImageSourceOptions {
  /// File with one time per line, in seconds. Goes before `fps`.
  std::optional<std::filesystem::path> timestamps = {};
  /// Frames per second. Goes before the drive's own times.txt or the own time stamps of videos and bags. Images that
  /// are missing by the numbers of their names count (ImageNumbers).
  std::optional<double> fps = {};
  /// The part of the drive to read, seconds after its first frame: from `start`, and before `end`. Times stay those of
  /// the whole drive.
  double start = 0;
  std::optional<double> end = {};
  /// Clockwise turn of every image, degrees: 0, 90, 180 or 270; beyond what its file or a video's header asks for.
  int rotate = 0;
  int width = 0;                    ///< that every image must have, pixels; 0 takes the first image's
  int height = 0;                   ///< that every image must have, pixels; 0 takes the first image's
  std::string camera_file = {};     ///< what asks for that size, for messages
  ImageOptions images = kUnscaled;  ///< how they are scaled (ImageScaling)
};

/// The frames of a drive in order. Images are decoded ahead on a thread of their own.
class ImageSource {
 public:
  /// Throws InputError where there are no times, the times do not fit the frames, a video cannot be opened, or videos
  /// do not fit one another (ClipReader).
  ImageSource(const DriveInput& drive, const ImageSourceOptions& options);
  ~ImageSource();
  ImageSource(ImageSource&&) noexcept;
  ImageSource& operator=(ImageSource&&) noexcept;

  /// Size of the first readable image from here on, before it is scaled; nothing where there is none. Waits for it.
  /// Throws InputError where reading on is not possible.
  std::optional<cv::Size> FullSize();

  /// How the sensor has read the images as given; that of the image that FullSize waits for.
  ReadDirection read_direction();

  /// Width of a pixel over its height in the images as given, as the header of a video says, of several that of the
  /// first; 1 if unknown.
  double pixel_aspect() const;

  /// The next frame; nothing at the end. Throws InputError where an image has another size than the camera file or the
  /// other images, and at the end where not one image could be read or the part of the drive has no frame.
  std::optional<SourceFrame> Next();

  /// Frames of the drive, or of the part of it; for a video or bag without timestamps what its header or index says, 0
  /// if it does not.
  int count() const;

  /// Time of the drive's first frame, seconds, from which `start` and `end` count.
  double first_time() const;

  /// When the drive's first frame was recorded, seconds since 1970 on the recorder's clock, whatever its time zone, as
  /// the names of its videos tell; empty if they do not.
  const std::optional<double>& RecordedFrom() const;

  /// Why the drive begins after it should; empty if it does not.
  const std::string& BeginsLate() const;

  /// Why the frames so far lack some that were recorded, as notices have said; empty if they do not.
  const std::string& Lacks() const;

  /// At the end: why the drive ends before it should; empty if it does not.
  std::string EndsEarly() const;

  /// At the end: what the user should know about the drive after its last frame; may be empty.
  std::string NoticeAtEnd() const;

  /// At the end: whether the drive has images outside the part of it that was asked for.
  bool LeavesOut() const;

  /// Why videos of the drive are left out, one line for each.
  const std::vector<std::string>& left_out() const;

  /// What the user should know about the images of the drive, such as that some are missing, one line; may be empty.
  const std::string& notice() const;

  /// The videos or bags of the drive of which a frame was given; empty for images.
  const std::vector<ClipPart>& clips() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace turnscale
