// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/dict.h>
#include <libavutil/frame.h>
#include <libavutil/imgutils.h>
#include <libavutil/log.h>
#include <libavutil/opt.h>
#include <libavutil/parseutils.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

/// FFmpeg's functions under their own names, from shared libraries that are loaded when the first of them is called:
/// for videos, and for images other than 8-bit gray PNG. The libraries depend on a hundred others, whose loading takes
/// about twice as long as that of the rest of the program.
namespace turnscale::ffmpeg {

enum class Library { kUtil, kCodec, kFormat, kScale };

/// Address of a function. Throws InputError that says what to install where the library cannot be loaded or has no such
/// function.
void* AddressOf(Library library, const char* name);

template <typename Signature>
class Function;

/// A function that is looked up when it is first called.
template <typename Result, typename... Arguments>
class Function<Result(Arguments...)> {
 public:
  constexpr Function(Library library, const char* name) : library_(library), name_(name) {}

  Result operator()(Arguments... arguments) const {
    void* address = address_.load(std::memory_order_acquire);
    if (address == nullptr) {
      address = AddressOf(library_, name_);
      address_.store(address, std::memory_order_release);
    }
    return reinterpret_cast<Result (*)(Arguments...)>(address)(arguments...);
  }

 private:
  Library library_;
  const char* name_;
  mutable std::atomic<void*> address_ = nullptr;
};

/// Only for decltype. The type is deduced without the attributes of the headers, which it cannot carry.
template <typename Result, typename... Arguments>
Function<Result(Arguments...)> FunctionLike(Result (*)(Arguments...));

// NOLINTBEGIN(bugprone-macro-parentheses): a name that is declared has none.
#define TURNSCALE_FFMPEG(library, name) \
  inline constinit const decltype(FunctionLike(::name)) name(Library::library, #name)
// NOLINTEND(bugprone-macro-parentheses)

TURNSCALE_FFMPEG(kUtil, av_d2q);
TURNSCALE_FFMPEG(kUtil, av_dict_free);
TURNSCALE_FFMPEG(kUtil, av_dict_get);
TURNSCALE_FFMPEG(kUtil, av_dict_set_int);
TURNSCALE_FFMPEG(kUtil, av_frame_alloc);
TURNSCALE_FFMPEG(kUtil, av_frame_free);
TURNSCALE_FFMPEG(kUtil, av_frame_get_buffer);
TURNSCALE_FFMPEG(kUtil, av_frame_make_writable);
TURNSCALE_FFMPEG(kUtil, av_image_get_linesize);
TURNSCALE_FFMPEG(kUtil, av_log_set_level);
TURNSCALE_FFMPEG(kUtil, av_opt_find);
TURNSCALE_FFMPEG(kUtil, av_opt_set);
TURNSCALE_FFMPEG(kUtil, av_opt_set_int);
TURNSCALE_FFMPEG(kUtil, av_parse_time);
TURNSCALE_FFMPEG(kUtil, av_pix_fmt_count_planes);
TURNSCALE_FFMPEG(kUtil, av_pix_fmt_desc_get);
TURNSCALE_FFMPEG(kUtil, av_read_image_line2);
TURNSCALE_FFMPEG(kUtil, av_strerror);

TURNSCALE_FFMPEG(kCodec, av_new_packet);
TURNSCALE_FFMPEG(kCodec, av_packet_alloc);
TURNSCALE_FFMPEG(kCodec, av_packet_free);
TURNSCALE_FFMPEG(kCodec, av_packet_rescale_ts);
TURNSCALE_FFMPEG(kCodec, av_packet_unref);
TURNSCALE_FFMPEG(kCodec, avcodec_alloc_context3);
TURNSCALE_FFMPEG(kCodec, avcodec_default_get_buffer2);
TURNSCALE_FFMPEG(kCodec, avcodec_find_decoder);
TURNSCALE_FFMPEG(kCodec, avcodec_find_encoder_by_name);
TURNSCALE_FFMPEG(kCodec, avcodec_free_context);
TURNSCALE_FFMPEG(kCodec, avcodec_open2);
TURNSCALE_FFMPEG(kCodec, avcodec_parameters_from_context);
TURNSCALE_FFMPEG(kCodec, avcodec_parameters_to_context);
TURNSCALE_FFMPEG(kCodec, avcodec_receive_frame);
TURNSCALE_FFMPEG(kCodec, avcodec_receive_packet);
TURNSCALE_FFMPEG(kCodec, avcodec_send_frame);
TURNSCALE_FFMPEG(kCodec, avcodec_send_packet);

TURNSCALE_FFMPEG(kFormat, av_guess_sample_aspect_ratio);
TURNSCALE_FFMPEG(kFormat, av_interleaved_write_frame);
TURNSCALE_FFMPEG(kFormat, av_read_frame);
TURNSCALE_FFMPEG(kFormat, av_stream_get_side_data);
TURNSCALE_FFMPEG(kFormat, av_write_trailer);
TURNSCALE_FFMPEG(kFormat, avformat_alloc_output_context2);
TURNSCALE_FFMPEG(kFormat, avformat_close_input);
TURNSCALE_FFMPEG(kFormat, avformat_find_stream_info);
TURNSCALE_FFMPEG(kFormat, avformat_free_context);
TURNSCALE_FFMPEG(kFormat, avformat_index_get_entries_count);
TURNSCALE_FFMPEG(kFormat, avformat_index_get_entry);
TURNSCALE_FFMPEG(kFormat, avformat_new_stream);
TURNSCALE_FFMPEG(kFormat, avformat_open_input);
TURNSCALE_FFMPEG(kFormat, avformat_write_header);
TURNSCALE_FFMPEG(kFormat, avio_closep);
TURNSCALE_FFMPEG(kFormat, avio_open);

TURNSCALE_FFMPEG(kScale, sws_alloc_context);
TURNSCALE_FFMPEG(kScale, sws_freeContext);
TURNSCALE_FFMPEG(kScale, sws_init_context);
TURNSCALE_FFMPEG(kScale, sws_scale);

#undef TURNSCALE_FFMPEG

}  // namespace turnscale::ffmpeg
