// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/io/folder_lock.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/run_files.h"
#include "turnscale/kinematics/speed_smoother.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// First line of trajectory.csv.
std::string FrameTableHeader();

/// A frame's line in trajectory.csv; `pose` is the one to show. Cells without a value are empty.
std::string FrameTableLine(const FrameResult& frame, const std::optional<RigidTransform>& pose);

/// The whole of turns.csv.
std::string TurnTable(const std::vector<TurnResult>& turns);

/// The whole of speed.csv: `time,speed_mps,sigma_mps`.
std::string SpeedTable(const std::vector<SpeedReading>& speeds);

/// The whole of scale.csv: a line per keyframe of the map, its smoothed scale and the relative sigma.
std::string ScaleTable(const Map& map, const RefinedScale& scale);

/// The camera-to-vehicle rotation in use from a frame on.
struct RotationRecord {
  int frame = 0;
  double time = 0;  ///< seconds
  Mount mount;

  /// Whether the record of another rotation has to follow this one.
  bool Differs(const Mount& other) const;
};

/// Adds the rotation in use at a frame, `time` in seconds, unless it is that of the last record.
void RecordRotation(int frame, double time, const Mount& mount, std::vector<RotationRecord>& records);

/// The whole of camera_rotation.csv: a line per change of the rotation or of its sigma, degrees; the sigmas are empty
/// if the rotation was not estimated.
std::string RotationTable(const std::vector<RotationRecord>& records);

/// Writes a map as binary PLY: landmarks in light gray, keyframe cameras in red, transformed by `target_from_world`.
/// Throws as OutputFile does.
void WriteMap(const std::filesystem::path& path, const MapPoints& points, const RigidTransform& target_from_world = {},
              Durability durability = Durability::kPowerCut);

/// The frame whose poses are written.
enum class PoseFrame {
  kCamera,  ///< the camera's, in the world of the first keyframe's camera
  /// The rear axle's, in the axle's own frame at the moment when the camera was at the world's origin. While the scale
  /// is pending the metre is unknown, and with it where the axle is: then the camera's place with the car's axes.
  kVehicle,
};

struct RunWriterOptions {
  std::filesystem::path folder;
  PoseFrame frame = PoseFrame::kCamera;
  std::optional<double> lever_arm = {};  ///< metres; the place of the rear axle
};

/// Throws InputError where results could not be written to the folder, would replace files there that are not of a run
/// (ForeignFile) or those that another run is writing, or cannot be of this frame: before a run, which may take hours.
/// Leaves nothing behind.
void CheckRunOutput(const RunWriterOptions& options);

/// Writes the results of a run to its folder: live.tum.part is made first, grows by one line per pose and becomes
/// live.tum at the end; all other files are written as a whole. Every function throws OutputError if the system refuses
/// to write, after trying the other files. `first_rotation` is from the camera to the vehicle at the origin of the
/// world frame.
class RunWriter {
 public:
  /// Makes the folder and keeps other runs out of it (FolderLock); results of an earlier run are taken away. Throws as
  /// CheckRunOutput, and InputError where a file cannot be made.
  explicit RunWriter(const RunWriterOptions& options);

  /// Writes the result of the newest frame to live.tum.part, if it has a pose.
  void Add(const FrameResult& live, const Eigen::Quaterniond& first_rotation);

  /// Writes the refined trajectory. Frames are left out of the trajectory files only while there is no map at all; the
  /// table has every frame.
  void WriteTrajectory(const std::vector<FrameResult>& refined, const Eigen::Quaterniond& first_rotation,
                       ScaleState scale_state, Durability durability = Durability::kPowerCut);

  /// No frame comes any more: live.tum gets its name; without a pose there is none, and its part is taken away.
  void EndLive();

  /// Writes speed.csv; takes away that of an earlier state of the run if there are no speeds.
  void WriteSpeeds(const std::vector<SpeedReading>& speeds, Durability durability = Durability::kPowerCut);
  /// Writes scale.csv; likewise while the scale is pending.
  void WriteScale(const Map& map, const RefinedScale& scale, Durability durability = Durability::kPowerCut);
  void WriteRotations(const std::vector<RotationRecord>& records, Durability durability = Durability::kPowerCut);
  void WriteTurns(const std::vector<TurnResult>& turns, Durability durability = Durability::kPowerCut);
  void WriteMap(const MapPoints& points, const Eigen::Quaterniond& first_rotation, ScaleState scale_state,
                Durability durability = Durability::kPowerCut);
  /// Writes which pixels were left out (0), unless the mask is empty.
  void WriteMask(const cv::Mat& mask, Durability durability = Durability::kPowerCut);
  /// Any file of the folder, in one step.
  void WriteText(const std::string& name, const std::string& text, Durability durability = Durability::kPowerCut);

  /// The pose to show of a frame that has one: the camera's or the rear axle's.
  RigidTransform Shown(const FrameResult& frame, const Eigen::Quaterniond& first_rotation,
                       ScaleState scale_state) const;

 private:
  std::filesystem::path PathOf(const std::string& name) const { return options_.folder / name; }
  RigidTransform VehicleFromCamera(const Eigen::Quaterniond& rotation, ScaleState scale_state) const;

  RunWriterOptions options_;
  std::optional<FolderLock> lock_;
  std::optional<OutputFile> live_;  // until its end
  bool has_pose_ = false;
};

}  // namespace turnscale
