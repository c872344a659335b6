// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/frames/gray_levels.h"

namespace turnscale {

/// An image as 8-bit gray, or why there is none.
struct GrayImage {
  cv::Mat gray;         ///< empty if the file is unusable
  std::string problem;  ///< "name: why"; empty if there is none
  ReadDirection read_direction = {};
};

/// Reads the image files of a drive, in their order, as 8-bit gray (GrayLevels). They are rotated and mirrored as the
/// EXIF orientation of the first readable one says, as the camera does not turn in the car; only that of JPEG is read.
/// Files that end too early are refused, not filled up.
class ImageFiles {
 public:
  GrayImage Read(const std::filesystem::path& path);

  /// What the user should know about the images so far, one line, which is given once; may be empty.
  std::string TakeNotice();

 private:
  GrayImage Turned(const cv::Mat& gray, int orientation, const std::string& name);

  GrayLevels levels_;
  std::optional<int> orientation_;
  bool orientations_differ_ = false;
  std::string notice_;
};

/// Reads a single image file so.
GrayImage ReadGrayImage(const std::filesystem::path& path);

/// The pixels of an encoded image, or why there are none.
struct DecodedImage {
  cv::Mat pixels;                ///< gray, 8 or 16 bit; empty if the bytes are unusable
  bool colour = false;           ///< the file has colours
  std::string problem = {};      ///< such as "is truncated"; empty if there is none
  bool range_is_stated = false;  ///< of 16-bit pixels, which fill the range then
};

/// Decodes the bytes of an image file.
DecodedImage DecodeImage(std::span<const uint8_t> bytes);

/// The same for bytes of unknown origin: takes JPEG and PNG only, and of no more than 100 megapixels.
DecodedImage DecodeJpegOrPng(std::span<const uint8_t> bytes);

/// Whether the bytes of a PNG, JPEG, BMP or binary PGM/PPM stop before the image is complete. Decoders fill such an
/// image up in silence. Other formats count as complete.
bool EndsEarly(std::span<const uint8_t> bytes);

/// Number of pixels that the header of a PNG or JPEG announces; nothing for other bytes.
std::optional<uint64_t> AnnouncedPixels(std::span<const uint8_t> bytes);

/// Adds a sentence to a notice, behind a semicolon if there is one before. An empty one changes nothing.
void AddSentence(std::string& notice, const std::string& sentence);

/// A longer pause between two images is a part of the drive that was not recorded; shorter ones are hiccups of the
/// recorder. Seconds.
constexpr double kLeastGap = 1.5;

/// An image of a drive.
struct DriveImage {
  GrayImage image;
  std::string name;            ///< file, of a video also the number of the frame in it
  std::optional<double> time;  ///< seconds; empty if only its number in the drive tells
  int clip = 0;                ///< number of the video that it is from
  double gap = 0;              ///< seconds before it that the drive is not recorded; 0 if it continues
  bool unknown_gap = false;    ///< images seem to be missing before it, and nothing tells for how long
  double likely_gap = 0;       ///< seconds that may be missing before it, by names that are known to the second
  std::string lacks;           ///< why images before it that were recorded cannot be used; empty if all can
  std::string notice;          ///< what the user should know about the drive before this image; may be empty
};

/// Yields the images of a drive one by one.
class FrameReader {
 public:
  virtual ~FrameReader() = default;
  /// The next image, or why it is unusable; empty at the end.
  virtual std::optional<DriveImage> Read() = 0;
  /// Once all is read: why the drive ends before it should; empty if it does not.
  virtual std::string EndsEarly() const { return {}; }
  /// Once all is read: what the user should know about the drive after its last image; may be empty.
  virtual std::string NoticeAtEnd() const { return {}; }
  /// Time of the latest image that was read or passed over; 0 if only numbers tell.
  virtual double LatestTime() const { return 0; }
};

/// Images `first` to before `last` of a drive.
std::unique_ptr<FrameReader> ReadImages(std::vector<std::filesystem::path> images, size_t first, size_t last);

}  // namespace turnscale
