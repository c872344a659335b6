// SPDX-License-Identifier: MIT
#include "turnscale/io/impossible_motion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

namespace turnscale {
namespace {

// Speeds are means over so many seconds, at most twice as many where images are missing.
constexpr double kWindow = 0.5;
// More than tyres can transmit, m/s^2.
constexpr double kMostAcceleration = 15;
// Noise of a speed: share of it.
constexpr double kSpeedNoise = 0.1;
// A slower car stands, m/s.
constexpr double kStanding = 0.2;
constexpr double kLongestBetween = 15;  // s, of two changes of speed around one part

struct Window {
  double from = 0;
  double to = 0;
  double distance = 0;  // m, along a straight line
  double begin = 0;     // m, of the path before it

  double middle() const { return 0.5 * (from + to); }
  double speed() const { return distance / (to - from); }
};

// And the length of the whole path.
std::pair<std::vector<Window>, double> Windows(const std::vector<FrameResult>& frames) {
  std::vector<Window> windows;
  double length = 0;
  double length_at_first = 0;
  const FrameResult* first = nullptr;  // of the window
  const FrameResult* last = nullptr;
  for (const FrameResult& frame : frames) {
    if (frame.state != TrackingState::kTracked || !frame.world_from_camera) continue;
    if (last) length += (frame.world_from_camera->translation - last->world_from_camera->translation).norm();
    last = &frame;
    if (first && frame.time - first->time < kWindow) continue;
    if (first && frame.time - first->time < 2 * kWindow)
      windows.push_back({first->time, frame.time,
                         (frame.world_from_camera->translation - first->world_from_camera->translation).norm(),
                         length_at_first});
    first = &frame;
    length_at_first = length;
  }
  return {std::move(windows), length};
}

bool IsImpossible(const Window& before, const Window& after) {
  const auto [slower, faster] = std::minmax(before.speed(), after.speed());
  return slower > kStanding &&
         (1 - kSpeedNoise) * faster - slower > kMostAcceleration * (after.middle() - before.middle());
}

}  // namespace

std::vector<ImpossibleMotion> FindImpossibleMotion(const std::vector<FrameResult>& frames) {
  std::vector<ImpossibleMotion> parts;
  if (frames.empty() || frames.back().scale_state == ScaleState::kPending) return parts;
  const auto [windows, length] = Windows(frames);
  const size_t count = windows.size();
  for (size_t i = 1; i < count; ++i) {
    if (!IsImpossible(windows[i - 1], windows[i])) continue;
    const size_t first = i;
    size_t last = i;
    for (size_t k = i + 1; k < count && windows[k].from - windows[last].from < kLongestBetween; ++k)
      if (IsImpossible(windows[k - 1], windows[k])) last = k;
    i = last;
    const Window& before = windows[first - 1];
    const Window& after = windows[last];
    // The windows beside the change may contain it.
    const double speed_before = windows[first > 1 ? first - 2 : 0].speed();
    const double speed_after = windows[std::min(last + 1, count - 1)].speed();
    if (last > first) {
      const double speed = 0.5 * (speed_before + speed_after);
      parts.push_back({before.to, after.from, after.begin - windows[first].begin, speed * (after.from - before.to)});
    } else if (after.begin < length - after.begin) {
      parts.push_back({windows.front().from, after.from, after.begin, after.begin * speed_after / speed_before});
    } else {
      const double rest = length - after.begin;
      parts.push_back({after.from, windows.back().to, rest, rest * speed_before / speed_after});
    }
  }
  return parts;
}

std::string ImpossibleMotionText(const std::vector<ImpossibleMotion>& parts) {
  if (parts.empty()) return {};
  const auto largest = std::ranges::max_element(
      parts, {}, [](const ImpossibleMotion& part) { return std::abs(part.distance - part.expected); });
  return fmt::format(
      "the speed changes by more than a car's can{}: the path from {:.1f} to {:.1f} s, of {:.0f} m, is wrong (about "
      "{:.0f} m by the speed before and after); something that moved may have filled the image",
      parts.size() > 1 ? fmt::format(" in {} parts of the drive, mostly", parts.size()) : "", largest->from,
      largest->to, largest->distance, largest->expected);
}

double LengthErrorOf(const std::vector<ImpossibleMotion>& parts) {
  double sum = 0;
  for (const ImpossibleMotion& part : parts) sum += std::abs(part.distance - part.expected);
  return sum;
}

}  // namespace turnscale
