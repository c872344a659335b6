// SPDX-License-Identifier: MIT
#include "turnscale/frames/test_video.h"

#include <memory>
#include <stdexcept>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libswscale/swscale.h>
}

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace turnscale {
namespace {

int Checked(int result, const char* what) {
  if (result < 0) throw std::runtime_error(std::string("test video: ") + what + " failed");
  return result;
}

struct Track {
  AVCodecContext* encoder = nullptr;
  AVStream* stream = nullptr;
};

class Writer {
 public:
  Writer(const std::filesystem::path& path, const TestVideo& video) : video_(video), path_(path) {
    av_log_set_level(AV_LOG_QUIET);
    Checked(avformat_alloc_output_context2(&output_, nullptr, nullptr, path.c_str()), "container");
    if (!video.created.empty()) av_dict_set(&output_->metadata, "creation_time", video.created.c_str(), 0);
  }

  ~Writer() {
    av_packet_free(&packet_);
    for (Track& track : tracks_) avcodec_free_context(&track.encoder);
    avio_closep(&output_->pb);
    avformat_free_context(output_);
  }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  // Before Begin.
  void AddTrack(cv::Size size) {
    const AVCodec* codec = avcodec_find_encoder_by_name(video_.codec.c_str());
    if (codec == nullptr) throw std::runtime_error("test video: no encoder " + video_.codec);
    AVCodecContext* encoder = avcodec_alloc_context3(codec);
    tracks_.push_back({encoder, avformat_new_stream(output_, nullptr)});
    AVStream* stream = tracks_.back().stream;
    encoder->width = size.width;
    encoder->height = size.height;
    encoder->time_base = {1, video_.ticks_per_second};
    encoder->framerate = {video_.stamps.empty() ? video_.ticks_per_second : 25, 1};
    encoder->pix_fmt = video_.bits == 10         ? AV_PIX_FMT_YUV420P10
                       : video_.codec == "mjpeg" ? AV_PIX_FMT_YUVJ420P
                                                 : AV_PIX_FMT_YUV420P;
    encoder->color_range = video_.full_range || video_.codec == "mjpeg" ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
    if (video_.pixel_aspect != 1) encoder->sample_aspect_ratio = av_d2q(video_.pixel_aspect, 255);
    encoder->gop_size = video_.key_interval;
    encoder->max_b_frames = video_.b_frames;
    encoder->strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;
    // Of good quality: tests compare gray values.
    encoder->flags |= AV_CODEC_FLAG_QSCALE | AV_CODEC_FLAG_BITEXACT;
    encoder->global_quality = 2 * FF_QP2LAMBDA;
    if (video_.interlaced) encoder->flags |= AV_CODEC_FLAG_INTERLACED_DCT | AV_CODEC_FLAG_INTERLACED_ME;
    if ((output_->oformat->flags & AVFMT_GLOBALHEADER) != 0) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    Checked(avcodec_open2(encoder, codec, nullptr), "encoder");
    stream->time_base = encoder->time_base;
    stream->sample_aspect_ratio = encoder->sample_aspect_ratio;
    stream->avg_frame_rate = encoder->framerate;
    Checked(avcodec_parameters_from_context(stream->codecpar, encoder), "parameters");
    if (video_.quarter_turns != 0 || video_.mirrored) {
      auto* matrix =
          reinterpret_cast<int32_t*>(av_stream_new_side_data(stream, AV_PKT_DATA_DISPLAYMATRIX, 9 * sizeof(int32_t)));
      av_display_rotation_set(matrix, 90.0 * video_.quarter_turns);
      av_display_matrix_flip(matrix, video_.mirrored ? 1 : 0, 0);
    }
  }

  // Players show it rather than the others.
  void PreferLastTrack() { tracks_.back().stream->disposition |= AV_DISPOSITION_DEFAULT; }

  void Begin() {
    Checked(avio_open(&output_->pb, path_.c_str(), AVIO_FLAG_WRITE), "file");
    Checked(avformat_write_header(output_, nullptr), "header");
    packet_ = av_packet_alloc();
  }

  void Add(size_t track, const cv::Mat& image, int64_t stamp) {
    AVCodecContext* encoder = tracks_[track].encoder;
    AVFrame* frame = av_frame_alloc();
    frame->format = encoder->pix_fmt;
    frame->width = image.cols;
    frame->height = image.rows;
    frame->color_range = encoder->color_range;
    Checked(av_frame_get_buffer(frame, 0), "frame");
    SwsContext* converter =
        sws_getContext(image.cols, image.rows, image.channels() == 1 ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_BGR24, image.cols,
                       image.rows, encoder->pix_fmt, SWS_BICUBIC | SWS_ACCURATE_RND, nullptr, nullptr, nullptr);
    const int* coefficients = sws_getCoefficients(SWS_CS_DEFAULT);
    const int full = encoder->color_range == AVCOL_RANGE_JPEG ? 1 : 0;
    sws_setColorspaceDetails(converter, coefficients, 1, coefficients, full, 0, 1 << 16, 1 << 16);
    const uint8_t* const rows[] = {image.data};
    const int strides[] = {static_cast<int>(image.step)};
    sws_scale(converter, rows, strides, 0, image.rows, frame->data, frame->linesize);
    sws_freeContext(converter);
    frame->pts = stamp;
    frame->quality = encoder->global_quality;
    frame->interlaced_frame = video_.interlaced ? 1 : 0;
    frame->top_field_first = frame->interlaced_frame;
    Checked(avcodec_send_frame(encoder, frame), "encoding");
    av_frame_free(&frame);
    Drain(tracks_[track]);
  }

  void Finish() {
    for (const Track& track : tracks_) {
      Checked(avcodec_send_frame(track.encoder, nullptr), "encoding");
      Drain(track);
    }
    Checked(av_write_trailer(output_), "trailer");
  }

 private:
  void Drain(const Track& track) {
    while (avcodec_receive_packet(track.encoder, packet_) == 0) {
      packet_->stream_index = track.stream->index;
      av_packet_rescale_ts(packet_, track.encoder->time_base, track.stream->time_base);
      Checked(av_interleaved_write_frame(output_, packet_), "writing");
    }
  }

  const TestVideo& video_;
  std::filesystem::path path_;
  AVFormatContext* output_ = nullptr;
  std::vector<Track> tracks_;
  AVPacket* packet_ = nullptr;
};

}  // namespace

void WriteTestVideo(const std::filesystem::path& path, const std::vector<cv::Mat>& images, const TestVideo& video) {
  Writer writer(path, video);
  const size_t track = video.first_track.empty() ? 0 : 1;
  if (track > 0) writer.AddTrack(video.first_track.front().size());
  writer.AddTrack(images.at(0).size());
  writer.PreferLastTrack();
  writer.Begin();
  for (size_t i = 0; i < video.first_track.size(); ++i) writer.Add(0, video.first_track[i], static_cast<int64_t>(i));
  for (size_t i = 0; i < images.size(); ++i)
    writer.Add(track, images[i], video.stamps.empty() ? static_cast<int64_t>(i) : video.stamps.at(i));
  writer.Finish();
}

std::vector<cv::Mat> MovingTestImages(int first, int count) {
  constexpr int kPixelsPerImage = 3;
  constexpr int kMostImages = 200;
  const cv::Size size(160, 90);
  cv::Mat coarse(10, 80, CV_8UC1);
  cv::RNG(1).fill(coarse, cv::RNG::UNIFORM, 0, 256);
  cv::Mat texture;
  cv::resize(coarse, texture, {size.width + kPixelsPerImage * kMostImages, size.height});
  std::vector<cv::Mat> images;
  for (int i = first; i < first + count; ++i)
    images.push_back(texture(cv::Rect({kPixelsPerImage * i, 0}, size)).clone());
  return images;
}

}  // namespace turnscale
