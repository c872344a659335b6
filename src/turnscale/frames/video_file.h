// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/base/error.h"
#include "turnscale/camera/camera_model.h"

namespace turnscale {

/// What a video's header says.
struct VideoHeader {
  cv::Size size;                  ///< of the images, rotated as the video asks for
  double pixel_aspect = 1;        ///< width of one of their pixels over its height; 1 if unknown
  ReadDirection read_direction;   ///< of the images, rotated as the video asks for
  double rate = 0;                ///< frames per second on average; 0 if unknown
  double tick = 0;                ///< resolution of the stamps, seconds
  double duration = 0;            ///< seconds; 0 if unknown
  std::optional<double> begin;    ///< stamp of the first frame, seconds
  int frames = 0;                 ///< number of frames, without those that an edit list hides; 0 if unknown
  bool counted = false;           ///< `frames` is the container's own count, not an estimate from duration and rate
  std::optional<double> created;  ///< when it was recorded, seconds since 1970
  int tracks = 1;                 ///< number of videos in the file, of which the first is decoded
};

/// When a frame of a video is shown.
struct FrameStamp {
  double seconds = 0;
  bool key = false;  ///< it and all frames shown after it can be decoded without earlier ones
};

/// A file that can be read but holds no video that can be decoded.
class UnreadableVideo : public InputError {
 public:
  using InputError::InputError;
};

/// A video file, decoded frame by frame.
class VideoFile {
 public:
  /// Throws UnreadableVideo if the file holds no video that can be decoded, InputError if it cannot be read or is
  /// interlaced.
  explicit VideoFile(const std::filesystem::path& path);
  ~VideoFile();
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  /// The stamps of all frames in the order in which they are shown, read without decoding; empty if only decoding
  /// tells.
  static std::vector<FrameStamp> ReadStamps(const std::filesystem::path& path);

  const VideoHeader& header() const;

  /// Begins at the key frame with that stamp (ReadStamps), before the first frame is decoded.
  void StartAt(double stamp);
  /// Decodes the next frame; false at the end. Damaged parts of the file are passed over. Throws InputError if the
  /// frame is interlaced.
  bool Advance();
  /// The frame's presentation time stamp in seconds; empty if the container has none.
  std::optional<double> Stamp() const;
  /// The frame as 8-bit gray of full range, rotated and mirrored as the video asks for.
  cv::Mat Gray();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Number of frames that a video really holds: decodes all of it.
int CountVideoFrames(const std::filesystem::path& path);

}  // namespace turnscale
