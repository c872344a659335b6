// SPDX-License-Identifier: MIT
#include "turnscale/io/run_writer.h"

#include <algorithm>
#include <system_error>

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
  for (const char* name : {kTurns, kMap, "summary.json"}) {
    std::error_code error;
    if (fs::is_regular_file(PathOf(name), error)) fs::remove(PathOf(name), error);
  }
  live_.emplace(PathOf(kLive));
  Rewrite({}, ScaleState::kPending);
}

bool RunWriter::Add(const FrameResult& live, int revision, ScaleState scale_state) {
  if (live.world_from_camera) {
    live_->Write(TumLine({live.time, Shown(live, live.scale_state)}));
  }
  latest_revision_ = revision;
  if (scale_state != scale_state_) return true;
  if (revision != revision_) return live.frame + 1 - written_ >= std::max(1, written_ / 50);
  if (live.world_from_camera && live.frame == written_) Append(live);
  return false;
}

void RunWriter::Rewrite(const std::vector<FrameResult>& refined, ScaleState scale_state) {
  std::string tum;
  std::string kitti;
  std::string table = FrameTableHeader();
  int posed = 0;
  for (const FrameResult& frame : refined) {
    std::optional<RigidTransform> pose;
    if (frame.world_from_camera) {
      pose = Shown(frame, scale_state);
      tum += TumLine({frame.time, *pose});
      kitti += KittiLine(*pose);
      ++posed;
    }
    table += FrameTableLine(frame, pose);
  }
  files_.reset();
  ReplaceFile(PathOf(kTum), tum);
  ReplaceFile(PathOf(kKitti), kitti);
  ReplaceFile(PathOf(kTable), table);
  constexpr auto kAppend = OutputFile::Mode::kAppend;
  files_.emplace(Files{OutputFile(PathOf(kTum), kAppend), OutputFile(PathOf(kKitti), kAppend),
                       OutputFile(PathOf(kTable), kAppend)});
  written_ = posed;
  revision_ = latest_revision_;
  scale_state_ = scale_state;
}

void RunWriter::WriteTurns(const std::vector<TurnResult>& turns) { WriteText(kTurns, TurnTable(turns)); }

void RunWriter::WriteMap(const MapPoints& points, ScaleState scale_state) {
  const bool of_camera = options_.frame == PoseFrame::kCamera;
  turnscale::WriteMap(
      PathOf(kMap), points,
      of_camera ? RigidTransform{} : VehicleFromCamera(options_.vehicle.vehicle_from_camera, scale_state));
}

void RunWriter::WriteText(const std::string& name, const std::string& text) { ReplaceFile(PathOf(name), text); }

RigidTransform RunWriter::Shown(const FrameResult& frame, ScaleState scale_state) const {
  if (options_.frame == PoseFrame::kCamera) return *frame.world_from_camera;
  return VehicleFromCamera(options_.vehicle.vehicle_from_camera, scale_state) * *frame.world_from_camera *
         VehicleFromCamera(frame.vehicle_from_camera, scale_state).inverse();
}

RigidTransform RunWriter::VehicleFromCamera(const Eigen::Quaterniond& rotation, ScaleState scale_state) const {
  const double ahead = scale_state == ScaleState::kPending ? 0.0 : options_.vehicle.lever_arm.value_or(0.0);
  return {rotation, {0, 0, ahead}};
}

void RunWriter::Append(const FrameResult& frame) {
  const RigidTransform pose = Shown(frame, scale_state_);
  files_->tum.Write(TumLine({frame.time, pose}));
  files_->kitti.Write(KittiLine(pose));
  files_->table.Write(FrameTableLine(frame, pose));
  ++written_;
}

}  // namespace turnscale
