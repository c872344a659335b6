// SPDX-License-Identifier: MIT
#include "turnscale/image_file/image_encoder.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/error.h"
#include "turnscale/image_file/codec_pointers.h"

extern "C" {
#include <libavutil/mem.h>
#include <libavutil/opt.h>
}

namespace turnscale {
namespace {

using Table = std::array<int, 64>;

// Quantisation of JPEG's Annex K, at quality 50.
constexpr Table kLumaTable = {16, 11, 10, 16, 24,  40,  51,  61,  12, 12, 14, 19, 26,  58,  60,  55,   //
                              14, 13, 16, 24, 40,  57,  69,  56,  14, 17, 22, 29, 51,  87,  80,  62,   //
                              18, 22, 37, 56, 68,  109, 103, 77,  24, 35, 55, 64, 81,  104, 113, 92,   //
                              49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98, 112, 100, 103, 99};  //
constexpr Table kChromaTable = {17, 18, 24, 47, 99, 99, 99, 99, 18, 21, 26, 66, 99, 99, 99, 99,        //
                                24, 26, 56, 99, 99, 99, 99, 99, 47, 66, 99, 99, 99, 99, 99, 99,        //
                                99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99,        //
                                99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99};       //

// With this step the encoder takes the tables as they are.
constexpr int kPlainStep = 8;

uint16_t* ScaledTable(const Table& table, int quality) {
  const int percent = quality < 50 ? 5000 / quality : 200 - 2 * quality;
  auto* scaled = static_cast<uint16_t*>(Allocated(av_malloc_array(table.size(), sizeof(uint16_t))));
  std::transform(table.begin(), table.end(), scaled,
                 [&](int step) { return static_cast<uint16_t>(std::clamp((step * percent + 50) / 100, 1, 255)); });
  return scaled;
}

CodecPointer MakeEncoder(AVCodecID id, AVPixelFormat format, const cv::Size& size) {
  // The library would write its own messages to standard error.
  av_log_set_level(AV_LOG_QUIET);
  const AVCodec* codec = avcodec_find_encoder(id);
  Ensure(codec != nullptr, "FFmpeg's libraries have no encoder for an image");
  CodecPointer encoder(Allocated(avcodec_alloc_context3(codec)));
  encoder->width = size.width;
  encoder->height = size.height;
  encoder->pix_fmt = format;
  encoder->time_base = {1, 1};
  encoder->thread_count = 1;
  encoder->flags |= AV_CODEC_FLAG_BITEXACT;
  return encoder;
}

FramePointer MakeFrame(const AVCodecContext& encoder) {
  FramePointer frame(Allocated(av_frame_alloc()));
  frame->format = encoder.pix_fmt;
  frame->width = encoder.width;
  frame->height = encoder.height;
  frame->color_range = encoder.color_range;
  if (av_frame_get_buffer(frame.get(), 0) < 0) throw std::bad_alloc();
  return frame;
}

cv::Mat Plane(const AVFrame& frame, int plane, const cv::Size& size) {
  return {size, CV_8UC1, frame.data[plane], static_cast<size_t>(frame.linesize[plane])};
}

std::string Encoded(AVCodecContext& encoder, const AVFrame& frame) {
  const PacketPointer packet(Allocated(av_packet_alloc()));
  const bool encoded = avcodec_send_frame(&encoder, &frame) >= 0 && avcodec_send_frame(&encoder, nullptr) >= 0 &&
                       avcodec_receive_packet(&encoder, packet.get()) >= 0;
  Ensure(encoded, "an image cannot be encoded");
  return {reinterpret_cast<const char*>(packet->data), static_cast<size_t>(packet->size)};
}

}  // namespace

std::string EncodePng(const cv::Mat& gray) {
  Ensure(gray.type() == CV_8UC1 && !gray.empty(), "a PNG takes an 8-bit gray image");
  const CodecPointer encoder = MakeEncoder(AV_CODEC_ID_PNG, AV_PIX_FMT_GRAY8, gray.size());
  // Noise cannot be packed: higher levels only take longer.
  encoder->compression_level = 1;
  av_opt_set(encoder->priv_data, "pred", "sub", 0);
  Ensure(avcodec_open2(encoder.get(), nullptr, nullptr) >= 0, "an image cannot be encoded as PNG");
  const FramePointer frame = MakeFrame(*encoder);
  gray.copyTo(Plane(*frame, 0, gray.size()));
  return Encoded(*encoder, *frame);
}

std::string EncodeJpeg(const cv::Mat& image, int quality) {
  Ensure((image.type() == CV_8UC1 || image.type() == CV_8UC3) && !image.empty(), "a JPEG takes an 8-bit image");
  Ensure(quality >= 1 && quality <= 100, "the quality of a JPEG is from 1 to 100");
  const CodecPointer encoder = MakeEncoder(AV_CODEC_ID_MJPEG, AV_PIX_FMT_YUVJ420P, image.size());
  encoder->color_range = AVCOL_RANGE_JPEG;
  // Otherwise there is no JFIF header.
  encoder->sample_aspect_ratio = {1, 1};
  encoder->intra_matrix = ScaledTable(kLumaTable, quality);
  encoder->chroma_intra_matrix = ScaledTable(kChromaTable, quality);
  encoder->flags |= AV_CODEC_FLAG_QSCALE;
  encoder->global_quality = kPlainStep * FF_QP2LAMBDA;
  Ensure(avcodec_open2(encoder.get(), nullptr, nullptr) >= 0, "an image cannot be encoded as JPEG");
  const FramePointer frame = MakeFrame(*encoder);
  frame->quality = encoder->global_quality;
  const cv::Size half((image.cols + 1) / 2, (image.rows + 1) / 2);
  if (image.channels() == 1) {
    constexpr int kNoColour = 128;
    image.copyTo(Plane(*frame, 0, image.size()));
    for (const int plane : {1, 2}) Plane(*frame, plane, half).setTo(kNoColour);
    return Encoded(*encoder, *frame);
  }
  cv::Mat padded;
  cv::copyMakeBorder(image, padded, 0, image.rows % 2, 0, image.cols % 2, cv::BORDER_REPLICATE);
  cv::cvtColor(padded, padded, cv::COLOR_BGR2YCrCb);
  std::array<cv::Mat, 3> planes;
  cv::split(padded, planes.data());
  planes[0](cv::Rect({}, image.size())).copyTo(Plane(*frame, 0, image.size()));
  for (const int plane : {1, 2}) {
    cv::Mat chroma;
    cv::resize(planes[static_cast<size_t>(3 - plane)], chroma, half, 0, 0, cv::INTER_AREA);
    chroma.copyTo(Plane(*frame, plane, half));
  }
  return Encoded(*encoder, *frame);
}

}  // namespace turnscale
