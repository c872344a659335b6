// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <new>

#include "turnscale/image_file/ffmpeg.h"

namespace turnscale {

struct FreeCodec {
  void operator()(AVCodecContext* context) const { ffmpeg::avcodec_free_context(&context); }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { ffmpeg::av_packet_free(&packet); }
};
struct FreeFrame {
  void operator()(AVFrame* frame) const { ffmpeg::av_frame_free(&frame); }
};

/// FFmpeg's objects, with their owner.
using CodecPointer = std::unique_ptr<AVCodecContext, FreeCodec>;
using PacketPointer = std::unique_ptr<AVPacket, FreePacket>;
using FramePointer = std::unique_ptr<AVFrame, FreeFrame>;

/// What FFmpeg has allocated. Throws std::bad_alloc where there is nothing.
template <class Pointer>
Pointer* Allocated(Pointer* pointer) {
  if (pointer == nullptr) throw std::bad_alloc();
  return pointer;
}

}  // namespace turnscale
