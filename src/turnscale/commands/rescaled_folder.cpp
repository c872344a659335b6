// SPDX-License-Identifier: MIT
#include "turnscale/commands/rescaled_folder.h"

#include <system_error>

#include <nlohmann/json.hpp>

#include "turnscale/base/csv_table.h"
#include "turnscale/base/error.h"
#include "turnscale/base/file_text.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

std::vector<FrameResult> FramesIn(const fs::path& folder) {
  const Trajectory poses = ReadTrajectory(folder / kRescaledTum);
  CsvTable scale(folder / RunFiles::kScale, "table of scales");
  const size_t sigma = scale.Column("sigma_relative");
  std::vector<FrameResult> frames;
  for (const StampedPose& pose : poses) {
    FrameResult frame;
    frame.frame = static_cast<int>(frames.size());
    frame.time = pose.time;
    frame.state = TrackingState::kTracked;
    frame.world_from_camera = pose.world_from_camera;
    frame.scale_state = ScaleState::kHeld;
    if (!scale.Next())
      throw InputError((folder / RunFiles::kScale).string() + ": has fewer lines than " + kRescaledTum + " has poses");
    frame.scale_sigma = scale.Value<double>(sigma);
    frames.push_back(frame);
  }
  return frames;
}

std::vector<TurnResult> TurnsIn(const fs::path& folder) {
  CsvTable table(folder / RunFiles::kTurns, "table of turns");
  const size_t first = table.Column("first_pose");
  const size_t last = table.Column("last_pose");
  std::vector<TurnResult> turns;
  while (table.Next()) {
    TurnResult turn;
    turn.first_frame = table.Value<int>(first);
    turn.last_frame = table.Value<int>(last);
    turns.push_back(turn);
  }
  return turns;
}

}  // namespace

bool IsRescaleFolder(const fs::path& folder) {
  std::error_code none;
  return fs::is_regular_file(PartOf(folder / RunFiles::kSummary), none) ||
         SummaryHas(folder, {"metres_per_unit", "sigma_relative"});
}

ResultFolder ReadRescaleFolder(const fs::path& folder) {
  ResultFolder results;
  const fs::path summary = folder / RunFiles::kSummary;
  results.summary = FileText(summary).value_or("");
  const auto json = nlohmann::json::parse(results.summary, nullptr, false);
  std::error_code none;
  if (!json.is_object() || !json.contains("timed") || !fs::exists(folder / kRescaledTum, none))
    throw InputError(summary.string() +
                     ": is of an earlier version of turnscale, or of a rescale that was stopped; rescale again");
  bool timed = false;
  try {
    const auto angle = [&](const char* name) {
      return json.at("camera_rotation").at(name).get<double>() / kDegreesPerRadian;
    };
    timed = json.at("timed").get<bool>();
    results.vehicle_from_body = RotationFromYawPitchRoll({angle("yaw_deg"), angle("pitch_deg"), angle("roll_deg")});
    results.scale_known = json.at("known").get<bool>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(summary.string() + ": is not a summary of a rescale");
  }
  if (!timed) throw InputError(folder.string() + ": the poses have no times; rescale again with --fps or --timestamps");
  results.metric = true;
  results.frames = FramesIn(folder);
  results.turns = TurnsIn(folder);
  return results;
}

}  // namespace turnscale
