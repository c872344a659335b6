// SPDX-License-Identifier: MIT
#include "turnscale/frames/video_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <opencv2/core.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/file_extension.h"
#include "turnscale/frames/image_rotation.h"
#include "turnscale/image_file/codec_pointers.h"
#include "turnscale/image_file/ffmpeg.h"

extern "C" {
#include <libavutil/display.h>
}

namespace turnscale {
namespace {

// Decodes faster than the odometry runs: more would only compete with it for the cores. A fixed number, as damaged
// streams may decode differently with others.
constexpr int kDecoderThreads = 1;

constexpr int kLevels = 256;  // of gray

// Of files that cannot be read without the index that a recorder writes last.
constexpr std::array<std::string_view, 4> kIndexedAtEnd = {".mp4", ".mov", ".m4v", ".3gp"};

[[noreturn]] void RefuseInterlaced(const std::string& path) {
  throw InputError(path +
                   ": is interlaced: its rows are not from one moment; deinterlace it first, such as by ffmpeg -i IN "
                   "-vf yadif OUT");
}

bool HasReadableEnds(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return file.get() != std::ifstream::traits_type::eof() && file.seekg(-1, std::ios::end) &&
         file.get() != std::ifstream::traits_type::eof();
}

bool IsIdentity(const std::array<uint8_t, kLevels>& table) {
  for (int level = 0; level < kLevels; ++level)
    if (table[level] != level) return false;
  return true;
}

double Seconds(const AVRational& time_base) { return av_q2d(time_base); }

// 1 where the file has no ratio, or an implausible one.
double PixelAspect(AVFormatContext& input, AVStream& stream) {
  constexpr double kMostAspect = 3;
  const AVRational ratio = ffmpeg::av_guess_sample_aspect_ratio(&input, &stream, nullptr);
  const double aspect = ratio.num > 0 && ratio.den > 0 ? av_q2d(ratio) : 1.0;
  return aspect < kMostAspect && aspect > 1 / kMostAspect ? aspect : 1.0;
}

// Whether the track is a picture that belongs to a video, such as its thumbnail.
bool IsPicture(const AVStream& track) {
  constexpr int kPicture = AV_DISPOSITION_ATTACHED_PIC | AV_DISPOSITION_TIMED_THUMBNAILS | AV_DISPOSITION_STILL_IMAGE;
  return (track.disposition & kPicture) != 0 || track.nb_frames == 1;
}

// Years before are clocks that were never set.
std::optional<double> CreationTime(const AVFormatContext& input, const AVStream& stream) {
  constexpr int64_t kYear2000 = 946684800;
  for (AVDictionary* metadata : {input.metadata, stream.metadata}) {
    const AVDictionaryEntry* entry = ffmpeg::av_dict_get(metadata, "creation_time", nullptr, 0);
    int64_t microseconds = 0;
    if (entry == nullptr || ffmpeg::av_parse_time(&microseconds, entry->value, 0) < 0) continue;
    if (microseconds > kYear2000 * 1'000'000) return 1e-6 * static_cast<double>(microseconds);
  }
  return std::nullopt;
}

}  // namespace

struct VideoFile::State {
  struct CloseInput {
    void operator()(AVFormatContext* context) const { ffmpeg::avformat_close_input(&context); }
  };
  struct FreeConverter {
    void operator()(SwsContext* context) const { ffmpeg::sws_freeContext(context); }
  };
  using Converter = std::unique_ptr<SwsContext, FreeConverter>;

  // How the stored image becomes the one to show.
  struct Orientation {
    bool transpose = false;
    bool flip_x = false;
    bool flip_y = false;
  };

  explicit State(const std::filesystem::path& file) : path(file.string()) {
    // The library would write its own complaints to standard error.
    ffmpeg::av_log_set_level(AV_LOG_QUIET);
    AVFormatContext* opened = nullptr;
    const int result = ffmpeg::avformat_open_input(&opened, ("file:" + path).c_str(), nullptr, nullptr);
    // A cut-off Matroska file is an input error to the library, too.
    if (result == AVERROR(EACCES) || (result == AVERROR(EIO) && !HasReadableEnds(path)))
      throw InputError(path + ": cannot be read: " + std::generic_category().message(AVUNERROR(result)));
    if (result < 0) Refuse();
    input.reset(opened);
    // The library draws any .txt file as a picture.
    if (std::string_view(opened->iformat->name) == "tty") Refuse();
    if (ffmpeg::avformat_find_stream_info(opened, nullptr) < 0) Refuse();
    const std::vector<AVStream*> tracks = Tracks();
    if (tracks.empty()) Refuse();
    // Always the first: dashcams put the videos of two cameras into one file, in the same order in every clip.
    stream = tracks.front();
    header.tracks = static_cast<int>(tracks.size());
    for (AVStream* other : std::span(opened->streams, opened->nb_streams))
      if (other != stream) other->discard = AVDISCARD_ALL;
    const AVCodec* codec = ffmpeg::avcodec_find_decoder(stream->codecpar->codec_id);
    decoder.reset(Allocated(ffmpeg::avcodec_alloc_context3(codec)));
    packet.reset(Allocated(ffmpeg::av_packet_alloc()));
    frame.reset(Allocated(ffmpeg::av_frame_alloc()));
    decoder->thread_count = kDecoderThreads;
    decoder->pkt_timebase = stream->time_base;
    if (ffmpeg::avcodec_parameters_to_context(decoder.get(), stream->codecpar) < 0 ||
        ffmpeg::avcodec_open2(decoder.get(), codec, nullptr) < 0) {
      Refuse();
    }
    const AVFieldOrder order = stream->codecpar->field_order;
    if (order != AV_FIELD_UNKNOWN && order != AV_FIELD_PROGRESSIVE) RefuseInterlaced(path);
    orientation = OrientationOf(*stream);
    ReadHeader();
  }

  // The videos that can be decoded; pictures only where there is nothing else.
  std::vector<AVStream*> Tracks() const {
    std::vector<AVStream*> videos;
    std::vector<AVStream*> pictures;
    for (AVStream* track : std::span(input->streams, input->nb_streams)) {
      const AVCodecParameters& codec = *track->codecpar;
      if (codec.codec_type != AVMEDIA_TYPE_VIDEO || codec.width <= 0 || codec.height <= 0) continue;
      if (ffmpeg::avcodec_find_decoder(codec.codec_id) == nullptr) continue;
      (IsPicture(*track) ? pictures : videos).push_back(track);
    }
    return videos.empty() ? pictures : videos;
  }

  [[noreturn]] void Refuse() const {
    std::error_code none;
    if (std::filesystem::is_regular_file(path, none) && std::filesystem::file_size(path, none) == 0)
      throw UnreadableVideo(path + ": is empty");
    const bool has_index = std::ranges::find(kIndexedAtEnd, LowerExtension(path)) != kIndexedAtEnd.end();
    throw UnreadableVideo(
        path + ": is not a video, or is damaged" +
        (has_index ? " (a recording that was cut off lacks its index; a repair tool may restore it)" : ""));
  }

  // Whether the file is a stream without a container. The library's readers of such have an option for the rate.
  bool IsBare() const {
    const AVClass* options = input->iformat->priv_class;
    return options != nullptr &&
           ffmpeg::av_opt_find(&options, "framerate", nullptr, 0, AV_OPT_SEARCH_FAKE_OBJ) != nullptr;
  }

  // The rate in the coded stream, which the decoder knows when it has decoded a frame; 0 if there is none.
  double CodecRate() {
    ahead = Advance();
    return decoder->framerate.num > 0 && decoder->framerate.den > 0 ? av_q2d(decoder->framerate) : 0.0;
  }

  // As the container says; 0 if it does not. Cutters that do not encode anew leave the frames from the key frame to the
  // cut in an MP4, and hide them by an edit list. The library's index of the file leaves them out or marks them.
  int64_t CountedFrames() const {
    const int entries = ffmpeg::avformat_index_get_entries_count(stream);
    const bool is_mp4 = std::string_view(input->iformat->name).find("mp4") != std::string_view::npos;
    if (!is_mp4 || stream->nb_frames <= 0 || entries <= 0) return stream->nb_frames;
    int64_t count = 0;
    for (int i = 0; i < entries; ++i)
      if ((ffmpeg::avformat_index_get_entry(stream, i)->flags & AVINDEX_DISCARD_FRAME) == 0) ++count;
    return count;
  }

  void ReadHeader() {
    const AVCodecParameters& codec = *stream->codecpar;
    header.size = {codec.width, codec.height};
    header.pixel_aspect = PixelAspect(*input, *stream);
    if (orientation.transpose) {
      std::swap(header.size.width, header.size.height);
      header.pixel_aspect = 1 / header.pixel_aspect;
    }
    header.read_direction = ReadDirectionAfter([&](const cv::Mat& stored) { return Oriented(stored.clone()); });
    header.tick = Seconds(stream->time_base);
    // Containers without a rate have zero, or their clock's ticks.
    for (const AVRational& rate : {stream->avg_frame_rate, stream->r_frame_rate}) {
      const double fps = rate.den > 0 ? av_q2d(rate) : 0.0;
      if (header.rate <= 0 && std::isfinite(fps) && fps > 0 && fps <= 1000) header.rate = fps;
    }
    if (IsBare()) header.rate = CodecRate();
    if (stream->duration > 0 && stream->duration != AV_NOPTS_VALUE) {
      header.duration = static_cast<double>(stream->duration) * header.tick;
    } else if (input->duration > 0 && input->duration != AV_NOPTS_VALUE) {
      header.duration = static_cast<double>(input->duration) / AV_TIME_BASE;
    }
    // From file size and bit rate, which is no measure of a video.
    if (input->duration_estimation_method == AVFMT_DURATION_FROM_BITRATE) header.duration = 0;
    if (stream->start_time != AV_NOPTS_VALUE) header.begin = InSeconds(stream->start_time);
    const int64_t count = CountedFrames();
    header.counted = count > 0 && count < std::numeric_limits<int>::max();
    const double estimate = std::round(header.duration * header.rate);
    if (header.counted) {
      header.frames = static_cast<int>(count);
    } else if (estimate < std::numeric_limits<int>::max()) {
      header.frames = static_cast<int>(estimate);
    }
    header.created = CreationTime(*input, *stream);
  }

  // The next packet of the stream is in `packet`; false at the end.
  bool ReadPacket() {
    ffmpeg::av_packet_unref(packet.get());
    while (ffmpeg::av_read_frame(input.get(), packet.get()) >= 0) {
      if (packet->stream_index == stream->index) return true;
      ffmpeg::av_packet_unref(packet.get());
    }
    return false;
  }

  double InSeconds(int64_t stamp) const {
    // One rounding, so that a constant rate gives the same numbers as index / rate.
    return static_cast<double>(stamp) * stream->time_base.num / stream->time_base.den;
  }

  // Passes the next packet to the decoder, at the end the sign that there is none.
  void Feed() {
    while (ReadPacket()) {
      if (start && (packet->pts == AV_NOPTS_VALUE || InSeconds(packet->pts) != *start)) continue;
      start.reset();
      // A damaged packet yields no frame.
      ffmpeg::avcodec_send_packet(decoder.get(), packet.get());
      return;
    }
    ffmpeg::avcodec_send_packet(decoder.get(), nullptr);
  }

  std::vector<FrameStamp> ReadStamps() {
    if (IsBare()) return {};
    std::vector<FrameStamp> stamps;
    int64_t latest = AV_NOPTS_VALUE;
    while (ReadPacket()) {
      // Stamps that start anew within the file are not in order.
      if (packet->dts != AV_NOPTS_VALUE && latest != AV_NOPTS_VALUE && packet->dts <= latest) return {};
      latest = packet->dts;
      if ((packet->flags & AV_PKT_FLAG_DISCARD) != 0) continue;
      const bool key = (packet->flags & AV_PKT_FLAG_KEY) != 0;
      // A file that does not begin with a key frame has frames that are not decoded.
      if (packet->pts == AV_NOPTS_VALUE || (stamps.empty() && !key)) return {};
      stamps.push_back({InSeconds(packet->pts), key});
      if (stamps.back().seconds < stamps.front().seconds) return {};
    }
    const auto by_time = [](const FrameStamp& a, const FrameStamp& b) { return a.seconds < b.seconds; };
    std::sort(stamps.begin(), stamps.end(), by_time);
    const auto repeats = [](const FrameStamp& a, const FrameStamp& b) { return a.seconds == b.seconds; };
    if (std::adjacent_find(stamps.begin(), stamps.end(), repeats) != stamps.end()) return {};
    return stamps;
  }

  bool Advance() {
    if (std::exchange(ahead, false)) return true;
    for (;;) {
      const int result = ffmpeg::avcodec_receive_frame(decoder.get(), frame.get());
      if (result == AVERROR(ENOMEM)) throw std::bad_alloc();
      if (result == AVERROR_EOF) return false;
      // Frames that are decoded after the first key frame, but shown before it, refer to earlier ones.
      if (result == 0 &&
          (frame->best_effort_timestamp == AV_NOPTS_VALUE || InSeconds(frame->best_effort_timestamp) >= first_stamp)) {
        break;
      }
      if (result == 0) continue;
      Feed();
    }
    if (frame->interlaced_frame != 0) RefuseInterlaced(path);
    return true;
  }

  // The ranges have to be known when the converter is made: it chooses its functions by them.
  Converter MakeConverter(const cv::Size& size) const {
    Converter made(ffmpeg::sws_alloc_context());
    if (!made) throw std::bad_alloc();
    const std::pair<const char*, int> options[] = {{"srcw", size.width},
                                                   {"srch", size.height},
                                                   {"src_format", frame->format},
                                                   {"src_range", frame->color_range == AVCOL_RANGE_JPEG ? 1 : 0},
                                                   {"dstw", size.width},
                                                   {"dsth", size.height},
                                                   {"dst_format", AV_PIX_FMT_GRAY8},
                                                   {"dst_range", 1},
                                                   {"sws_flags", SWS_POINT | SWS_ACCURATE_RND | SWS_BITEXACT}};
    for (const auto& [name, value] : options) ffmpeg::av_opt_set_int(made.get(), name, value, 0);
    if (ffmpeg::sws_init_context(made.get(), nullptr, nullptr) < 0)
      throw InputError(path + ": its colours cannot be converted; convert it with ffmpeg -i IN -pix_fmt yuv420p OUT");
    return made;
  }

  static cv::Mat Convert(SwsContext* context, const AVFrame& image) {
    cv::Mat gray(image.height, image.width, CV_8UC1);
    uint8_t* const rows[] = {gray.data};
    const int strides[] = {static_cast<int>(gray.step)};
    ffmpeg::sws_scale(context, image.data, image.linesize, 0, image.height, rows, strides);
    return gray;
  }

  // Whether the gray levels are a plane of bytes, which the converter only has to stretch.
  bool HasPlaneOfBytes() const {
    const AVPixFmtDescriptor* format = ffmpeg::av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame->format));
    constexpr uint64_t kOther = AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BITSTREAM |
                                AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_BAYER;
    return format != nullptr && (format->flags & kOther) == 0 && format->comp[0].plane == 0 &&
           format->comp[0].step == 1 && format->comp[0].depth == 8;
  }

  // What the converter makes of each gray level. Looking levels up is faster.
  std::array<uint8_t, kLevels> LevelTable() const {
    // Rows for two of the coarsest chroma.
    constexpr int kRows = 8;
    const FramePointer levels(Allocated(ffmpeg::av_frame_alloc()));
    levels->format = frame->format;
    levels->width = kLevels;
    levels->height = kRows;
    if (ffmpeg::av_frame_get_buffer(levels.get(), 0) < 0) throw std::bad_alloc();
    for (const AVBufferRef* plane : levels->buf)
      if (plane != nullptr) std::fill_n(plane->data, plane->size, uint8_t{128});
    for (int row = 0; row < kRows; ++row)
      std::iota(levels->data[0] + row * levels->linesize[0], levels->data[0] + row * levels->linesize[0] + kLevels, 0);
    const cv::Mat gray = Convert(MakeConverter({kLevels, kRows}).get(), *levels);
    std::array<uint8_t, kLevels> converted_levels;
    std::copy_n(gray.ptr<uint8_t>(0), kLevels, converted_levels.begin());
    return converted_levels;
  }

  cv::Mat Gray() {
    const std::array<int, 4> kind = {frame->width, frame->height, frame->format, frame->color_range};
    if (kind != converted) {
      converter.reset();
      table.reset();
      if (HasPlaneOfBytes())
        table = LevelTable();
      else
        converter = MakeConverter({frame->width, frame->height});
      levels_stay = table && IsIdentity(*table);
      converted = kind;
    }
    if (!table) return Oriented(Convert(converter.get(), *frame));
    cv::Mat gray(frame->height, frame->width, CV_8UC1);
    for (int row = 0; row < gray.rows; ++row) {
      const uint8_t* stored = frame->data[0] + static_cast<std::ptrdiff_t>(row) * frame->linesize[0];
      if (levels_stay)
        std::copy_n(stored, gray.cols, gray.ptr<uint8_t>(row));
      else
        std::transform(stored, stored + gray.cols, gray.ptr<uint8_t>(row),
                       [&](uint8_t level) { return (*table)[level]; });
    }
    return Oriented(gray);
  }

  cv::Mat Oriented(cv::Mat image) const {
    if (orientation.transpose) image = image.t();
    if (orientation.flip_x && orientation.flip_y) {
      cv::flip(image, image, -1);
    } else if (orientation.flip_x || orientation.flip_y) {
      cv::flip(image, image, orientation.flip_x ? 1 : 0);
    }
    return image;
  }

  // The display matrix maps (x, y) to (a x + c y, b x + d y). Only quarter turns and reflections occur in practice.
  static Orientation OrientationOf(const AVStream& stream) {
    const uint8_t* data = ffmpeg::av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
    if (data == nullptr) return {};
    const auto* matrix = reinterpret_cast<const int32_t*>(data);
    const int32_t a = matrix[0];
    const int32_t b = matrix[1];
    const int32_t c = matrix[3];
    const int32_t d = matrix[4];
    if (std::llabs(a) >= std::llabs(b)) return {false, a < 0, d < 0};
    return {true, c < 0, b < 0};
  }

  std::string path;
  std::unique_ptr<AVFormatContext, CloseInput> input;
  CodecPointer decoder;
  PacketPointer packet;
  FramePointer frame;
  Converter converter;
  std::optional<std::array<uint8_t, kLevels>> table;  // stands for the converter where it can
  bool levels_stay = false;                           // whether the table changes none
  std::array<int, 4> converted{};                     // width, height, format and range that these are for
  AVStream* stream = nullptr;
  Orientation orientation;
  VideoHeader header;
  bool ahead = false;           // `frame` has not been given yet
  std::optional<double> start;  // stamp of the packet to begin at
  double first_stamp = -std::numeric_limits<double>::infinity();
};

VideoFile::VideoFile(const std::filesystem::path& path) : state_(std::make_unique<State>(path)) {}

VideoFile::~VideoFile() = default;

const VideoHeader& VideoFile::header() const { return state_->header; }

void VideoFile::StartAt(double stamp) {
  state_->start = stamp;
  state_->first_stamp = stamp;
}

bool VideoFile::Advance() { return state_->Advance(); }

std::optional<double> VideoFile::Stamp() const {
  const int64_t stamp = state_->frame->best_effort_timestamp;
  // Stamps of a stream without a container are guessed from the library's default rate.
  if (stamp == AV_NOPTS_VALUE || state_->IsBare()) return std::nullopt;
  return state_->InSeconds(stamp);
}

cv::Mat VideoFile::Gray() { return state_->Gray(); }

std::vector<FrameStamp> VideoFile::ReadStamps(const std::filesystem::path& path) { return State(path).ReadStamps(); }

int CountVideoFrames(const std::filesystem::path& path) {
  VideoFile video(path);
  int count = 0;
  while (video.Advance()) ++count;
  return count;
}

}  // namespace turnscale
