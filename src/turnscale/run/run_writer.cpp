// SPDX-License-Identifier: MIT
#include "turnscale/run/run_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "turnscale/base/csv_cells.h"
#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/image_file/image_encoder.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/odometry/results.h"

namespace turnscale {
namespace {

std::string DegreesCell(double radians) {
  return std::isnan(radians) ? std::string() : fmt::format("{:.6f}", radians * kDegreesPerRadian);
}

bool AreSame(const YawPitchRoll& a, const YawPitchRoll& b) {
  return a.yaw == b.yaw && a.pitch == b.pitch && a.roll == b.roll;
}

using Colour = std::array<uint8_t, 3>;
constexpr Colour kLandmarkColour = {200, 200, 200};
constexpr Colour kCameraColour = {230, 40, 40};
constexpr size_t kPiece = 1 << 20;  // bytes

void AddVertex(std::string& vertices, const Eigen::Vector3d& position, const Colour& colour) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto bits = std::bit_cast<uint32_t>(static_cast<float>(position[axis]));
    for (int shift = 0; shift < 32; shift += 8) vertices.push_back(static_cast<char>(bits >> shift & 0xFF));
  }
  for (const uint8_t part : colour) vertices.push_back(static_cast<char>(part));
}

namespace fs = std::filesystem;

void RefuseFile(const fs::path& place) {
  std::error_code none;
  if (fs::exists(place, none) && !fs::is_directory(place, none))
    throw InputError(place.string() + ": is a file, but the results need a folder; choose another --out");
}

void MakeFolder(const fs::path& folder) {
  RefuseFile(folder);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) RefusePlace(folder.string() + ": cannot be made", error, "choose another --out");
}

// The folder, or the nearest one above it that is there. A link is there even if it leads nowhere.
fs::path NearestExisting(fs::path folder) {
  std::error_code none;
  while (!folder.empty() && !fs::exists(fs::symlink_status(folder, none))) folder = folder.parent_path();
  return folder.empty() ? "." : folder;
}

// Whether `folder` can be made in the nearest one that is there, or a file in it if that is the same. Permissions alone
// do not tell: only a file that has been made does.
void TryFile(const fs::path& folder, const fs::path& nearest) {
  std::string name = (nearest / ".turnscale-XXXXXX").string();
  const int descriptor = mkstemp(name.data());
  if (descriptor < 0) {
    const std::error_code error(errno, std::generic_category());
    RefusePlace(folder.string() + (nearest == folder ? ": no file can be made in it" : ": cannot be made"), error,
                "choose another --out");
  }
  close(descriptor);
  unlink(name.c_str());
}

void RefuseForeign(const fs::path& folder) {
  if (const fs::path file = ForeignFile(folder); !file.empty())
    throw InputError(file.string() + ": would be replaced, but is not of an earlier run; choose another --out");
}

// Marks the folder as one of a run while older results are taken away. Where it cannot be made, neither can live.tum.
void MakeMarker(const fs::path& folder) { std::ofstream(folder / RunFiles::kLiveTumPart, std::ios::app); }

void CheckFrame(const RunWriterOptions& options) {
  if (options.frame == PoseFrame::kVehicle && !options.lever_arm)
    throw InputError("--frame vehicle: needs the position of the rear axle; give --lever-arm");
}

}  // namespace

std::string FrameTableHeader() {
  return "frame,time,state,x,y,z,qx,qy,qz,qw,scale_state,scale_sigma,inliers,tracked,keyframe,psi_deg,theta_deg,"
         "turning\n";
}

std::string FrameTableLine(const FrameResult& frame, const std::optional<RigidTransform>& pose) {
  std::string cells = ",,,,,,";
  if (pose) {
    cells.clear();
    for (const double value : PoseNumbers(*pose))
      fmt::format_to(std::back_inserter(cells), "{}{:.9g}", cells.empty() ? "" : ",", value);
  }
  return fmt::format("{},{:.6f},{},{},{},{:.6g},{},{},{},{},{},{}\n", frame.frame, frame.time,
                     TrackingStateName(frame.state), cells, ScaleStateName(frame.scale_state), frame.scale_sigma,
                     frame.inliers, frame.tracked, frame.keyframe ? 1 : 0, DegreesCell(frame.psi),
                     DegreesCell(frame.theta), frame.turning ? 1 : 0);
}

std::string TurnTable(const std::vector<TurnResult>& turns) {
  std::string table =
      "first_frame,last_frame,keyframes,angle_deg,speed_mps,metres_per_unit,sigma,smoothed_metres_per_unit,"
      "smoothed_sigma,deviation_sigmas,effective_lever_arm_m,used,reason,unadjusted\n";
  for (const TurnResult& turn : turns) {
    table += fmt::format("{},{},{},{:.4f},{},{},{},{},{},{},{},{},{},{}\n", turn.first_frame, turn.last_frame,
                         turn.last_keyframe - turn.first_keyframe + 1, turn.angle * kDegreesPerRadian,
                         PositiveCell(turn.speed, 5), PositiveCell(turn.own, 9), PositiveCell(turn.own_sigma, 6),
                         PositiveCell(turn.smoothed, 9), PositiveCell(turn.smoothed_sigma, 6),
                         turn.used ? fmt::format("{:.3f}", turn.deviation) : std::string(),
                         PositiveCell(turn.effective_lever_arm, 6), turn.used ? 1 : 0, QuotedCell(turn.reason),
                         QuotedCell(turn.unadjusted));
  }
  return table;
}

std::string SpeedTable(const std::vector<SpeedReading>& speeds) {
  std::string table = "time,speed_mps,sigma_mps\n";
  for (const SpeedReading& reading : speeds)
    table += fmt::format("{:.6f},{:.4f},{:.4f}\n", reading.time, reading.speed + 0.0, reading.sigma);
  return table;
}

std::string ScaleTable(const Map& map, const RefinedScale& scale) {
  std::string table = "frame,time,metres_per_unit,sigma\n";
  for (size_t i = 0; i < scale.keyframes.size(); ++i) {
    const Keyframe& keyframe = map.keyframes[i];
    table += fmt::format("{},{:.6f},{:.9g},{:.6g}\n", keyframe.frame, keyframe.time, scale.path.metres_per_unit[i],
                         scale.keyframes[i].sigma);
  }
  return table;
}

bool RotationRecord::Differs(const Mount& other) const {
  return other.found != mount.found || other.first_keyframe != mount.first_keyframe ||
         !AreSame(other.sigma, mount.sigma) || !other.vehicle_from_camera.isApprox(mount.vehicle_from_camera);
}

void RecordRotation(int frame, double time, const Mount& mount, std::vector<RotationRecord>& records) {
  if (records.empty() || records.back().Differs(mount)) records.push_back({frame, time, mount});
}

std::string RotationTable(const std::vector<RotationRecord>& records) {
  std::string table = "frame,time,yaw_deg,pitch_deg,roll_deg,yaw_sigma_deg,pitch_sigma_deg,roll_sigma_deg,estimated\n";
  for (const RotationRecord& record : records) {
    const YawPitchRoll angles = YawPitchRollFromRotation(record.mount.vehicle_from_camera);
    const YawPitchRoll& sigma = record.mount.sigma;
    const auto degrees = [](double radians) { return DegreesCell(radians + 0.0); };
    table += fmt::format("{},{:.6f},{},{},{},", record.frame, record.time, degrees(angles.yaw), degrees(angles.pitch),
                         degrees(angles.roll));
    table += record.mount.found
                 ? fmt::format("{},{},{},1\n", degrees(sigma.yaw), degrees(sigma.pitch), degrees(sigma.roll))
                 : ",,,0\n";
  }
  return table;
}

void WriteMap(const std::filesystem::path& path, const MapPoints& points, const RigidTransform& target_from_world,
              Durability durability) {
  OutputFile file(path);
  try {
    file.Write(fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment turnscale: landmarks gray, cameras red\nelement vertex {}\n"
        "property float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
        points.landmarks.size() + points.cameras.size()));
    // In pieces: the map of a long drive is large.
    std::string vertices;
    const auto write = [&](const Eigen::Vector3d& position, const Colour& colour) {
      AddVertex(vertices, target_from_world * position, colour);
      if (vertices.size() < kPiece) return;
      file.Write(vertices);
      vertices.clear();
    };
    for (const Eigen::Vector3f& landmark : points.landmarks) write(landmark.cast<double>(), kLandmarkColour);
    for (const Eigen::Vector3d& camera : points.cameras) write(camera, kCameraColour);
    file.Write(vertices);
    file.Finish(durability);
  } catch (...) {
    file.Discard();
    throw;
  }
}

void CheckRunOutput(const RunWriterOptions& options) {
  CheckFrame(options);
  const fs::path nearest = NearestExisting(options.folder);
  std::error_code none;
  if (fs::is_symlink(nearest, none) && !fs::exists(nearest, none))
    throw InputError(nearest.string() + ": is a link to a place that is not there; choose another --out");
  RefuseFile(nearest);
  // Of a folder that is there already.
  const FolderLock lock(options.folder);
  RefuseForeign(options.folder);
  TryFile(options.folder, nearest);
}

RunWriter::RunWriter(const RunWriterOptions& options) : options_(options) {
  CheckFrame(options_);
  MakeFolder(options_.folder);
  lock_.emplace(options_.folder);
  RefuseForeign(options_.folder);
  MakeMarker(options_.folder);
  for (const char* name : RunFiles::kAll) RemoveOldFile(PathOf(name));
  live_.emplace(PathOf(RunFiles::kLiveTum));
}

void RunWriter::Add(const FrameResult& live, const Eigen::Quaterniond& first_rotation) {
  if (!live.world_from_camera) return;
  has_pose_ = true;
  live_->Write(TumLine({live.time, Shown(live, first_rotation, live.scale_state)}));
}

void RunWriter::EndLive() {
  if (!live_) return;
  if (has_pose_)
    live_->Finish();
  else
    live_->Discard();
  live_.reset();
}

void RunWriter::WriteTrajectory(const std::vector<FrameResult>& refined, const Eigen::Quaterniond& first_rotation,
                                ScaleState scale_state, Durability durability) {
  std::string tum;
  std::string kitti;
  std::string table = FrameTableHeader();
  for (const FrameResult& frame : refined) {
    std::optional<RigidTransform> pose;
    if (frame.world_from_camera) {
      pose = Shown(frame, first_rotation, scale_state);
      tum += TumLine({frame.time, *pose});
      kitti += KittiLine(*pose);
    }
    table += FrameTableLine(frame, pose);
  }
  Attempts attempts;
  attempts.Try([&] { WriteText(RunFiles::kTrajectoryTum, tum, durability); });
  attempts.Try([&] { WriteText(RunFiles::kTrajectoryKitti, kitti, durability); });
  attempts.Try([&] { WriteText(RunFiles::kTrajectoryTable, table, durability); });
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
  WriteText(RunFiles::kTurns, TurnTable(turns), durability);
}

void RunWriter::WriteSpeeds(const std::vector<SpeedReading>& speeds, Durability durability) {
  if (speeds.empty()) {
    RemoveOldFile(PathOf(RunFiles::kSpeed));
  } else {
    WriteText(RunFiles::kSpeed, SpeedTable(speeds), durability);
  }
}

void RunWriter::WriteScale(const Map& map, const RefinedScale& scale, Durability durability) {
  if (scale.estimate) {
    WriteText(RunFiles::kScale, ScaleTable(map, scale), durability);
  } else {
    RemoveOldFile(PathOf(RunFiles::kScale));
  }
}

void RunWriter::WriteRotations(const std::vector<RotationRecord>& records, Durability durability) {
  WriteText(RunFiles::kRotation, RotationTable(records), durability);
}

void RunWriter::WriteMask(const cv::Mat& mask, Durability durability) {
  if (mask.empty()) return;
  WriteText(RunFiles::kMask, EncodePng(mask), durability);
}

void RunWriter::WriteMap(const MapPoints& points, const Eigen::Quaterniond& first_rotation, ScaleState scale_state,
                         Durability durability) {
  const bool of_camera = options_.frame == PoseFrame::kCamera;
  const RigidTransform shown_from_world = of_camera ? RigidTransform{} : VehicleFromCamera(first_rotation, scale_state);
  try {
    turnscale::WriteMap(PathOf(RunFiles::kMap), points, shown_from_world, durability);
  } catch (const InputError& error) {
    throw OutputError(error.what());
  }
}

RigidTransform RunWriter::Shown(const FrameResult& frame, const Eigen::Quaterniond& first_rotation,
                                ScaleState scale_state) const {
  if (options_.frame == PoseFrame::kCamera) return *frame.world_from_camera;
  return VehicleFromCamera(first_rotation, scale_state) * *frame.world_from_camera *
         VehicleFromCamera(frame.vehicle_from_camera, scale_state).inverse();
}

RigidTransform RunWriter::VehicleFromCamera(const Eigen::Quaterniond& rotation, ScaleState scale_state) const {
  const double ahead = scale_state == ScaleState::kPending ? 0.0 : options_.lever_arm.value_or(0.0);
  return {rotation, {0, 0, ahead}};
}

}  // namespace turnscale
