// SPDX-License-Identifier: MIT
#include "turnscale/io/time_check.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

// A step over a missing image is twice as long as those beside it; over two, three times.
constexpr double kLeastGrowth = 1.6;
constexpr double kMostGrowth = 4;
// Steps of a slow car are too short to compare, m/s^2.
constexpr double kLeastJump = 15;
constexpr int kLeastSkips = 3;
constexpr double kLeastShare = 0.01;
// Nobody drives through a whole turn like this, m/s^2.
constexpr double kMostSideways = 8;

struct ImageStep {
  double time = 0;     // of the image that it leads to
  double seconds = 0;  // since the image before
  double speed = 0;    // m/s
};

// Between tracked images that follow one another in the drive; a gap of other images ends a row of steps.
std::vector<std::vector<ImageStep>> RowsOfSteps(const std::vector<FrameResult>& frames) {
  std::vector<std::vector<ImageStep>> rows(1);
  const FrameResult* last = nullptr;
  for (const FrameResult& frame : frames) {
    const bool is_measured = frame.state == TrackingState::kTracked && frame.world_from_camera;
    if (is_measured && last) {
      const double seconds = frame.time - last->time;
      const double distance = (frame.world_from_camera->translation - last->world_from_camera->translation).norm();
      rows.back().push_back({frame.time, seconds, distance / seconds});
    } else if (!rows.back().empty()) {
      rows.emplace_back();
    }
    last = is_measured ? &frame : nullptr;
  }
  return rows;
}

std::optional<std::string> SkippedImages(const std::vector<FrameResult>& frames) {
  int steps = 0;
  std::vector<double> skips;  // times
  for (const std::vector<ImageStep>& row : RowsOfSteps(frames)) {
    steps += static_cast<int>(row.size());
    for (size_t i = 1; i + 1 < row.size(); ++i) {
      const auto [slower, faster] = std::minmax(row[i - 1].speed, row[i + 1].speed);
      const double speed = row[i].speed;
      if (speed > kLeastGrowth * faster && speed < kMostGrowth * slower &&
          (speed - faster) / row[i].seconds > kLeastJump)
        skips.push_back(row[i].time);
    }
  }
  const int count = static_cast<int>(skips.size());
  if (count < kLeastSkips || count < kLeastShare * steps) return std::nullopt;
  return fmt::format(
      "images seem to be missing at {} places at least (the first at {:.1f} s), where the car moves about twice as far "
      "from one image to the next as before and after: speeds are wrong, and the scale may be; give the true times of "
      "the images (--timestamps)",
      count, skips.front());
}

double TimeOf(const std::vector<FrameResult>& frames, int number) {
  const auto found = std::ranges::lower_bound(frames, number, {}, &FrameResult::frame);
  return found == frames.end() ? frames.back().time : found->time;
}

std::optional<std::string> FastTurns(const std::vector<FrameResult>& frames, const std::vector<TurnResult>& turns) {
  std::vector<double> sideways;
  for (const TurnResult& turn : turns) {
    const double seconds = TimeOf(frames, turn.last_frame) - TimeOf(frames, turn.first_frame);
    if (turn.used && seconds > 0) sideways.push_back(turn.speed * std::abs(turn.angle) / seconds);
  }
  if (sideways.empty()) return std::nullopt;
  const double median = Median(std::move(sideways));
  if (!(median > kMostSideways)) return std::nullopt;
  return fmt::format(
      "the car would take its turns at {:.0f} m/s^2 sideways, which no road car does: speeds are wrong, and the scale "
      "may be; check the times of the images (--fps, --timestamps)",
      median);
}

}  // namespace

std::vector<std::string> TimeWarnings(const std::vector<FrameResult>& frames, const std::vector<TurnResult>& turns) {
  std::vector<std::string> warnings;
  if (frames.empty() || frames.back().scale_state == ScaleState::kPending) return warnings;
  if (std::optional<std::string> skipped = SkippedImages(frames)) warnings.push_back(std::move(*skipped));
  if (std::optional<std::string> fast = FastTurns(frames, turns)) warnings.push_back(std::move(*fast));
  return warnings;
}

}  // namespace turnscale
