// SPDX-License-Identifier: MIT
#include "turnscale/frames/bag_frames.h"

#include <algorithm>
#include <climits>
#include <utility>

#include <fmt/format.h>

#include "turnscale/bag/byte_reader.h"
#include "turnscale/bag/image_pixels.h"
#include "turnscale/bag/messages.h"
#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"

namespace turnscale {
namespace {

constexpr double kNanosecond = 1e-9;
// Stamps that go back less are of images that a driver sent late or twice.
constexpr int64_t kLateImage = 1'000'000'000;

}  // namespace

BagFrames::BagFrames(BagDrive drive, const BagFrameOptions& options)
    : drive_(std::move(drive)), options_(options), origin_(SecondsOfStamp(drive_.first_stamp)) {}

std::string BagFrames::Where() const {
  return fmt::format("{}: {}: image {}", drive_.bags[bag_].string(), Printable(drive_.topic), number_);
}

std::optional<BagMessage> BagFrames::NextMessage() {
  for (; bag_ < drive_.bags.size(); ++bag_) {
    if (!reader_) {
      reader_ = OpenBag(drive_.bags[bag_], {drive_.topic});
      number_ = 0;
    }
    while (std::optional<BagMessage> message = reader_->Next())
      if (message->topic->content != BagContent::kCameraInfo) return message;
    reader_.reset();
  }
  return std::nullopt;
}

// Whether the image is later than the one before.
bool BagFrames::AcceptStamp(int64_t stamp) {
  if (first_stamp_ && stamp <= stamp_) {
    const double before = SecondsOfStamp(stamp_);
    if (stamp == 0) throw InputError(Where() + ": has no header stamp; give --fps X or --timestamps FILE");
    if (stamp_from_ != bag_) {
      throw InputError(
          fmt::format("{}: its header stamp, {:.3f} s, is not after the last one of {}, {:.3f} s; give "
                      "the bags in their order",
                      Where(), SecondsOfStamp(stamp), drive_.bags[stamp_from_].string(), before));
    }
    if (stamp_ - stamp >= kLateImage) {
      throw InputError(
          fmt::format("{}: its header stamp goes back from {:.3f} to {:.3f} s; give --fps X or "
                      "--timestamps FILE",
                      Where(), before, SecondsOfStamp(stamp)));
    }
    if (!std::exchange(left_out_, true))
      notice_ += fmt::format("{}{}: its header stamp is not after the one before; such images are left out",
                             notice_.empty() ? "" : "; ", Where());
    return false;
  }
  const double time = SecondsOfStamp(stamp);
  if (!first_stamp_) {
    first_stamp_ = stamp;
  } else {
    NoteGap(stamp);
    interval_ = stamp - stamp_;
  }
  stamp_ = stamp;
  stamp_from_ = bag_;
  latest_ = time - origin_;
  return true;
}

void BagFrames::NoteGap(int64_t stamp) {
  const double gap = kNanosecond * static_cast<double>(stamp - stamp_ - interval_);
  if (interval_ == 0 || gap <= kLeastGap) return;
  gap_ += gap;
  const std::string name = drive_.bags[bag_].filename().string();
  const std::string where = stamp_from_ == bag_
                                ? "in " + name
                                : fmt::format("between {} and {}", drive_.bags[stamp_from_].filename().string(), name);
  notice_ += fmt::format("{}gap of {:.1f} s {} (at {:.1f} s of the drive)", notice_.empty() ? "" : "; ", gap, where,
                         kNanosecond * static_cast<double>(stamp_ + interval_ - *first_stamp_));
}

std::optional<DriveImage> BagFrames::Read() {
  while (const std::optional<BagMessage> message = NextMessage()) {
    int64_t stamp = 0;
    try {
      stamp = ReadBagStamp(*message);
    } catch (const MalformedData& error) {
      throw InputError(fmt::format("{}: {}", Where(), error.what()));
    }
    DriveImage image;
    image.name = Where();
    image.clip = static_cast<int>(bag_);
    if (options_.timed && !AcceptStamp(stamp)) {
      ++number_;
      continue;
    }
    if (passed_++ < skip_ || (options_.timed && latest_ < options_.start)) {
      // Nothing of the drive is before the first image that is given.
      gap_ = 0;
      notice_.clear();
      ++number_;
      continue;
    }
    image.image = Decode(*message);
    ++number_;
    if (options_.timed) image.time = SecondsOfStamp(stamp);
    if (std::exchange(begun_, true)) image.gap = gap_;
    image.notice = std::exchange(notice_, {});
    AddSentence(image.notice, levels_.TakeNotice());
    gap_ = 0;
    return image;
  }
  return std::nullopt;
}

GrayImage BagFrames::Decode(const BagMessage& message) {
  try {
    if (message.topic->content == BagContent::kImage) {
      const BagImage image = ReadBagImage(message);
      CheckEncoding(image.encoding, Where());
      return {levels_.ToGray8(PixelsOf(image)), {}};
    }
    const BagCompressedImage image = ReadBagCompressedImage(message);
    const DecodedImage decoded = DecodeJpegOrPng(image.data);
    if (decoded.pixels.empty()) return {{}, Where() + ": " + decoded.problem};
    // Colours of a Bayer pattern are those that a driver has made of it.
    return {levels_.ToGray8(decoded.colour ? decoded.pixels : WithColour(decoded.pixels, image.format)), {}};
  } catch (const MalformedData& error) {
    return {{}, Where() + ": " + error.what()};
  }
}

int CountBagImages(const BagDrive& drive) {
  uint64_t images = 0;
  for (const std::filesystem::path& bag : drive.bags) {
    const std::unique_ptr<BagReader> reader = OpenBag(bag, {drive.topic});
    while (const std::optional<BagMessage> message = reader->Next())
      images += message->topic->content != BagContent::kCameraInfo ? 1 : 0;
  }
  return static_cast<int>(std::min<uint64_t>(images, INT_MAX));
}

}  // namespace turnscale
