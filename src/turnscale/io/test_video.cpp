// SPDX-License-Identifier: MIT
#include "turnscale/io/test_video.h"

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

class Writer {
 public:
  Writer(const std::filesystem::path& path, cv::Size size, const TestVideo& video) : video_(video) {
    av_log_set_level(AV_LOG_QUIET);
    Checked(avformat_alloc_output_context2(&output_, nullptr, nullptr, path.c_str()), "container");
    const AVCodec* codec = avcodec_find_encoder_by_name(video.codec.c_str());
    if (codec == nullptr) throw std::runtime_error("test video: no encoder " + video.codec);
    encoder_ = avcodec_alloc_context3(codec);
    encoder_->width = size.width;
    encoder_->height = size.height;
    encoder_->time_base = {1, video.ticks_per_second};
    encoder_->framerate = {video.stamps.empty() ? video.ticks_per_second : 25, 1};
    encoder_->pix_fmt = video.bits == 10         ? AV_PIX_FMT_YUV420P10
                        : video.codec == "mjpeg" ? AV_PIX_FMT_YUVJ420P
                                                 : AV_PIX_FMT_YUV420P;
    encoder_->color_range = video.full_range || video.codec == "mjpeg" ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
    if (video.pixel_aspect != 1) encoder_->sample_aspect_ratio = av_d2q(video.pixel_aspect, 255);
    encoder_->gop_size = video.key_interval;
    encoder_->max_b_frames = video.b_frames;
    encoder_->strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;
    // Of good quality: tests compare gray values.
    encoder_->flags |= AV_CODEC_FLAG_QSCALE | AV_CODEC_FLAG_BITEXACT;
    encoder_->global_quality = 2 * FF_QP2LAMBDA;
    if (video.interlaced) encoder_->flags |= AV_CODEC_FLAG_INTERLACED_DCT | AV_CODEC_FLAG_INTERLACED_ME;
    if ((output_->oformat->flags & AVFMT_GLOBALHEADER) != 0) encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    Checked(avcodec_open2(encoder_, codec, nullptr), "encoder");
    stream_ = avformat_new_stream(output_, nullptr);
    stream_->time_base = encoder_->time_base;
    stream_->sample_aspect_ratio = encoder_->sample_aspect_ratio;
    stream_->avg_frame_rate = encoder_->framerate;
    Checked(avcodec_parameters_from_context(stream_->codecpar, encoder_), "parameters");
    if (video.quarter_turns != 0 || video.mirrored) {
      auto* matrix =
          reinterpret_cast<int32_t*>(av_stream_new_side_data(stream_, AV_PKT_DATA_DISPLAYMATRIX, 9 * sizeof(int32_t)));
      av_display_rotation_set(matrix, 90.0 * video.quarter_turns);
      av_display_matrix_flip(matrix, video.mirrored ? 1 : 0, 0);
    }
    if (!video.created.empty()) av_dict_set(&output_->metadata, "creation_time", video.created.c_str(), 0);
    Checked(avio_open(&output_->pb, path.c_str(), AVIO_FLAG_WRITE), "file");
    Checked(avformat_write_header(output_, nullptr), "header");
    packet_ = av_packet_alloc();
  }

  ~Writer() {
    av_packet_free(&packet_);
    avcodec_free_context(&encoder_);
    avio_closep(&output_->pb);
    avformat_free_context(output_);
  }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void Add(const cv::Mat& image, int64_t stamp) {
    AVFrame* frame = av_frame_alloc();
    frame->format = encoder_->pix_fmt;
    frame->width = image.cols;
    frame->height = image.rows;
    frame->color_range = encoder_->color_range;
    Checked(av_frame_get_buffer(frame, 0), "frame");
    SwsContext* converter =
        sws_getContext(image.cols, image.rows, image.channels() == 1 ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_BGR24, image.cols,
                       image.rows, encoder_->pix_fmt, SWS_BICUBIC | SWS_ACCURATE_RND, nullptr, nullptr, nullptr);
    const int* coefficients = sws_getCoefficients(SWS_CS_DEFAULT);
    const int full = encoder_->color_range == AVCOL_RANGE_JPEG ? 1 : 0;
    sws_setColorspaceDetails(converter, coefficients, 1, coefficients, full, 0, 1 << 16, 1 << 16);
    const uint8_t* const rows[] = {image.data};
    const int strides[] = {static_cast<int>(image.step)};
    sws_scale(converter, rows, strides, 0, image.rows, frame->data, frame->linesize);
    sws_freeContext(converter);
    frame->pts = stamp;
    frame->quality = encoder_->global_quality;
    frame->interlaced_frame = video_.interlaced ? 1 : 0;
    frame->top_field_first = frame->interlaced_frame;
    Checked(avcodec_send_frame(encoder_, frame), "encoding");
    av_frame_free(&frame);
    Drain();
  }

  void Finish() {
    Checked(avcodec_send_frame(encoder_, nullptr), "encoding");
    Drain();
    Checked(av_write_trailer(output_), "trailer");
  }

 private:
  void Drain() {
    while (avcodec_receive_packet(encoder_, packet_) == 0) {
      packet_->stream_index = stream_->index;
      av_packet_rescale_ts(packet_, encoder_->time_base, stream_->time_base);
      Checked(av_interleaved_write_frame(output_, packet_), "writing");
    }
  }

  const TestVideo& video_;
  AVFormatContext* output_ = nullptr;
  AVCodecContext* encoder_ = nullptr;
  AVStream* stream_ = nullptr;
  AVPacket* packet_ = nullptr;
};

}  // namespace

void WriteTestVideo(const std::filesystem::path& path, const std::vector<cv::Mat>& images, const TestVideo& video) {
  Writer writer(path, images.at(0).size(), video);
  for (size_t i = 0; i < images.size(); ++i)
    writer.Add(images[i], video.stamps.empty() ? static_cast<int64_t>(i) : video.stamps.at(i));
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
