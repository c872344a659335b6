// SPDX-License-Identifier: MIT
#include "turnscale/commands/rescale_page.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "turnscale/commands/rescale_report.h"
#include "turnscale/commands/version.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/drive_speed.h"
#include "turnscale/report/report_data.h"
#include "turnscale/report/report_page.h"

namespace turnscale {
namespace {

TurnResult TurnOfPage(const TurnEstimate& turn, const RescaleResult& result) {
  TurnResult shown;
  shown.first_frame = result.steps[turn.first_step].first;
  shown.last_frame = result.steps[turn.last_step].last;
  shown.angle = turn.angle;
  shown.metres_per_unit = turn.own;
  shown.sigma = turn.own * turn.own_sigma;
  shown.smoothed = turn.smoothed;
  shown.smoothed_sigma = turn.smoothed * turn.smoothed_sigma;
  shown.effective_lever_arm = turn.lever_arm_units * turn.smoothed;
  shown.deviation = turn.deviation;
  shown.used = turn.used;
  shown.reason = turn.reason;
  return shown;
}

}  // namespace

std::string RescalePage(const RescaleResult& result, const std::string& input, double lever_arm, bool timed) {
  ReportData data;
  data.title = input;
  data.version = Version();
  data.metric = true;
  data.notes = {fmt::format("Lever arm {:g} m", lever_arm), "Scale estimated from the turns of the trajectory"};
  if (const std::string warning = RescaleWarning(result); !warning.empty()) data.warnings.push_back(warning);
  if (!timed) data.warnings.push_back("The trajectory has no times: tyre slip is neglected, and there is no speed");
  data.timed = timed;
  data.has_tracking = false;
  data.vehicle_from_body = result.vehicle_from_camera;
  for (const TurnEstimate& turn : result.estimate->turns) data.turns.push_back(TurnOfPage(turn, result));
  for (size_t i = 0; i < result.metric.size(); ++i) {
    const int pose = static_cast<int>(i);
    FrameResult frame;
    frame.frame = pose;
    frame.state = TrackingState::kTracked;
    frame.time = result.metric[i].time;
    frame.world_from_camera = result.metric[i].world_from_camera;
    frame.vehicle_from_camera = result.vehicle_from_camera;
    frame.scale_sigma = result.poses[i].sigma;
    const bool in_turn = std::any_of(data.turns.begin(), data.turns.end(), [&](const TurnResult& turn) {
      return turn.used && pose >= turn.first_frame && pose <= turn.last_frame;
    });
    frame.scale_state = in_turn ? ScaleState::kObserved : ScaleState::kHeld;
    data.frames.push_back(frame);
    data.scale.push_back({pose, frame.time, result.poses[i].metres_per_unit, result.poses[i].sigma});
  }
  if (timed) data.speeds = SpeedsOf(data.frames, lever_arm);
  const auto used = std::count_if(data.turns.begin(), data.turns.end(), [](const auto& turn) { return turn.used; });
  data.facts = {{"Path length", fmt::format("{:.1f} m", result.length),
                 fmt::format("\u00b1{:.1f} % (1 sigma)", 100 * result.estimate->length_sigma)},
                {"Poses", fmt::format("{}", result.metric.size()), ""},
                {"Turns", fmt::format("{} of {}", used, data.turns.size()), "used for the scale"}};
  return ReportPage(std::filesystem::path(input).filename().string(), ReportJson(data));
}

}  // namespace turnscale
