// SPDX-License-Identifier: MIT
#include "turnscale/frames/frame_reader.h"

#include <climits>
#include <fstream>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "turnscale/frames/image_rotation.h"
#include "turnscale/image_file/image_decoder.h"
#include "turnscale/image_file/jpeg_orientation.h"
#include "turnscale/image_file/netpbm.h"

namespace turnscale {
namespace {

class ImageListReader : public FrameReader {
 public:
  ImageListReader(std::vector<std::filesystem::path> images, size_t first, size_t last)
      : images_(std::move(images)), next_(first), last_(last) {
    // Of every part of a drive, orientation and levels are those of the first image of the whole.
    if (first > 0) files_.Read(images_.front());
  }

  std::optional<DriveImage> Read() override {
    if (next_ == last_) return std::nullopt;
    const std::filesystem::path& path = images_[next_++];
    DriveImage image;
    image.image = files_.Read(path);
    image.name = path.string();
    image.notice = files_.TakeNotice();
    return image;
  }

 private:
  std::vector<std::filesystem::path> images_;
  ImageFiles files_;
  size_t next_;
  size_t last_;
};

DecodedImage Decoded(std::span<const uint8_t> bytes, int64_t most_pixels) {
  if (EndsEarly(bytes)) return {{}, false, "is truncated"};
  const ImagePixels decoded = DecodePixels(bytes, most_pixels);
  if (!decoded.gray.empty()) return {decoded.gray, decoded.colour, "", decoded.range_is_stated};
  const bool is_tiff = bytes.size() > 1 && bytes[0] == bytes[1] && (bytes[0] == 'I' || bytes[0] == 'M');
  return {{},
          false,
          is_tiff ? "is not a readable TIFF; one with tiles, of floating-point numbers or packed as JPEG has to be "
                    "converted, for example to PNG"
                  : "is not a readable image"};
}

}  // namespace

GrayImage ImageFiles::Read(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return {{}, name + ": cannot be opened"};
  stream.seekg(0, std::ios::end);
  const std::streamoff size = stream.tellg();
  if (size <= 0) return {{}, name + ": is empty"};
  if (size > INT_MAX) return {{}, name + ": is larger than 2 GB"};
  const cv::Mat bytes(1, static_cast<int>(size), CV_8U);
  stream.seekg(0);
  if (!stream.read(reinterpret_cast<char*>(bytes.data), size)) return {{}, name + ": cannot be read"};
  // The copy of a large image would take as long as its tracking.
  if (const cv::Mat gray = PgmInPlace(bytes); !gray.empty()) return Turned(gray, kUpright, name);
  const std::span<const uint8_t> encoded(bytes.data, bytes.total());
  const DecodedImage decoded = DecodeImage(encoded);
  if (!decoded.problem.empty()) return {{}, name + ": " + decoded.problem};
  const cv::Mat gray = levels_.ToGray8(decoded.pixels, decoded.range_is_stated);
  if (gray.empty()) return {{}, name + ": is not a readable image"};
  return Turned(gray, JpegOrientation(encoded), name);
}

GrayImage ImageFiles::Turned(const cv::Mat& gray, int orientation, const std::string& name) {
  if (!orientation_) orientation_ = orientation;
  if (orientation != *orientation_ && !std::exchange(orientations_differ_, true))
    notice_ = fmt::format("{}: its EXIF orientation is {}, but that of the first image is {}, which is used for all",
                          name, orientation, *orientation_);
  const auto turned = [&](const cv::Mat& stored) { return TurnedUpright(stored, *orientation_); };
  return {turned(gray), "", ReadDirectionAfter(turned)};
}

std::string ImageFiles::TakeNotice() {
  std::string notice = std::exchange(notice_, {});
  AddSentence(notice, levels_.TakeNotice());
  return notice;
}

GrayImage ReadGrayImage(const std::filesystem::path& path) { return ImageFiles().Read(path); }

DecodedImage DecodeImage(std::span<const uint8_t> bytes) { return Decoded(bytes, INT_MAX); }

DecodedImage DecodeJpegOrPng(std::span<const uint8_t> bytes) {
  constexpr int64_t kMostPixels = 100'000'000;
  const std::optional<uint64_t> pixels = AnnouncedPixels(bytes);
  if (!pixels) return {{}, false, "is neither JPEG nor PNG"};
  if (*pixels == 0 || *pixels > kMostPixels) return {{}, false, "is not a readable image"};
  return Decoded(bytes, kMostPixels);
}

void AddSentence(std::string& notice, const std::string& sentence) {
  if (!sentence.empty()) notice += (notice.empty() ? "" : "; ") + sentence;
}

std::unique_ptr<FrameReader> ReadImages(std::vector<std::filesystem::path> images, size_t first, size_t last) {
  return std::make_unique<ImageListReader>(std::move(images), first, last);
}

}  // namespace turnscale
