// SPDX-License-Identifier: MIT
#include "turnscale/frames/video_writer.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <new>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"
#include "turnscale/image_file/codec_pointers.h"
#include "turnscale/image_file/ffmpeg.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/range_check.h"

namespace turnscale {
namespace {

// Gray of video is 16...235; colour in the middle of its range is none.
constexpr int kBlack = 16;
constexpr int kGrayRange = 219;
constexpr int kNoColour = 128;

cv::Mat MakeLuma() {
  cv::Mat luma(1, 256, CV_8U);
  for (int gray = 0; gray < luma.cols; ++gray)
    luma.at<uchar>(gray) = static_cast<uchar>(kBlack + std::lround(gray * kGrayRange / 255.0));
  return luma;
}

// FFmpeg returns the system's errors with their sign changed, and adds errors of its own.
std::string Message(int result) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  ffmpeg::av_strerror(result, text, sizeof(text));
  return text;
}

}  // namespace

struct VideoWriter::State {
  struct CloseOutput {
    void operator()(AVFormatContext* context) const {
      ffmpeg::avio_closep(&context->pb);
      ffmpeg::avformat_free_context(context);
    }
  };
  State(const std::filesystem::path& file, const cv::Size& image_size, const VideoWriterOptions& options)
      : path(file), size(image_size), luma(MakeLuma()) {
    options.Check();
    if (size.width < 16 || size.height < 16 || size.width % 2 != 0 || size.height % 2 != 0) {
      throw InputError(fmt::format("{}: a video needs images with even numbers of pixels from 16 on, not {}x{}",
                                   path.string(), size.width, size.height));
    }
    // The library would write its own complaints to standard error.
    ffmpeg::av_log_set_level(AV_LOG_QUIET);
    AVFormatContext* made = nullptr;
    if (ffmpeg::avformat_alloc_output_context2(&made, nullptr, "mp4", nullptr) < 0)
      throw InputError(path.string() + ": FFmpeg's libraries cannot write MP4 here; install a build that can");
    output.reset(made);
    output->flags |= AVFMT_FLAG_BITEXACT;
    OpenEncoder(options);
    OpenFile();
    packet.reset(Allocated(ffmpeg::av_packet_alloc()));
    frame.reset(Allocated(ffmpeg::av_frame_alloc()));
    frame->format = encoder->pix_fmt;
    frame->width = size.width;
    frame->height = size.height;
    frame->color_range = encoder->color_range;
    if (ffmpeg::av_frame_get_buffer(frame.get(), 0) < 0) throw std::bad_alloc();
  }

  // Removes the file under its temporary name, also where the constructor throws.
  struct Part {
    std::filesystem::path path;  // empty until the file is made, and once it has its own name
    ~Part() {
      std::error_code error;
      if (!path.empty()) std::filesystem::remove(path, error);
    }
  };

  void OpenEncoder(const VideoWriterOptions& options) {
    const AVCodec* codec = options.h264 ? ffmpeg::avcodec_find_encoder_by_name("libx264") : nullptr;
    const bool h264 = codec != nullptr;
    if (!h264) codec = ffmpeg::avcodec_find_encoder_by_name("mpeg4");
    if (codec == nullptr) {
      throw InputError(path.string() +
                       ": FFmpeg's libraries have no encoder for H.264 or MPEG-4 here; install a build that has, or "
                       "write images");
    }
    encoder.reset(Allocated(ffmpeg::avcodec_alloc_context3(codec)));
    encoder->width = size.width;
    encoder->height = size.height;
    encoder->pix_fmt = AV_PIX_FMT_YUV420P;
    encoder->color_range = AVCOL_RANGE_MPEG;
    encoder->time_base = {1, kVideoTicksPerSecond};
    encoder->framerate = ffmpeg::av_d2q(options.rate_hz, 1'000'000);
    encoder->bit_rate = std::llround(1e6 * options.megabits_per_second);
    encoder->rc_max_rate = encoder->bit_rate;
    // One second.
    encoder->rc_buffer_size = static_cast<int>(encoder->bit_rate);
    encoder->gop_size = std::max(1, static_cast<int>(std::lround(options.key_seconds * options.rate_hz)));
    encoder->max_b_frames = 0;
    // The result of rate control depends on the number of threads.
    encoder->thread_count = 1;
    encoder->flags |= AV_CODEC_FLAG_BITEXACT;
    if ((output->oformat->flags & AVFMT_GLOBALHEADER) != 0) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    if (h264) {
      // About what the encoder in a camera's chip does, which knows no later frames.
      ffmpeg::av_opt_set(encoder->priv_data, "preset", "veryfast", 0);
      ffmpeg::av_opt_set(encoder->priv_data, "x264-params", "rc-lookahead=0:mbtree=0:scenecut=0", 0);
    }
    if (const int result = ffmpeg::avcodec_open2(encoder.get(), codec, nullptr); result < 0) {
      throw InputError(fmt::format("{}: the encoder {} does not take these images: {}", path.string(), codec->name,
                                   Message(result)));
    }
  }

  void OpenFile() {
    stream = Allocated(ffmpeg::avformat_new_stream(output.get(), nullptr));
    stream->time_base = encoder->time_base;
    stream->avg_frame_rate = encoder->framerate;
    if (ffmpeg::avcodec_parameters_from_context(stream->codecpar, encoder.get()) < 0) throw std::bad_alloc();
    const std::filesystem::path part = PartOf(path);
    if (const int result = ffmpeg::avio_open(&output->pb, ("file:" + part.string()).c_str(), AVIO_FLAG_WRITE);
        result < 0)
      throw InputError(path.string() + ": cannot be written: " + Message(result) + "; choose another place");
    unfinished.path = part;
    AVDictionary* options = nullptr;
    // Otherwise the container counts in a multiple.
    ffmpeg::av_dict_set_int(&options, "video_track_timescale", kVideoTicksPerSecond, 0);
    const int result = ffmpeg::avformat_write_header(output.get(), &options);
    ffmpeg::av_dict_free(&options);
    Checked(result);
  }

  void Checked(int result) const {
    if (result == AVERROR(ENOMEM)) throw std::bad_alloc();
    if (result < 0) throw OutputError(path.string() + ": cannot be written: " + Message(result));
  }

  // What the encoder has ready goes to the file.
  void Drain() {
    while (true) {
      const int result = ffmpeg::avcodec_receive_packet(encoder.get(), packet.get());
      if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) break;
      Checked(result);
      packet->stream_index = stream->index;
      ffmpeg::av_packet_rescale_ts(packet.get(), encoder->time_base, stream->time_base);
      Checked(ffmpeg::av_interleaved_write_frame(output.get(), packet.get()));
    }
    // Writes through the library's buffer fail when it is emptied.
    Checked(output->pb->error);
  }

  void Add(const cv::Mat& gray, double seconds) {
    Ensure(gray.type() == CV_8UC1 && gray.size() == size, "an image of a video has another size or type");
    const int64_t tick = std::llround(seconds * kVideoTicksPerSecond);
    Ensure(tick > last_tick, "the time stamps of a video do not increase");
    Ensure(!unfinished.path.empty(), "the video is finished");
    last_tick = tick;
    if (ffmpeg::av_frame_make_writable(frame.get()) < 0) throw std::bad_alloc();
    cv::Mat y(size, CV_8U, frame->data[0], static_cast<size_t>(frame->linesize[0]));
    cv::LUT(gray, luma, y);
    for (const int plane : {1, 2}) {
      const auto stride = static_cast<size_t>(frame->linesize[plane]);
      cv::Mat(size / 2, CV_8U, frame->data[plane], stride).setTo(kNoColour);
    }
    frame->pts = tick;
    Checked(ffmpeg::avcodec_send_frame(encoder.get(), frame.get()));
    Drain();
  }

  void Finish() {
    Ensure(!unfinished.path.empty(), "the video is finished");
    Checked(ffmpeg::avcodec_send_frame(encoder.get(), nullptr));
    Drain();
    Checked(ffmpeg::av_write_trailer(output.get()));
    Checked(ffmpeg::avio_closep(&output->pb));
    std::error_code error;
    std::filesystem::rename(unfinished.path, path, error);
    if (error) throw OutputError(path.string() + ": cannot be written: " + error.message());
    unfinished.path.clear();
  }

  std::filesystem::path path;
  Part unfinished;
  cv::Size size;
  cv::Mat luma;  // of each gray level
  std::unique_ptr<AVFormatContext, CloseOutput> output;
  CodecPointer encoder;
  PacketPointer packet;
  FramePointer frame;
  AVStream* stream = nullptr;
  int64_t last_tick = -1;
};

void VideoWriterOptions::Check() const {
  CheckRange("video.rate_hz", rate_hz, 0.1, 1000);
  CheckRange("video.megabits_per_second", megabits_per_second, 0.01, 1000);
  CheckRange("video.key_seconds", key_seconds, 0, 3600);
}

VideoWriter::VideoWriter(const std::filesystem::path& path, const cv::Size& size, const VideoWriterOptions& options)
    : state_(std::make_unique<State>(path, size, options)) {}

VideoWriter::~VideoWriter() = default;

void VideoWriter::Add(const cv::Mat& gray, double seconds) { state_->Add(gray, seconds); }

void VideoWriter::Finish() { state_->Finish(); }

}  // namespace turnscale
