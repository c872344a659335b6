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
#include "turnscale/io/drive_input.h"
#include "turnscale/io/frame_reader.h"

namespace turnscale {
namespace {

// Enough to hide a slow file, few enough to cost little memory.
constexpr size_t kFramesAhead = 4;

// Explicit wishes go before what lies beside the images.
FrameClock FindClock(const DriveInput& drive, const ImageSourceOptions& options, double video_fps, int& count) {
  if (options.fps && !(std::isfinite(*options.fps) && *options.fps > 0)) {
    throw InputError(fmt::format("--fps {}: give the frames per second, a number above 0", *options.fps));
  }
  std::optional<std::filesystem::path> file = options.timestamps;
  if (!file && !options.fps) file = drive.times_file;
  if (file) {
    FrameTimes times = ReadFrameTimes(*file);
    // A video's header may only estimate its length: believe it where it agrees, else count.
    if (drive.is_video && times.times.size() != static_cast<size_t>(count)) count = CountVideoFrames(drive.path);
    CheckTimesMatch(times, *file, static_cast<size_t>(count), drive.path.string());
    return {std::move(times.times), 0};
  }
  const double fps = options.fps.value_or(video_fps);
  if (fps > 0) return {{}, fps};
  throw InputError(
      fmt::format("{}: the times of the frames are missing; give --timestamps FILE or --fps X", drive.path.string()));
}

}  // namespace

struct ImageSource::State {
  State(const DriveInput& drive, const ImageSourceOptions& options) : path(drive.path.string()) {
    double video_fps = 0;
    if (drive.is_video) {
      VideoStream video = OpenVideo(drive.path);
      reader = std::move(video.reader);
      video_fps = video.fps;
      count = video.count;
    } else {
      reader = ReadImages(drive.images);
      count = static_cast<int>(drive.images.size());
    }
    clock = FindClock(drive, options, video_fps, count);
    size = {options.width, options.height};
    size_from = options.camera_file;
    for (const auto& image : drive.images) names.push_back(image.filename().string());
    thread = std::jthread([this](std::stop_token stop) { Prefetch(stop); });
  }

  ~State() {
    thread.request_stop();
    changed.notify_all();
  }

  void Prefetch(const std::stop_token& stop) {
    bool more = true;
    while (more && !stop.stop_requested()) {
      std::optional<GrayImage> image;
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

  std::optional<GrayImage> Take() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return !queue.empty() || finished; });
    if (queue.empty()) {
      if (failure) std::rethrow_exception(failure);
      return std::nullopt;
    }
    GrayImage image = std::move(queue.front());
    queue.pop_front();
    changed.notify_all();
    return image;
  }

  std::string NameOf(size_t index) const {
    return index < names.size() ? fmt::format("{}/{}", path, names[index]) : fmt::format("{}: frame {}", path, index);
  }

  void CheckSize(const cv::Mat& image) {
    if (size.width == 0 || size.height == 0) {
      size = image.size();
      size_from = NameOf(static_cast<size_t>(next));
    }
    if (image.size() == size) return;
    throw InputError(fmt::format("{}: is {}x{} pixels, but {} says {}x{}; all frames need the camera's size",
                                 NameOf(static_cast<size_t>(next)), image.cols, image.rows, size_from, size.width,
                                 size.height));
  }

  std::string path;
  std::vector<std::string> names;
  std::unique_ptr<FrameReader> reader;
  FrameClock clock;
  int count = 0;
  cv::Size size;
  std::string size_from;
  int next = 0;
  int readable = 0;

  std::mutex mutex;
  std::condition_variable_any changed;
  std::deque<GrayImage> queue;
  std::exception_ptr failure;
  bool finished = false;
  // Last: it stops before what it uses goes.
  std::jthread thread;
};

ImageSource::ImageSource(const DriveInput& drive, const ImageSourceOptions& options)
    : state_(std::make_unique<State>(drive, options)) {}

ImageSource::~ImageSource() = default;

std::optional<SourceFrame> ImageSource::Next() {
  std::optional<GrayImage> image = state_->Take();
  const auto index = static_cast<size_t>(state_->next);
  if (!image || (!state_->clock.times.empty() && index == state_->clock.times.size())) {
    if (state_->readable == 0) {
      throw InputError(
          fmt::format("{}: not one of {} frames could be read; check the files", state_->path, state_->next));
    }
    return std::nullopt;
  }
  if (!image->gray.empty()) {
    state_->CheckSize(image->gray);
    ++state_->readable;
  }
  return SourceFrame{state_->next++, state_->clock.At(index), std::move(image->gray), std::move(image->problem)};
}

int ImageSource::count() const { return state_->count; }

}  // namespace turnscale
