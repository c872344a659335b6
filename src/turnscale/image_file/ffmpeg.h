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
#include <libavutil/mem.h>
#include <libavutil/opt.h>
#include <libavutil/parseutils.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

/// FFmpeg's functions under their own names, from shared libraries that are loaded when the first of them is called.
/// These depend on a hundred others, which take 60 ms to load, twice as long as the rest of the program: as long as no
/// video is read, nothing waits for them.
namespace turnscale::ffmpeg {

enum class Library { kUtil, kCodec, kFormat, kScale };

/// Address of a function. Throws InputError that says what to install where the library cannot be loaded.
void* AddressOf(Library library, const char* name);

template <typename Signature>
class Function;

/// A function that is looked up when it is first called.
template <typename Result, typename... Arguments>
class Function<Result(Arguments...)> {
 public:
  constexpr Function(Library library, const char* name) : library_(library), name_(name) {}

  Result operator()(Arguments... arguments) const {
    void* address = address_.load(std::memory_order_relaxed);
    if (address == nullptr) {
      address = AddressOf(library_, name_);
      address_.store(address, std::memory_order_relaxed);
    }
    return reinterpret_cast<Result (*)(Arguments...)>(address)(arguments...);
  }

 private:
  Library library_;
  const char* name_;
  mutable std::atomic<void*> address_ = nullptr;
};

inline constinit const Function<decltype(::av_d2q)> av_d2q{Library::kUtil, "av_d2q"};
inline constinit const Function<decltype(::av_dict_free)> av_dict_free{Library::kUtil, "av_dict_free"};
inline constinit const Function<decltype(::av_dict_get)> av_dict_get{Library::kUtil, "av_dict_get"};
inline constinit const Function<decltype(::av_dict_set_int)> av_dict_set_int{Library::kUtil, "av_dict_set_int"};
inline constinit const Function<decltype(::av_frame_alloc)> av_frame_alloc{Library::kUtil, "av_frame_alloc"};
inline constinit const Function<decltype(::av_frame_free)> av_frame_free{Library::kUtil, "av_frame_free"};
inline constinit const Function<decltype(::av_frame_get_buffer)> av_frame_get_buffer{Library::kUtil,
                                                                                     "av_frame_get_buffer"};
inline constinit const Function<decltype(::av_frame_make_writable)> av_frame_make_writable{Library::kUtil,
                                                                                           "av_frame_make_writable"};
inline constinit const Function<decltype(::av_freep)> av_freep{Library::kUtil, "av_freep"};
inline constinit const Function<decltype(::av_image_get_linesize)> av_image_get_linesize{Library::kUtil,
                                                                                         "av_image_get_linesize"};
inline constinit const Function<decltype(::av_log_set_level)> av_log_set_level{Library::kUtil, "av_log_set_level"};
inline constinit const Function<decltype(::av_opt_find)> av_opt_find{Library::kUtil, "av_opt_find"};
inline constinit const Function<decltype(::av_opt_set)> av_opt_set{Library::kUtil, "av_opt_set"};
inline constinit const Function<decltype(::av_opt_set_int)> av_opt_set_int{Library::kUtil, "av_opt_set_int"};
inline constinit const Function<decltype(::av_parse_time)> av_parse_time{Library::kUtil, "av_parse_time"};
inline constinit const Function<decltype(::av_pix_fmt_count_planes)> av_pix_fmt_count_planes{Library::kUtil,
                                                                                             "av_pix_fmt_count_planes"};
inline constinit const Function<decltype(::av_pix_fmt_desc_get)> av_pix_fmt_desc_get{Library::kUtil,
                                                                                     "av_pix_fmt_desc_get"};
inline constinit const Function<decltype(::av_read_image_line2)> av_read_image_line2{Library::kUtil,
                                                                                     "av_read_image_line2"};
inline constinit const Function<decltype(::av_strerror)> av_strerror{Library::kUtil, "av_strerror"};

inline constinit const Function<decltype(::av_new_packet)> av_new_packet{Library::kCodec, "av_new_packet"};
inline constinit const Function<decltype(::av_packet_alloc)> av_packet_alloc{Library::kCodec, "av_packet_alloc"};
inline constinit const Function<decltype(::av_packet_free)> av_packet_free{Library::kCodec, "av_packet_free"};
inline constinit const Function<decltype(::av_packet_rescale_ts)> av_packet_rescale_ts{Library::kCodec,
                                                                                       "av_packet_rescale_ts"};
inline constinit const Function<decltype(::av_packet_unref)> av_packet_unref{Library::kCodec, "av_packet_unref"};
inline constinit const Function<decltype(::avcodec_alloc_context3)> avcodec_alloc_context3{Library::kCodec,
                                                                                           "avcodec_alloc_context3"};
inline constinit const Function<decltype(::avcodec_default_get_buffer2)> avcodec_default_get_buffer2{
    Library::kCodec, "avcodec_default_get_buffer2"};
inline constinit const Function<decltype(::avcodec_find_decoder)> avcodec_find_decoder{Library::kCodec,
                                                                                       "avcodec_find_decoder"};
inline constinit const Function<decltype(::avcodec_find_encoder_by_name)> avcodec_find_encoder_by_name{
    Library::kCodec, "avcodec_find_encoder_by_name"};
inline constinit const Function<decltype(::avcodec_free_context)> avcodec_free_context{Library::kCodec,
                                                                                       "avcodec_free_context"};
inline constinit const Function<decltype(::avcodec_open2)> avcodec_open2{Library::kCodec, "avcodec_open2"};
inline constinit const Function<decltype(::avcodec_parameters_from_context)> avcodec_parameters_from_context{
    Library::kCodec, "avcodec_parameters_from_context"};
inline constinit const Function<decltype(::avcodec_parameters_to_context)> avcodec_parameters_to_context{
    Library::kCodec, "avcodec_parameters_to_context"};
inline constinit const Function<decltype(::avcodec_receive_frame)> avcodec_receive_frame{Library::kCodec,
                                                                                         "avcodec_receive_frame"};
inline constinit const Function<decltype(::avcodec_receive_packet)> avcodec_receive_packet{Library::kCodec,
                                                                                           "avcodec_receive_packet"};
inline constinit const Function<decltype(::avcodec_send_frame)> avcodec_send_frame{Library::kCodec,
                                                                                   "avcodec_send_frame"};
inline constinit const Function<decltype(::avcodec_send_packet)> avcodec_send_packet{Library::kCodec,
                                                                                     "avcodec_send_packet"};

inline constinit const Function<decltype(::av_find_best_stream)> av_find_best_stream{Library::kFormat,
                                                                                     "av_find_best_stream"};
inline constinit const Function<decltype(::av_interleaved_write_frame)> av_interleaved_write_frame{
    Library::kFormat, "av_interleaved_write_frame"};
inline constinit const Function<decltype(::av_read_frame)> av_read_frame{Library::kFormat, "av_read_frame"};
inline constinit const Function<decltype(::av_stream_get_side_data)> av_stream_get_side_data{Library::kFormat,
                                                                                             "av_stream_get_side_data"};
inline constinit const Function<decltype(::av_write_trailer)> av_write_trailer{Library::kFormat, "av_write_trailer"};
inline constinit const Function<decltype(::avformat_alloc_output_context2)> avformat_alloc_output_context2{
    Library::kFormat, "avformat_alloc_output_context2"};
inline constinit const Function<decltype(::avformat_close_input)> avformat_close_input{Library::kFormat,
                                                                                       "avformat_close_input"};
inline constinit const Function<decltype(::avformat_find_stream_info)> avformat_find_stream_info{
    Library::kFormat, "avformat_find_stream_info"};
inline constinit const Function<decltype(::avformat_free_context)> avformat_free_context{Library::kFormat,
                                                                                         "avformat_free_context"};
inline constinit const Function<decltype(::avformat_new_stream)> avformat_new_stream{Library::kFormat,
                                                                                     "avformat_new_stream"};
inline constinit const Function<decltype(::avformat_open_input)> avformat_open_input{Library::kFormat,
                                                                                     "avformat_open_input"};
inline constinit const Function<decltype(::avformat_write_header)> avformat_write_header{Library::kFormat,
                                                                                         "avformat_write_header"};
inline constinit const Function<decltype(::avio_closep)> avio_closep{Library::kFormat, "avio_closep"};
inline constinit const Function<decltype(::avio_open)> avio_open{Library::kFormat, "avio_open"};

inline constinit const Function<decltype(::sws_alloc_context)> sws_alloc_context{Library::kScale, "sws_alloc_context"};
inline constinit const Function<decltype(::sws_freeContext)> sws_freeContext{Library::kScale, "sws_freeContext"};
inline constinit const Function<decltype(::sws_init_context)> sws_init_context{Library::kScale, "sws_init_context"};
inline constinit const Function<decltype(::sws_scale)> sws_scale{Library::kScale, "sws_scale"};
}  // namespace turnscale::ffmpeg
