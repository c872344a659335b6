// SPDX-License-Identifier: MIT
#include "turnscale/run/impossible_motion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

// Speeds are means over so many seconds, at most twice as many where images are missing.
constexpr double kWindow = 0.5;
// More than tyres can transmit, m/s^2.
constexpr double kMostAcceleration = 15;
// More than a car drives on a public road, m/s.
constexpr double kMostSpeed = 90;
// Errors of a speed, by poses and time stamps: share of it.
constexpr double kSpeedNoise = 0.25;
// A step is longer than those before and after it by more than this factor where images are missing or repeated.
constexpr double kLongStep = 3;
// Gaps in the images across which tracking went on, seconds. In a longer one, a car may have done anything.
constexpr double kShortestGap = 1;
constexpr double kLongestGap = 5;
// Firm braking, and as firm acceleration right after it, m/s^2: rarely what happens in a gap.
constexpr double kFirm = 5;
// A slower car stands, m/s.
constexpr double kStanding = 0.2;

struct SpeedWindow {
  double from = 0;
  double to = 0;
  double distance = 0;  // m, along a straight line

  double speed() const { return distance / (to - from); }
};

// Windows that follow one another, without an impossible change of speed, all of them at a car's speed or none.
struct Stretch {
  std::vector<SpeedWindow> windows;
  bool follows = false;  // there is no gap between it and the stretch before
  bool is_wrong = false;

  double seconds() const { return windows.back().to - windows.front().from; }
  // Beside its ends: the window at the end may contain the change.
  double first_speed() const { return windows[windows.size() > 1 ? 1 : 0].speed(); }
  double last_speed() const { return windows[windows.size() - (windows.size() > 1 ? 2 : 1)].speed(); }
};

// A window that cannot be judged is left out.
std::vector<SpeedWindow> Windows(const std::vector<FrameResult>& frames) {
  std::vector<const FrameResult*> measured;
  for (const FrameResult& frame : frames)
    if (frame.is_measured()) measured.push_back(&frame);
  const auto step = [&](size_t i) { return DistanceBetween(*measured[i - 1], *measured[i]); };
  const auto is_long = [&](size_t i) {
    return i > 1 && i + 1 < measured.size() && step(i) > kLongStep * std::max(step(i - 1), step(i + 1));
  };
  std::vector<SpeedWindow> windows;
  size_t first = 0;
  bool has_long_step = false;
  for (size_t i = 1; i < measured.size(); ++i) {
    has_long_step = has_long_step || is_long(i);
    const double seconds = measured[i]->time - measured[first]->time;
    if (seconds < kWindow) continue;
    const double distance = DistanceBetween(*measured[first], *measured[i]);
    if (seconds < 2 * kWindow && !has_long_step && distance > kStanding * seconds)
      windows.push_back({measured[first]->time, measured[i]->time, distance});
    first = i;
    has_long_step = false;
  }
  return windows;
}

bool IsImpossible(const SpeedWindow& before, const SpeedWindow& after) {
  const auto [slower, faster] = std::minmax({before.speed(), after.speed()});
  const double seconds = 0.5 * (after.from + after.to - before.from - before.to);
  return (1 - kSpeedNoise) * faster - slower > kMostAcceleration * seconds;
}

bool IsTooFast(const SpeedWindow& window) { return window.speed() > kMostSpeed; }

// Median speed at which a car can drive; 0 if there is none.
double MedianCarSpeed(const std::vector<SpeedWindow>& windows) {
  std::vector<double> speeds;
  for (const SpeedWindow& window : windows)
    if (!IsTooFast(window)) speeds.push_back(window.speed());
  return speeds.empty() ? 0.0 : Median(std::move(speeds));
}

std::vector<Stretch> Stretches(const std::vector<SpeedWindow>& windows) {
  std::vector<Stretch> stretches;
  for (size_t i = 0; i < windows.size(); ++i) {
    const bool continues = i > 0 && windows[i].from == windows[i - 1].to;
    const bool changes =
        continues && (IsTooFast(windows[i]) != IsTooFast(windows[i - 1]) || IsImpossible(windows[i - 1], windows[i]));
    if (!continues || changes) stretches.push_back({{}, changes, IsTooFast(windows[i])});
    stretches.back().windows.push_back(windows[i]);
  }
  for (size_t i = 1; i < stretches.size(); ++i) {
    Stretch& before = stretches[i - 1];
    Stretch& after = stretches[i];
    const bool decided = IsTooFast(before.windows.back()) || IsTooFast(after.windows.front());
    if (after.follows && !decided) (after.seconds() < before.seconds() ? after : before).is_wrong = true;
  }
  return stretches;
}

// Stretches that are wrong and follow one another, up to `end`.
ImpossibleMotion PartOf(const std::vector<Stretch>& stretches, size_t first, size_t end, double usual_speed) {
  ImpossibleMotion part{stretches[first].windows.front().from, stretches[end - 1].windows.back().to};
  for (size_t i = first; i < end; ++i)
    for (const SpeedWindow& window : stretches[i].windows) {
      part.distance += window.distance;
      part.most_speed = std::max(part.most_speed, window.speed());
    }
  std::optional<double> before;
  std::optional<double> after;
  if (stretches[first].follows) before = stretches[first - 1].last_speed();
  if (end < stretches.size() && stretches[end].follows) after = stretches[end].first_speed();
  // There is one, as of all stretches between two others, the longest is right. Beside what is too fast, the speed may
  // have grown gradually.
  const double beside = before && after ? 0.5 * (*before + *after) : before ? *before : after.value_or(0.0);
  part.expected = (part.IsFasterThanACar() ? usual_speed : beside) * (part.to - part.from);
  return part;
}

// Lengths of the way of a car in so many seconds, from one speed to another.
struct PossibleWay {
  double least = 0;
  double most = 0;
};

PossibleWay PossibleWayBetween(double before, double after, double seconds) {
  constexpr double kHarder = 1.5;  // than an even change of the speed
  const double change = after - before;
  const double firm = std::max(kFirm, kHarder * std::abs(change) / seconds);
  const double mean = 0.5 * (before + after) * seconds;
  const double reach = 0.25 * (firm * seconds * seconds - change * change / firm);
  const double lowest_speed = 0.5 * (before + after - firm * seconds);
  const double with_stop = 0.5 * (before * before + after * after) / firm;
  return {lowest_speed < 0 ? with_stop : mean - reach, mean + reach};
}

// Where the path is measured on both sides of a gap and tracking went on across it, in a wrong place: as where all
// parts of a garage look alike.
std::vector<ImpossibleMotion> FindImpossibleGaps(const std::vector<FrameResult>& frames,
                                                 const std::vector<SpeedWindow>& windows) {
  std::vector<ImpossibleMotion> parts;
  size_t next = 0;
  for (size_t i = 1; i < frames.size(); ++i) {
    const FrameResult& first = frames[i - 1];
    const FrameResult& last = frames[i];
    const double seconds = last.time - first.time;
    if (!first.is_measured() || !last.is_measured() || seconds < kShortestGap || seconds > kLongestGap) continue;
    while (next < windows.size() && windows[next].from < last.time) ++next;
    if (next == 0 || next == windows.size()) continue;
    const SpeedWindow& before = windows[next - 1];
    const SpeedWindow& after = windows[next];
    if (before.to > first.time || first.time - before.to > 2 * kWindow || after.from - last.time > 2 * kWindow)
      continue;
    const PossibleWay way = PossibleWayBetween(before.speed(), after.speed(), seconds);
    const double distance = DistanceBetween(first, last);
    // The chord of a curve is shorter than the way.
    const bool is_possible = distance > (1 - kSpeedNoise) * way.least && (1 - kSpeedNoise) * distance < way.most;
    if (is_possible) continue;
    parts.push_back({.from = first.time,
                     .to = last.time,
                     .distance = distance,
                     .most_speed = distance / seconds,
                     .expected = 0.5 * (before.speed() + after.speed()) * seconds});
  }
  return parts;
}

}  // namespace

bool ImpossibleMotion::IsFasterThanACar() const { return most_speed > kMostSpeed; }

std::vector<ImpossibleMotion> FindImpossibleMotion(const std::vector<FrameResult>& frames) {
  if (frames.empty() || frames.back().scale_state == ScaleState::kPending) return {};
  const std::vector<SpeedWindow> windows = Windows(frames);
  const std::vector<Stretch> stretches = Stretches(windows);
  const double usual_speed = MedianCarSpeed(windows);
  std::vector<ImpossibleMotion> parts;
  for (size_t first = 0; first < stretches.size();) {
    if (!stretches[first].is_wrong) {
      ++first;
      continue;
    }
    size_t end = first + 1;
    while (end < stretches.size() && stretches[end].is_wrong && stretches[end].follows) ++end;
    parts.push_back(PartOf(stretches, first, end, usual_speed));
    first = end;
  }
  for (const ImpossibleMotion& gap : FindImpossibleGaps(frames, windows)) parts.push_back(gap);
  std::ranges::sort(parts, {}, &ImpossibleMotion::from);
  return parts;
}

std::string ImpossibleMotionText(const std::vector<ImpossibleMotion>& parts, double first_time) {
  if (parts.empty()) return {};
  const auto largest = std::ranges::max_element(
      parts, {}, [](const ImpossibleMotion& part) { return std::abs(part.distance - part.expected); });
  const bool is_too_fast = largest->IsFasterThanACar();
  const std::string expected = largest->expected > 0
                                   ? fmt::format(", but about {:.0f} m by {}", largest->expected,
                                                 is_too_fast ? "the usual speed" : "the speed before and after")
                                   : "";
  return fmt::format("{} ({}from {:.1f} to {:.1f} s): the path there is {:.0f} m long{}; {}",
                     is_too_fast ? fmt::format("the speed reaches {:.0f} km/h", 3.6 * largest->most_speed)
                                 : "the speed changes faster than a car's can",
                     parts.size() > 1 ? fmt::format("{} places where no car drives so; the worst ", parts.size()) : "",
                     largest->from - first_time, largest->to - first_time, largest->distance, expected,
                     is_too_fast ? "the scale is wrong there, or the times of the images are"
                                 : "a vehicle that moved may have filled the image, or the scene looks alike in "
                                   "different places");
}

double LengthErrorOf(const std::vector<ImpossibleMotion>& parts) {
  double sum = 0;
  for (const ImpossibleMotion& part : parts) sum += std::abs(part.distance - part.expected);
  return sum;
}

}  // namespace turnscale
