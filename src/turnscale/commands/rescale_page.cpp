// SPDX-License-Identifier: MIT
#include "turnscale/commands/rescale_page.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include <fmt/format.h>

#include "turnscale/commands/rescale_report.h"
#include "turnscale/commands/version.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/drive_speed.h"
#include "turnscale/odometry/results.h"
#include "turnscale/odometry/scale_refinement.h"
#include "turnscale/report/report_data.h"
#include "turnscale/report/report_page.h"
#include "turnscale/scale/camera_height.h"

namespace turnscale {
namespace {

std::string ScaleNote(const RescaleResult& result, const CarPrior& car) {
  const bool road =
      std::any_of(result.steps.begin(), result.steps.end(), [](const VehicleStep& step) { return step.height > 0; });
  if (!road) return "Scale estimated from the turns of the trajectory";
  return car.knows_lever_arm() ? "Scale estimated from the turns of the trajectory and the heights above the road"
                               : "Scale estimated from the heights above the road";
}

}  // namespace

std::string RescalePage(const RescaleResult& result, const std::string& input, const CarPrior& car, bool timed,
                        std::optional<double> first_time) {
  ReportData data;
  data.title = input;
  data.version = Version();
  data.metric = true;
  if (car.knows_lever_arm()) data.notes.push_back(fmt::format("Lever arm {:g} m", car.lever_arm));
  if (car.knows_height()) data.notes.push_back(fmt::format("Camera {:g} m above the road", car.camera_height));
  data.notes.push_back(ScaleNote(result, car));
  data.warnings = RescaleWarnings(result, car);
  if (!timed) data.warnings.push_back("The trajectory has no times: side slip is unknown, and there is no speed");
  data.timed = timed;
  data.time_origin = first_time;
  data.has_tracking = false;
  data.vehicle_from_body = result.vehicle_from_camera;
  for (const TurnEstimate& turn : result.estimate->turns)
    data.turns.push_back(TurnResultOf(turn, result.steps, [](int pose) { return pose; }));
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
    frame.scale_state = in_turn                     ? ScaleState::kObserved
                        : result.poses[i].from_road ? ScaleState::kFromRoad
                                                    : ScaleState::kHeld;
    data.frames.push_back(frame);
    data.scale.push_back({pose, frame.time, result.poses[i].metres_per_unit, result.poses[i].sigma});
  }
  if (timed) data.speeds = SpeedsOf(data.frames, car.lever_arm);
  const auto used = std::count_if(data.turns.begin(), data.turns.end(), [](const auto& turn) { return turn.used; });
  const std::string gaps =
      result.gap_length > 0 ? fmt::format("; {:.1f} m more across gaps, not measured", result.gap_length) : "";
  data.facts = {{"Path length", fmt::format("{:.1f} m", result.length),
                 fmt::format("\u00b1{:.1f} % (1 sigma){}", 100 * result.estimate->length_sigma, gaps)},
                {"Poses", fmt::format("{}", result.metric.size()), ""},
                {"Turns", fmt::format("{} of {}", used, data.turns.size()), "used for the scale"}};
  if (const CarRefinement& refined = result.estimate->car;
      !result.estimate->uses_single_turns && refined.camera_height > 0)
    data.facts.push_back({"Camera height", fmt::format("{:.3f} m", refined.camera_height),
                          fmt::format("\u00b1{:.3f} m above the road", HeightSigma(*result.estimate))});
  return ReportPage(std::filesystem::path(input).filename().string(), ReportJson(data));
}

}  // namespace turnscale
