// SPDX-License-Identifier: MIT
#include "turnscale/image_file/image_decoder.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "turnscale/image_file/codec_pointers.h"
#include "turnscale/image_file/first_bytes.h"
#include "turnscale/image_file/gray_png.h"
#include "turnscale/image_file/netpbm.h"
#include "turnscale/image_file/png_chunks.h"

extern "C" {
#include <libavutil/bswap.h>
}

namespace turnscale {
namespace {

using Bytes = std::span<const uint8_t>;

AVCodecID CodecOf(Bytes bytes) {
  using namespace std::string_view_literals;
  constexpr std::pair<std::string_view, AVCodecID> kCodecs[] = {
      {kPngSignature, AV_CODEC_ID_PNG}, {"\xFF\xD8\xFF", AV_CODEC_ID_MJPEG},
      {"BM", AV_CODEC_ID_BMP},          {"II*\0"sv, AV_CODEC_ID_TIFF},
      {"MM\0*"sv, AV_CODEC_ID_TIFF},    {"P1", AV_CODEC_ID_PBM},
      {"P4", AV_CODEC_ID_PBM},          {"P2", AV_CODEC_ID_PGM},
      {"P3", AV_CODEC_ID_PPM}};
  for (const auto& [magic, codec] : kCodecs)
    if (StartsWith(bytes, magic)) return codec;
  return AV_CODEC_ID_NONE;
}

// The parts of a PNG to decode; none if its header and the types of its chunks do not make an image.
std::vector<Bytes> PartsOfPng(Bytes bytes, const PngHeader& header, std::vector<PngChunk> chunks) {
  const auto is_palette = [](PngChunk chunk) { return IsPngChunk(chunk, "PLTE"); };
  if (header.colour == kPngPalette && std::ranges::none_of(chunks, is_palette)) return {};
  // The decoder fills in missing passes with a preview.
  if (header.interlaced) {
    const uint64_t size = UnpackedPngSize(header);
    const auto unpacked = std::make_unique_for_overwrite<uint8_t[]>(size);
    const PngData data = UnpackPng(chunks, {unpacked.get(), size});
    if (data != PngData::kExact && data != PngData::kLong) return {};
  }
  chunks.insert(chunks.begin(), bytes.first(kPngSignature.size()));
  return chunks;
}

PacketPointer PacketOf(const std::vector<Bytes>& parts) {
  size_t size = 0;
  for (const Bytes part : parts) size += part.size();
  if (size == 0 || size > INT_MAX - AV_INPUT_BUFFER_PADDING_SIZE) return nullptr;
  PacketPointer packet(Allocated(ffmpeg::av_packet_alloc()));
  if (ffmpeg::av_new_packet(packet.get(), static_cast<int>(size)) < 0) throw std::bad_alloc();
  uint8_t* to = packet->data;
  for (const Bytes part : parts) to = std::copy(part.begin(), part.end(), to);
  // Otherwise it may be taken as the difference from another image.
  packet->flags |= AV_PKT_FLAG_KEY;
  return packet;
}

// The decoders return some incomplete images as if they were whole. So rows are filled with this level before they
// are decoded.
struct Mark {
  uint8_t level = 0;
  bool all_rows = false;  // or only the last one, which is written last
};

// Calls `row(plane's row, bytes)` for the rows that are marked.
template <class Row>
void ForMarkedRows(const AVFrame& frame, const Mark& mark, const Row& row) {
  const auto format = static_cast<AVPixelFormat>(frame.format);
  const AVPixFmtDescriptor* description = ffmpeg::av_pix_fmt_desc_get(format);
  for (int plane = 0; plane < ffmpeg::av_pix_fmt_count_planes(format); ++plane) {
    const bool is_chroma = plane == 1 || plane == 2;
    const int rows = is_chroma ? AV_CEIL_RSHIFT(frame.height, description->log2_chroma_h) : frame.height;
    const auto bytes = static_cast<size_t>(std::max(ffmpeg::av_image_get_linesize(format, frame.width, plane), 0));
    for (int y = mark.all_rows ? 0 : rows - 1; y < rows; ++y)
      row(frame.data[plane] + static_cast<std::ptrdiff_t>(y) * frame.linesize[plane], bytes);
  }
}

int MarkedBuffer(AVCodecContext* context, AVFrame* frame, int flags) {
  const int result = ffmpeg::avcodec_default_get_buffer2(context, frame, flags);
  if (result < 0) return result;
  const Mark& mark = *static_cast<const Mark*>(context->opaque);
  ForMarkedRows(*frame, mark, [&](uint8_t* row, size_t bytes) { std::fill_n(row, bytes, mark.level); });
  return result;
}

bool HasMarkedRow(const AVFrame& frame, const Mark& mark) {
  bool found = false;
  ForMarkedRows(frame, mark, [&](const uint8_t* row, size_t bytes) {
    found = found || std::all_of(row, row + bytes, [&](uint8_t level) { return level == mark.level; });
  });
  return found;
}

// Nothing for what is damaged. Each image has a decoder of its own, so that none shows anything of an earlier one.
FramePointer DecodeFrame(AVCodecID id, const AVPacket& packet, int64_t most_pixels, Mark mark) {
  // The library would write its own messages to standard error.
  ffmpeg::av_log_set_level(AV_LOG_QUIET);
  const AVCodec* codec = ffmpeg::avcodec_find_decoder(id);
  if (codec == nullptr) return nullptr;
  const CodecPointer decoder(Allocated(ffmpeg::avcodec_alloc_context3(codec)));
  decoder->thread_count = 1;
  decoder->flags |= AV_CODEC_FLAG_BITEXACT;
  // In TIFF, a tag that the library does not know counts as damage, too.
  decoder->err_recognition = AV_EF_CRCCHECK | (id == AV_CODEC_ID_TIFF ? 0 : AV_EF_EXPLODE);
  decoder->max_pixels = most_pixels;
  decoder->opaque = &mark;
  decoder->get_buffer2 = MarkedBuffer;
  FramePointer frame(Allocated(ffmpeg::av_frame_alloc()));
  if (ffmpeg::avcodec_open2(decoder.get(), codec, nullptr) < 0 ||
      ffmpeg::avcodec_send_packet(decoder.get(), &packet) < 0 ||
      ffmpeg::avcodec_receive_frame(decoder.get(), frame.get()) < 0) {
    return nullptr;
  }
  const bool damaged = (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame->decode_error_flags != 0;
  return damaged ? nullptr : std::move(frame);
}

cv::Mat View(const AVFrame& frame, int plane, int type) {
  return {frame.height, frame.width, type, frame.data[plane], static_cast<size_t>(frame.linesize[plane])};
}

// One component of any format, stretched to 8 or 16 bits.
cv::Mat Component(const AVFrame& frame, const AVPixFmtDescriptor& format, int component) {
  const AVComponentDescriptor& stored = format.comp[component];
  const bool big_endian = (format.flags & AV_PIX_FMT_FLAG_BE) != 0;
  if (stored.depth == 8 && stored.step == 1) return View(frame, stored.plane, CV_8UC1).clone();
  if (stored.depth == 16 && stored.step == 2 && !big_endian) return View(frame, stored.plane, CV_16UC1).clone();
  const unsigned most = (1U << static_cast<unsigned>(stored.depth)) - 1;
  const unsigned levels = stored.depth > 8 ? 0xFFFF : 0xFF;
  const bool black_is_one = frame.format == AV_PIX_FMT_MONOWHITE;
  cv::Mat image(frame.height, frame.width, CV_16UC1);
  for (int y = 0; y < image.rows; ++y) {
    auto* row = image.ptr<uint16_t>(y);
    if (stored.depth == 16 && stored.step == 2) {
      const auto* from = View(frame, stored.plane, CV_16UC1).ptr<uint16_t>(y);
      std::transform(from, from + image.cols, row, [](uint16_t level) { return av_bswap16(level); });
      continue;
    }
    ffmpeg::av_read_image_line2(row, const_cast<const uint8_t**>(frame.data), frame.linesize, &format, 0, y, component,
                                image.cols, 0, sizeof(*row));
    std::transform(row, row + image.cols, row, [&](uint16_t level) {
      const unsigned stretched = (std::min<unsigned>(level, most) * levels + most / 2) / most;
      return static_cast<uint16_t>(black_is_one ? levels - stretched : stretched);
    });
  }
  if (levels == 0xFF) image.convertTo(image, CV_8U);
  return image;
}

ImagePixels PixelsOfPalette(const AVFrame& frame) {
  std::array<uint32_t, 256> palette{};
  std::memcpy(palette.data(), frame.data[1], sizeof(palette));
  cv::Mat colours(1, static_cast<int>(palette.size()), CV_8UC3);
  ImagePixels pixels;
  for (int i = 0; i < colours.cols; ++i) {
    const uint32_t argb = palette[static_cast<size_t>(i)];
    const cv::Vec3b bgr(argb & 0xFF, argb >> 8 & 0xFF, argb >> 16 & 0xFF);
    colours.at<cv::Vec3b>(i) = bgr;
    pixels.colour = pixels.colour || bgr[0] != bgr[1] || bgr[1] != bgr[2];
  }
  cv::Mat levels;
  cv::cvtColor(colours, levels, cv::COLOR_BGR2GRAY);
  cv::LUT(View(frame, 0, CV_8UC1), levels, pixels.gray);
  return pixels;
}

cv::Mat GrayOfColours(const AVFrame& frame, const AVPixFmtDescriptor& format) {
  constexpr std::pair<AVPixelFormat, int> kPacked[] = {
      {AV_PIX_FMT_RGB24, cv::COLOR_RGB2GRAY}, {AV_PIX_FMT_BGR24, cv::COLOR_BGR2GRAY},
      {AV_PIX_FMT_RGBA, cv::COLOR_RGBA2GRAY}, {AV_PIX_FMT_BGRA, cv::COLOR_BGRA2GRAY},
      {AV_PIX_FMT_RGB0, cv::COLOR_RGBA2GRAY}, {AV_PIX_FMT_BGR0, cv::COLOR_BGRA2GRAY}};
  cv::Mat gray;
  for (const auto& [packed, conversion] : kPacked) {
    if (frame.format != packed) continue;
    cv::cvtColor(View(frame, 0, CV_8UC(format.comp[0].step)), gray, conversion);
    return gray;
  }
  cv::Mat colours;
  cv::merge(std::vector<cv::Mat>{Component(frame, format, 2), Component(frame, format, 1), Component(frame, format, 0)},
            colours);
  cv::cvtColor(colours, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

// Video's 16...235.
cv::Mat StretchedLimitedRange(const cv::Mat& luma) {
  constexpr int kBlack = 16;
  constexpr int kRange = 219;
  cv::Mat stretched;
  luma.convertTo(stretched, CV_8U, 255.0 / kRange, -255.0 * kBlack / kRange);
  return stretched;
}

ImagePixels PixelsOf(const AVFrame& frame) {
  const AVPixFmtDescriptor* format = ffmpeg::av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  constexpr uint64_t kOther = AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_BAYER | AV_PIX_FMT_FLAG_FLOAT;
  if (format == nullptr || (format->flags & kOther) != 0) return {};
  if ((format->flags & AV_PIX_FMT_FLAG_PAL) != 0) return PixelsOfPalette(frame);
  if ((format->flags & AV_PIX_FMT_FLAG_RGB) != 0) return {GrayOfColours(frame, *format), true};
  constexpr int kColour = 3;  // components, two of which are chroma
  constexpr int kFullDepth = 16;
  ImagePixels pixels{Component(frame, *format, 0), format->nb_components >= kColour};
  pixels.range_is_stated = format->comp[0].depth < kFullDepth;
  if (pixels.colour && frame.color_range == AVCOL_RANGE_MPEG && pixels.gray.depth() == CV_8U)
    pixels.gray = StretchedLimitedRange(pixels.gray);
  return pixels;
}

bool AreEqual(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

ImagePixels DecodeParts(AVCodecID id, const std::vector<Bytes>& parts, int64_t most_pixels) {
  const PacketPointer packet = PacketOf(parts);
  if (!packet) return {};
  const bool from_top = id == AV_CODEC_ID_PNG || id == AV_CODEC_ID_MJPEG;
  constexpr uint8_t kLevel = 0x5B;  // rarely that of a whole row
  Mark mark{kLevel, !from_top};
  const FramePointer frame = DecodeFrame(id, *packet, most_pixels, mark);
  if (!frame) return {};
  ImagePixels pixels = PixelsOf(*frame);
  // In TIFF, decoding may end within a row.
  if (id != AV_CODEC_ID_TIFF && !HasMarkedRow(*frame, mark)) return pixels;
  // Pixels that are decoded do not depend on what was there before.
  mark.level = static_cast<uint8_t>(~kLevel);
  const FramePointer again = DecodeFrame(id, *packet, most_pixels, mark);
  return again && AreEqual(pixels.gray, PixelsOf(*again).gray) ? pixels : ImagePixels();
}

ImagePixels DecodePng(Bytes png, int64_t most_pixels) {
  // Deflate does not pack further. A small file does not take memory for a large image.
  constexpr uint64_t kMostPacking = 1032;
  std::vector<PngChunk> chunks = PngChunks(png);
  const std::optional<PngHeader> header = HeaderOfPng(chunks);
  if (!header || uint64_t{header->width} * header->height > static_cast<uint64_t>(most_pixels) ||
      UnpackedPngSize(*header) > kMostPacking * png.size()) {
    return {};
  }
  const cv::Mat gray = DecodeGrayPng(chunks);
  if (!gray.empty()) return {gray, false};
  return DecodeParts(AV_CODEC_ID_PNG, PartsOfPng(png, *header, std::move(chunks)), most_pixels);
}

}  // namespace

ImagePixels DecodePixels(Bytes bytes, int64_t most_pixels) {
  if (IsBinaryNetpbm(bytes)) return DecodeBinaryNetpbm(bytes, most_pixels);
  const AVCodecID id = CodecOf(bytes);
  if (id == AV_CODEC_ID_NONE) return {};
  if (id == AV_CODEC_ID_PNG) return DecodePng(bytes, most_pixels);
  return DecodeParts(id, {bytes}, most_pixels);
}

}  // namespace turnscale
