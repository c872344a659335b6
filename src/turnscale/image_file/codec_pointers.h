// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <new>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/frame.h>
#include <libavutil/mem.h>
}

namespace turnscale {

struct FreeCodec {
  void operator()(AVCodecContext* context) const {
    // Some versions of the library forget it.
    av_freep(&context->chroma_intra_matrix);
    avcodec_free_context(&context);
  }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
struct FreeFrame {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
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
