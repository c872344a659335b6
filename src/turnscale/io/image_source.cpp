// SPDX-License-Identifier: MIT
#include "turnscale/io/image_source.h"

#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/io/clip_reader.h"
#include "turnscale/io/drive_input.h"
#include "turnscale/io/frame_reader.h"
#include "turnscale/io/video_file.h"

namespace turnscale {
namespace {

// Enough to hide a slow file, few enough to cost little memory.
constexpr size_t kFramesAhead = 4;

void CheckRate(const std::optional<double>& fps) {
  if (!fps || (std::isfinite(*fps) && *fps > 0)) return;
  throw InputError(fmt::format("--fps {}: give the frames per second, a number above 0", *fps));
}

// The file of the times to use. Explicit wishes go before what lies beside the images.
std::optional<std::filesystem::path> TimesFile(const DriveInput& drive, const ImageSourceOptions& options) {
  if (options.timestamps || options.fps) return options.timestamps;
  return drive.times_file;
}

[[noreturn]] void RefuseWithoutTimes(const DriveInput& drive) {
  throw InputError(
      fmt::format("{}: the times of the frames are missing; give --timestamps FILE or --fps X", drive.path.string()));
}

// Videos that hold exactly `count` frames by their headers are believed; else they are counted.
int CheckedCount(const DriveInput& drive, int count, size_t times) {
  if (drive.videos.empty() || static_cast<size_t>(count) == times) return count;
  count = 0;
  for (const auto& video : drive.videos) count += CountVideoFrames(video);
  return count;
}

}  // namespace

struct ImageSource::State {
  State(const DriveInput& drive, const ImageSourceOptions& options) : path(drive.path.string()) {
    CheckRate(options.fps);
    const std::optional<std::filesystem::path> times_file = TimesFile(drive, options);
    if (drive.videos.empty()) {
      if (!times_file && !options.fps) RefuseWithoutTimes(drive);
      reader = ReadImages(drive.images);
      count = static_cast<int>(drive.images.size());
    } else {
      ClipOptions clip_options;
      clip_options.timed = !times_file;
      clip_options.fps = options.fps;
      auto clips_reader = std::make_unique<ClipReader>(drive.videos, clip_options);
      if (!times_file && !clips_reader->HasTimes()) RefuseWithoutTimes(drive);
      count = clips_reader->count();
      reader = std::move(clips_reader);
    }
    if (times_file) {
      FrameTimes times = ReadFrameTimes(*times_file);
      count = CheckedCount(drive, count, times.times.size());
      CheckTimesMatch(times, *times_file, static_cast<size_t>(count), path);
      clock.times = std::move(times.times);
    }
    clock.fps = options.fps.value_or(0);
    size = {options.width, options.height};
    size_from = options.camera_file;
    for (const auto& video : drive.videos) clip_files.push_back(video.string());
    thread = std::jthread([this](std::stop_token stop) { Prefetch(stop); });
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
        image = reader->Read();
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

  std::optional<DriveImage> Take() {
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
    throw InputError(fmt::format("{}: is {}x{} pixels, but {} says {}x{}; all frames need the camera's size", name,
                                 image.cols, image.rows, size_from, size.width, size.height));
  }

  void CountIn(const DriveImage& image, double time) {
    if (clip_files.empty()) return;
    const bool is_first = clips.empty();
    if (is_first || image.clip != clip) {
      clips.push_back({clip_files[image.clip], time, time, 0, image.gap});
      clip = image.clip;
    }
    clips.back().end = time;
    ++clips.back().frames;
  }

  std::string path;
  std::unique_ptr<FrameReader> reader;
  FrameClock clock;
  int count = 0;
  cv::Size size;
  std::string size_from;
  int next = 0;
  int readable = 0;
  bool ended = false;  // the reader is, and the thread no longer uses it
  std::vector<std::string> clip_files;
  std::vector<ClipPart> clips;
  int clip = 0;  // of the latest image

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

std::optional<SourceFrame> ImageSource::Next() {
  std::optional<DriveImage> image = state_->Take();
  const auto index = static_cast<size_t>(state_->next);
  if (!image || (!state_->clock.times.empty() && index == state_->clock.times.size())) {
    if (state_->readable == 0) {
      throw InputError(
          fmt::format("{}: not one of {} frames could be read; check the files", state_->path, state_->next));
    }
    return std::nullopt;
  }
  const double time = image->time ? *image->time : state_->clock.At(index);
  if (!image->image.gray.empty()) {
    state_->CheckSize(image->image.gray, image->name);
    ++state_->readable;
  }
  state_->CountIn(*image, time);
  return SourceFrame{state_->next++, time, std::move(image->image.gray), std::move(image->image.problem),
                     std::move(image->notice)};
}

int ImageSource::count() const { return state_->count; }

std::string ImageSource::EndsEarly() const { return state_->ended ? state_->reader->EndsEarly() : std::string(); }

const std::vector<ClipPart>& ImageSource::clips() const { return state_->clips; }

}  // namespace turnscale
