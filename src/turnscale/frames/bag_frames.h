// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "turnscale/bag/bag_reader.h"
#include "turnscale/frames/bag_drive.h"
#include "turnscale/frames/frame_reader.h"
#include "turnscale/frames/gray_levels.h"

namespace turnscale {

struct BagFrameOptions {
  bool timed = true;  ///< give each image the time of its header stamp; else only their numbers tell
  double start = 0;   ///< images before this time since the first one are not given, seconds
};

/// Reads the images of a drive from bags. Their times are those of the header stamps, seconds of the clock that they
/// are from. An image whose stamp is that of the image before, or less than a second before it, is left out.
class BagFrames : public FrameReader {
 public:
  BagFrames(BagDrive drive, const BagFrameOptions& options);

  /// Throws InputError that names bag, topic and image where the bag is damaged, the encoding of an image is not
  /// supported, there are no stamps, or they go back by more: between two bags, also by less.
  std::optional<DriveImage> Read() override;
  /// Since the first image.
  double LatestTime() const override { return latest_; }

  /// Time of the drive's first image, seconds.
  double origin() const { return origin_; }
  /// So many images at the beginning of the drive are not given.
  void Skip(size_t frames) { skip_ = frames; }

 private:
  std::optional<BagMessage> NextMessage();
  std::string Where() const;
  bool AcceptStamp(int64_t stamp);
  void NoteGap(int64_t stamp);
  GrayImage Decode(const BagMessage& message);

  BagDrive drive_;
  BagFrameOptions options_;
  std::unique_ptr<BagReader> reader_;
  size_t bag_ = 0;
  uint64_t number_ = 0;  // of the image in the bag
  size_t skip_ = 0;
  size_t passed_ = 0;   // of the drive
  bool begun_ = false;  // an image has been given
  std::optional<int64_t> first_stamp_;
  int64_t stamp_ = 0;      // of the latest image
  int64_t interval_ = 0;   // between the latest two, nanoseconds
  size_t stamp_from_ = 0;  // number of its bag
  bool left_out_ = false;
  double origin_;
  double latest_ = 0;
  GrayLevels levels_;
  double gap_ = 0;      // before the next image
  std::string notice_;  // before the next image
};

/// Number of images that the bags really hold: reads all of them.
int CountBagImages(const BagDrive& drive);

}  // namespace turnscale
