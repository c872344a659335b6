// SPDX-License-Identifier: MIT
#include "turnscale/bag/messages.h"

#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include "turnscale/bag/byte_reader.h"
#include "turnscale/base/number_text.h"

namespace turnscale {
namespace {

constexpr int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr size_t kMostCoefficients = 64;

// CDR begins with four bytes: its kind, of which the last bit is the byte order, and options. What follows is aligned.
ByteReader ReaderOfCdr(std::span<const uint8_t> bytes) {
  constexpr std::array<uint8_t, 4> kZstd = {0x28, 0xB5, 0x2F, 0xFD};
  if (bytes.size() >= 4 && std::equal(kZstd.begin(), kZstd.end(), bytes.begin()))
    throw MalformedData("the messages are compressed one by one; convert the bag with ros2 bag convert");
  if (bytes.size() < 4 || bytes[0] != 0 || bytes[1] > 1) throw MalformedData("a message is not in CDR");
  return ByteReader(bytes.subspan(4), bytes[1] == 1 ? std::endian::little : std::endian::big);
}

// The fields of a message in order, in either serialization.
class FieldCursor {
 public:
  explicit FieldCursor(const BagMessage& message)
      : cdr_(message.topic->serialization == BagSerialization::kCdr),
        reader_(cdr_ ? ReaderOfCdr(message.bytes) : ByteReader(message.bytes)) {}

  template <class Number>
  Number Read() {
    if (cdr_) reader_.Align(sizeof(Number));
    return reader_.Read<Number>();
  }

  std::string_view Text() {
    const auto size = Read<uint32_t>();
    std::string_view text = reader_.Text(size);
    // CDR counts the end of the string.
    if (cdr_ && text.ends_with('\0')) text.remove_suffix(1);
    return text;
  }

  std::span<const uint8_t> Sequence() { return reader_.Bytes(Read<uint32_t>()); }

  // Stamp of a std_msgs/Header, in nanoseconds.
  int64_t Header() {
    if (!cdr_) Read<uint32_t>();
    const auto seconds = Read<uint32_t>();
    const auto nanoseconds = Read<uint32_t>();
    Text();
    if (nanoseconds >= kNanosecondsPerSecond || (cdr_ && seconds > INT32_MAX))
      throw MalformedData("a header stamp is no time");
    return seconds * kNanosecondsPerSecond + nanoseconds;
  }

  template <size_t kSize>
  void Numbers(std::array<double, kSize>& numbers) {
    for (double& number : numbers) number = Read<double>();
  }

 private:
  bool cdr_;
  ByteReader reader_;
};

}  // namespace

BagImage ReadBagImage(const BagMessage& message) {
  FieldCursor fields(message);
  BagImage image;
  image.stamp = fields.Header();
  image.height = fields.Read<uint32_t>();
  image.width = fields.Read<uint32_t>();
  image.encoding = fields.Text();
  image.big_endian = fields.Read<uint8_t>() != 0;
  image.step = fields.Read<uint32_t>();
  image.data = fields.Sequence();
  return image;
}

BagCompressedImage ReadBagCompressedImage(const BagMessage& message) {
  FieldCursor fields(message);
  BagCompressedImage image;
  image.stamp = fields.Header();
  image.format = fields.Text();
  image.data = fields.Sequence();
  return image;
}

BagCameraInfo ReadBagCameraInfo(const BagMessage& message) {
  FieldCursor fields(message);
  BagCameraInfo info;
  info.stamp = fields.Header();
  info.height = fields.Read<uint32_t>();
  info.width = fields.Read<uint32_t>();
  info.distortion_model = fields.Text();
  const auto coefficients = fields.Read<uint32_t>();
  if (coefficients > kMostCoefficients) throw MalformedData("a camera info has too many coefficients");
  for (uint32_t i = 0; i < coefficients; ++i) info.d.push_back(fields.Read<double>());
  std::array<double, 9> rectification{};
  fields.Numbers(info.k);
  fields.Numbers(rectification);
  fields.Numbers(info.p);
  info.binning_x = fields.Read<uint32_t>();
  info.binning_y = fields.Read<uint32_t>();
  for (uint32_t& side : info.roi) side = fields.Read<uint32_t>();
  return info;
}

int64_t ReadBagStamp(const BagMessage& message) { return FieldCursor(message).Header(); }

double SecondsOfStamp(int64_t nanoseconds) {
  const std::string text =
      fmt::format("{}.{:09}", nanoseconds / kNanosecondsPerSecond, nanoseconds % kNanosecondsPerSecond);
  return ParseNumber<double>(text).value_or(0);
}

}  // namespace turnscale
