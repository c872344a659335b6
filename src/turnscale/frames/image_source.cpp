// SPDX-License-Identifier: MIT
#include "turnscale/frames/image_source.h"

#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <iterator>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/frame_interval.h"
#include "turnscale/frames/bag_frames.h"
#include "turnscale/frames/clip_reader.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/frames/frame_reader.h"
#include "turnscale/frames/image_numbers.h"
#include "turnscale/frames/image_rotation.h"
#include "turnscale/frames/image_scaling.h"
#include "turnscale/frames/recording_time.h"
#include "turnscale/frames/video_file.h"

namespace turnscale {
namespace {

// Enough to hide a slow file, few enough to cost little memory.
constexpr size_t kFramesAhead = 4;

void CheckRate(const std::optional<double>& fps) {
  constexpr double kLeast = 1 / kLongestFrameInterval;
  if (!fps) return;
  if (!(std::isfinite(*fps) && *fps > 0))
    throw InputError(fmt::format("--fps {}: give the frames per second, a number above 0", *fps));
  if (*fps < kLeast)
    throw InputError(
        fmt::format("--fps {}: give the frames per second, not the seconds per frame; at least {}", *fps, kLeast));
  if (*fps > kHighestFrameRate)
    throw InputError(fmt::format("--fps {}: give the frames per second; at most {}", *fps, kHighestFrameRate));
}

// The file of the times to use. Explicit wishes go before what lies beside the images.
std::optional<std::filesystem::path> TimesFile(const DriveInput& drive, const ImageSourceOptions& options) {
  if (options.timestamps || options.fps) return options.timestamps;
  return drive.times_file;
}

[[noreturn]] void RefuseWithoutTimes(const DriveInput& drive) {
  std::error_code none;
  const std::filesystem::path beside = std::filesystem::canonical(drive.path, none).parent_path() / "times.txt";
  throw InputError(fmt::format(
      "{}: the times of the frames are missing; give --timestamps FILE or --fps X{}", drive.path.string(),
      std::filesystem::is_regular_file(beside, none) ? fmt::format(", such as --timestamps {}", beside.string()) : ""));
}

// Videos and bags that hold exactly `count` frames by their headers are believed; else they are counted.
int CheckedCount(const DriveInput& drive, int count, size_t times) {
  if (static_cast<size_t>(count) == times) return count;
  if (drive.bags) return CountBagImages(*drive.bags);
  if (drive.videos.empty()) return count;
  count = 0;
  for (const auto& video : drive.videos) count += CountVideoFrames(video);
  return count;
}

// The notice where the end that was asked for lies in the gap before the first image after it. `time`: of that image.
// Both count from the drive's first frame.
std::string EndsInGap(double end, double time, double gap) {
  const double begin = time - gap;
  const double early = end - begin;
  if (gap <= 0 || early <= kLeastGap) return {};
  return fmt::format("--end lies in a gap of {:.1f} s: the path ends {:.1f} s earlier, at {:.1f} s of the drive", gap,
                     early, begin);
}

}  // namespace

struct ImageSource::State {
  State(const DriveInput& drive, const ImageSourceOptions& options)
      : path(drive.path.string()),
        start(options.start),
        end(options.end),
        leaves_out(start > 0),
        rotate(options.rotate) {
    CheckRate(options.fps);
    CheckRotation(rotate);
    if (end && *end <= start)
      throw InputError(fmt::format("--end {:g} s: has to be after {}", *end,
                                   start > 0 ? fmt::format("--start {:g} s", start) : "the drive's start"));
    times_file = TimesFile(drive, options);
    clock.fps = options.fps.value_or(0);
    if (drive.bags) {
      UseBags(drive);
    } else if (drive.videos.empty()) {
      UseImages(drive);
    } else {
      UseVideos(drive, options.fps);
    }
    size = {options.width, options.height};
    size_from = options.camera_file;
    image_options = options.images;
    thread = std::jthread([this](std::stop_token stop) { Prefetch(stop); });
  }

  void UseImages(const DriveInput& drive) {
    if (!times_file && clock.fps <= 0) RefuseWithoutTimes(drive);
    count = static_cast<int>(drive.images.size());
    const auto numbers = times_file ? std::nullopt : ImageNumbers::Find(drive.images);
    if (times_file) ReadTimes(drive);
    if (numbers) clock.times = numbers->TimesAt(clock.fps);
    const auto [first, last] = FramesOfPart();
    if (numbers) {
      notice = numbers->Notice(drive.images, clock.fps, static_cast<size_t>(first), static_cast<size_t>(last));
    } else if (!times_file) {
      notice = RepeatedNumbersNotice(drive.images);
    }
    if (!notice.empty()) notice = path + ": " + notice;
    reader = ReadImages(drive.images, static_cast<size_t>(first), static_cast<size_t>(last));
    count = last - first;
    offset = first;
  }

  void UseVideos(const DriveInput& drive, const std::optional<double>& fps) {
    const bool in_any_order = drive.several_folders || drive.several_recordings;
    auto clip_reader = std::make_unique<ClipReader>(drive.videos, ClipOptions{!times_file, fps, in_any_order, start});
    if (times_file) {
      count = clip_reader->count();
      ReadTimes(drive);
      const auto [first, last] = FramesOfPart();
      clip_reader->Skip(static_cast<size_t>(first));
      count = last - first;
      offset = first;
    } else {
      if (!clip_reader->HasTimes()) RefuseWithoutTimes(drive);
      count = clip_reader->CountBetween(start, end);
    }
    for (const auto& video : clip_reader->clips()) clip_files.push_back(video.string());
    left_out = clip_reader->left_out();
    begins_late = clip_reader->BeginsLate();
    recorded_from = clip_reader->RecordedFrom();
    notice = clip_reader->NoticeOfTimes();
    pixel_aspect = clip_reader->pixel_aspect();
    if (rotate % 180 != 0) pixel_aspect = 1 / pixel_aspect;
    reader = std::move(clip_reader);
  }

  void UseBags(const DriveInput& drive) {
    const bool timed = !times_file && clock.fps <= 0;
    auto frames = std::make_unique<BagFrames>(*drive.bags, BagFrameOptions{timed, start});
    count = drive.bags->images;
    if (times_file) ReadTimes(drive);
    if (timed) {
      origin = frames->origin();
      // How many are in a part only reading tells.
      if (start > 0 || end) count = 0;
    } else {
      const auto [first, last] = FramesOfPart();
      frames->Skip(static_cast<size_t>(first));
      count = last - first;
      offset = first;
    }
    for (const auto& bag : drive.bags->bags) clip_files.push_back(bag.string());
    reader = std::move(frames);
  }

  void ReadTimes(const DriveInput& drive) {
    FrameTimes times = ReadFrameTimes(*times_file);
    count = CheckedCount(drive, count, times.times.size());
    CheckTimesMatch(times, *times_file, static_cast<size_t>(count), path);
    clock.times = std::move(times.times);
  }

  // Numbers of the first frame of the part and of the first one after it, where the times of all are known.
  std::pair<int, int> FramesOfPart() {
    if (count > 0) origin = clock.At(0);
    const auto since_start = [&](int index) { return clock.At(static_cast<size_t>(index)) - origin; };
    int first = 0;
    while (first < count && since_start(first) < start) ++first;
    int last = first;
    while (last < count && !(end && since_start(last) >= *end)) ++last;
    if (count > 0 && first == last) RefusePart(since_start(count - 1));
    leaves_out = leaves_out || last < count;
    return {first, last};
  }

  [[noreturn]] void RefusePart(double drive_end) const {
    if (start > drive_end)
      throw InputError(
          fmt::format("--start {:g} s: the drive ends at {:.1f} s; give the time since the drive's start{}", start,
                      drive_end, StartByClock(drive_end)));
    if (start > 0 && end)
      throw InputError(fmt::format("--start {:g} s, --end {:g} s: the drive has no frame between them", start, *end));
    throw InputError(end ? fmt::format("--end {:g} s: the drive has no frame before it", *end)
                         : fmt::format("--start {:g} s: the drive has no frame after it", start));
  }

  // What to give where the start is a time of day within the drive, by the names of its videos; empty if it is none.
  std::string StartByClock(double drive_end) const {
    constexpr int kDay = 86400;  // s
    if (!recorded_from || start >= kDay) return {};
    const double begin = std::fmod(*recorded_from, kDay);
    const double since = start < begin ? start + kDay - begin : start - begin;
    if (since > drive_end) return {};
    const auto time_of_day = [](double seconds) { return RecorderTimeText(seconds).substr(std::size("YYYY-MM-DD")); };
    return fmt::format(": --start {:g} for {}, as its first video begins at {} by its name", since, time_of_day(start),
                       time_of_day(begin));
  }

  ~State() {
    thread.request_stop();
    changed.notify_all();
  }

  void Prefetch(const std::stop_token& stop) {
    bool more = true;
    while (more && !stop.stop_requested()) {
      std::optional<DriveImage> image;
      std::exception_ptr thrown;
      try {
        std::optional<DriveImage> read = reader->Read();
        if (read) {
          read->image.gray = Rotated(read->image.gray, rotate);
          read->image.read_direction = Rotated(read->image.read_direction, rotate);
        }
        image = std::move(read);
      } catch (...) {
        thrown = std::current_exception();
      }
      more = image.has_value();
      std::unique_lock lock(mutex);
      if (!changed.wait(lock, stop, [&] { return queue.size() < kFramesAhead; })) return;
      if (image) queue.push_back(std::move(*image));
      failure = thrown;
      finished = !more;
      changed.notify_all();
    }
  }

  // Images up to the first readable one are taken from the queue and kept for Take.
  const GrayImage* FirstReadable() {
    for (size_t i = 0;; ++i) {
      if (i == looked_at.size()) {
        std::optional<DriveImage> image = TakeFromQueue();
        if (!image) return nullptr;
        looked_at.push_back(std::move(*image));
      }
      if (!looked_at[i].image.gray.empty()) return &looked_at[i].image;
    }
  }

  // A video of which not one frame can be decoded is no matter of the part.
  void RefuseEmptyPart() const {
    if (past_end) RefusePart(start);
    if (ended && start > 0 && reader->LatestTime() > 0) RefusePart(reader->LatestTime());
  }

  std::optional<DriveImage> Take() {
    if (looked_at.empty()) return TakeFromQueue();
    DriveImage image = std::move(looked_at.front());
    looked_at.pop_front();
    return image;
  }

  std::optional<DriveImage> TakeFromQueue() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return !queue.empty() || finished; });
    if (queue.empty()) {
      if (failure) std::rethrow_exception(failure);
      ended = true;
      return std::nullopt;
    }
    DriveImage image = std::move(queue.front());
    queue.pop_front();
    changed.notify_all();
    return image;
  }

  void CheckSize(const cv::Mat& image, const std::string& name) {
    if (size.width == 0 || size.height == 0) {
      size = image.size();
      size_from = name;
    }
    if (image.size() == size) return;
    throw InputError(fmt::format(
        "{}: is {}x{} pixels, but {} says {}x{}; {}", name, image.cols, image.rows, size_from, size.width, size.height,
        readable == 0 ? "all images need the calibration's size: give one for this size, or none to have it estimated"
                      : "all images of a drive need the same size"));
  }

  void CountIn(const DriveImage& image, double time) {
    if (clip_files.empty()) return;
    const bool is_first = clips.empty();
    if (is_first || image.clip != clip) {
      clips.push_back({clip_files[image.clip], time, time, 0, image.gap, image.unknown_gap, image.likely_gap});
      clip = image.clip;
    }
    clips.back().end = time;
    ++clips.back().frames;
  }

  std::string path;
  double start;
  std::optional<double> end;
  bool leaves_out;  // images of the drive, as far as is known: its first one is at 0 s
  int rotate;       // degrees
  std::optional<std::filesystem::path> times_file;
  std::unique_ptr<FrameReader> reader;
  FrameClock clock;
  int count = 0;
  double origin = 0;  // time of the drive's first frame
  int offset = 0;     // number in the drive of the first frame that is read
  cv::Size size;
  std::string size_from;  // file of the camera, or of the first image
  ImageOptions image_options;
  double pixel_aspect = 1;
  int next = 0;
  int readable = 0;
  bool past_end = false;
  std::string end_notice;  // where it is past the end
  bool ended = false;      // the reader is, and the thread no longer uses it
  std::vector<std::string> clip_files;
  std::vector<std::string> left_out;
  std::string begins_late;
  std::optional<double> recorded_from;
  std::string lacks;
  std::string notice;
  std::vector<ClipPart> clips;
  int clip = 0;                      // of the latest image
  std::deque<DriveImage> looked_at;  // but not taken

  std::mutex mutex;
  std::condition_variable_any changed;
  std::deque<DriveImage> queue;
  std::exception_ptr failure;
  bool finished = false;
  // Last: it stops before what it uses goes.
  std::jthread thread;
};

ImageSource::ImageSource(const DriveInput& drive, const ImageSourceOptions& options)
    : state_(std::make_unique<State>(drive, options)) {}

ImageSource::~ImageSource() = default;
ImageSource::ImageSource(ImageSource&&) noexcept = default;
ImageSource& ImageSource::operator=(ImageSource&&) noexcept = default;

std::optional<SourceFrame> ImageSource::Next() {
  State& state = *state_;
  if (state.past_end) return std::nullopt;
  std::optional<DriveImage> image = state.Take();
  const auto index = static_cast<size_t>(state.offset + state.next);
  double time = 0;
  if (image) {
    state.past_end = image->time ? state.end && *image->time - state.origin >= *state.end : state.next == state.count;
    state.leaves_out = state.leaves_out || state.past_end;
    if (state.past_end && image->time)
      state.end_notice = EndsInGap(*state.end, *image->time - state.origin, image->gap);
    if (!state.past_end || !state.end_notice.empty()) AddSentence(state.lacks, image->lacks);
    if (!state.past_end) time = image->time ? *image->time : state.clock.At(index);
  }
  if (!image || state.past_end) {
    if (state.next == 0) state.RefuseEmptyPart();
    if (state.readable == 0)
      throw InputError(fmt::format("{}: not one of {} frames could be read; check the files", state.path, state.next));
    return std::nullopt;
  }
  if (!image->image.gray.empty()) {
    state.CheckSize(image->image.gray, image->name);
    image->image.gray = ImageScaling(state.size, state.image_options).Scaled(image->image.gray);
    ++state.readable;
  }
  state.CountIn(*image, time);
  return SourceFrame{state.next++, time, std::move(image->image.gray), std::move(image->image.problem),
                     std::move(image->notice)};
}

std::optional<cv::Size> ImageSource::FullSize() {
  const GrayImage* first = state_->FirstReadable();
  return first != nullptr ? std::optional(first->gray.size()) : std::nullopt;
}

ReadDirection ImageSource::read_direction() {
  const GrayImage* first = state_->FirstReadable();
  return first != nullptr ? first->read_direction : ReadDirection();
}

double ImageSource::pixel_aspect() const { return state_->pixel_aspect; }

int ImageSource::count() const { return state_->count; }

double ImageSource::first_time() const { return state_->origin; }

const std::string& ImageSource::BeginsLate() const { return state_->begins_late; }

const std::optional<double>& ImageSource::RecordedFrom() const { return state_->recorded_from; }

const std::string& ImageSource::Lacks() const { return state_->lacks; }

std::string ImageSource::EndsEarly() const { return state_->ended ? state_->reader->EndsEarly() : std::string(); }

std::string ImageSource::NoticeAtEnd() const {
  return state_->ended ? state_->reader->NoticeAtEnd() : state_->end_notice;
}

bool ImageSource::LeavesOut() const { return state_->leaves_out; }

const std::vector<std::string>& ImageSource::left_out() const { return state_->left_out; }

const std::string& ImageSource::notice() const { return state_->notice; }

const std::vector<ClipPart>& ImageSource::clips() const { return state_->clips; }

}  // namespace turnscale
