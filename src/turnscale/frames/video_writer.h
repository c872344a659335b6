// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// How a video is compressed. The defaults are those of common dashcams.
struct VideoWriterOptions {
  double rate_hz = 30;              ///< frames per second on average; the bit rate is divided by it
  double megabits_per_second = 12;  ///< 10 to 16 are usual for 1920x1080 pixels at 30 frames/s
  double key_seconds = 1;           ///< between two frames that are decoded without others, at the average rate
  bool h264 = true;                 ///< where the FFmpeg build can encode it; MPEG-4 part 2 otherwise

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Resolution of a written video's time stamps, 1/s. MPEG-4 part 2 allows at most 65535; the usual frame rates divide
/// it.
constexpr int kVideoTicksPerSecond = 30'000;

/// Writes gray images as an MP4 video with a time stamp per image. Same images, same stamps, same library, same bytes:
/// there is one encoder thread, and no date in the file. Frames are shown in the order in which they are coded, as
/// with the encoders of cameras.
///
/// The file grows under the name PartOf its path, and gets its own when it is finished.
class VideoWriter {
 public:
  /// Throws InputError if the file cannot be made, the options make no sense, the size is odd (colour has half the
  /// resolution), or the FFmpeg build has no encoder.
  VideoWriter(const std::filesystem::path& path, const cv::Size& size, const VideoWriterOptions& options = {});
  /// A video that is not finished is removed.
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// `gray`: CV_8UC1 of full range. `seconds`: time stamp, not negative, later by a tick at least than that of the
  /// image before; rounded to ticks. Throws OutputError if the system refuses to write.
  void Add(const cv::Mat& gray, double seconds);
  /// Completes the file. Throws OutputError if the system refuses to write.
  void Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace turnscale
