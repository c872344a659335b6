// SPDX-License-Identifier: MIT
#include "turnscale/io/run_writer.h"

#include <algorithm>
#include <system_error>

#include "turnscale/base/attempts.h"
#include "turnscale/base/error.h"
#include "turnscale/io/map_file.h"
#include "turnscale/io/run_tables.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr auto kTum = "trajectory.tum";
constexpr auto kKitti = "trajectory.kitti.txt";
constexpr auto kTable = "trajectory.csv";
constexpr auto kLive = "live.tum";
constexpr auto kTurns = "turns.csv";
constexpr auto kMap = "map.ply";
constexpr auto kSummary = "summary.json";
constexpr auto kSettings = "settings.yaml";

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error)) {
    throw InputError(folder.string() + ": is a file, but the results need a folder; choose another --out");
  }
  fs::create_directories(folder, error);
  if (error) throw InputError(folder.string() + ": cannot be made: " + error.message() + "; choose another --out");
}

}  // namespace

RunWriter::RunWriter(const RunWriterOptions& options) : options_(options) {
  if (options_.frame == PoseFrame::kVehicle && !options_.vehicle.lever_arm) {
    throw InputError("--frame vehicle: needs the position of the rear axle; give --lever-arm");
  }
  MakeFolder(options_.folder);
  // The summary first: it says that the others are of one run.
  for (const char* name : {kSummary, kSettings, kTurns, kMap, kTum, kKitti, kTable, kLive}) RemoveOldFile(PathOf(name));
  live_.emplace(PathOf(kLive));
}

void RunWriter::Add(const FrameResult& live) {
  if (live.world_from_camera) live_->Write(TumLine({live.time, Shown(live, live.scale_state)}));
}

void RunWriter::EndLive() { live_->Finish(); }

void RunWriter::WriteTrajectory(const std::vector<FrameResult>& refined, ScaleState scale_state,
                                Durability durability) {
  std::string tum;
  std::string kitti;
  std::string table = FrameTableHeader();
  for (const FrameResult& frame : refined) {
    std::optional<RigidTransform> pose;
    if (frame.world_from_camera) {
      pose = Shown(frame, scale_state);
      tum += TumLine({frame.time, *pose});
      kitti += KittiLine(*pose);
    }
    table += FrameTableLine(frame, pose);
  }
  Attempts attempts;
  attempts.Try([&] { WriteText(kTum, tum, durability); });
  attempts.Try([&] { WriteText(kKitti, kitti, durability); });
  attempts.Try([&] { WriteText(kTable, table, durability); });
  attempts.RethrowFirst();
}

void RunWriter::WriteText(const std::string& name, const std::string& text, Durability durability) {
  try {
    ReplaceFile(PathOf(name), text, durability);
  } catch (const InputError& error) {
    // The user's choice of the folder was good when the run began.
    throw OutputError(error.what());
  }
}

void RunWriter::WriteTurns(const std::vector<TurnResult>& turns, Durability durability) {
  WriteText(kTurns, TurnTable(turns), durability);
}

void RunWriter::WriteMap(const MapPoints& points, ScaleState scale_state, Durability durability) {
  const bool of_camera = options_.frame == PoseFrame::kCamera;
  const RigidTransform shown_from_world =
      of_camera ? RigidTransform{} : VehicleFromCamera(options_.vehicle.vehicle_from_camera, scale_state);
  try {
    turnscale::WriteMap(PathOf(kMap), points, shown_from_world, durability);
  } catch (const InputError& error) {
    throw OutputError(error.what());
  }
}

RigidTransform RunWriter::Shown(const FrameResult& frame, ScaleState scale_state) const {
  if (options_.frame == PoseFrame::kCamera) return *frame.world_from_camera;
  return VehicleFromCamera(options_.vehicle.vehicle_from_camera, scale_state) * *frame.world_from_camera *
         VehicleFromCamera(frame.vehicle_from_camera, scale_state).inverse();
}

RigidTransform RunWriter::VehicleFromCamera(const Eigen::Quaterniond& rotation, ScaleState scale_state) const {
  const double ahead = scale_state == ScaleState::kPending ? 0.0 : options_.vehicle.lever_arm.value_or(0.0);
  return {rotation, {0, 0, ahead}};
}

}  // namespace turnscale
