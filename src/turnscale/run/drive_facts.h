// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/camera/camera_model.h"
#include "turnscale/frames/blended_frames.h"
#include "turnscale/frames/image_source.h"
#include "turnscale/frames/seen_images.h"
#include "turnscale/geometry/pinhole.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/mount_jump.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/self_calibration.h"
#include "turnscale/run/missing_path.h"

namespace turnscale {

/// What a run was given, as its summary names it. Known before the first frame.
struct RunInput {
  std::string version;  ///< of the program
  std::string input;
  std::string topic;                        ///< of a bag's images; empty for other inputs
  std::string camera;                       ///< file of the intrinsics, or bag and topic; empty if there is none
  std::optional<FoundCamera> found_camera;  ///< intrinsics as estimated from the drive beforehand, if they were
  int rotate = 0;                           ///< of the images, degrees clockwise (--rotate)
  std::string mask;                         ///< file of the given mask; empty if there is none
  std::string vehicle_file;                 ///< of --vehicle; empty if there is none
  std::string pose_frame;                   ///< "camera" or "vehicle"
  std::string folder;                       ///< of the results
  std::string start;                        ///< of the part that is processed, as the user gave it; empty: the drive's
  std::string end;                          ///< of the part; empty: the drive's
  std::string recorded_from;                ///< when the drive begins by the recorder's clock; empty if it is unknown
  double first_time = 0;                    ///< of the drive's first frame, seconds; texts count from it
};

/// Where a run ended, and what of the drive it had read by then.
struct RunEnding {
  std::vector<ClipPart> clips = {};  ///< the videos that were read; empty for images
  bool is_part = false;              ///< what was processed is only a part of the drive
  std::string stopped = {};          ///< why the run ended before the drive did; empty if it did not
};

/// An image that could not be used.
struct UnreadableFrame {
  int frame = 0;
  std::string problem;
};

/// The images of a drive.
struct ImageSummary {
  int width = 0;  ///< pixels at full size; 0 before the first image
  int height = 0;
  std::vector<UnreadableFrame> unreadable;
  bool is_upside_down = false;            ///< by the road that they show
  std::optional<FrameBlending> blending;  ///< if there is any
};

/// Correction of the lens calibration estimated from the drive (mapping/lens_refinement.h).
struct LensCorrection {
  double correction = 0;
  double sigma = 0;
};

/// The intrinsics that were used, at full size; empty before the drive.
struct CameraSummary {
  std::optional<Pinhole> pinhole;
  std::optional<LensModel> lens_model;
  std::optional<LensCorrection> correction;  ///< empty where it was not looked for
};

/// The camera-to-vehicle rotation as estimated from the drive.
struct MountEstimate {
  YawPitchRoll angles;           ///< rad; as assumed if not estimated
  YawPitchRoll sigma;            ///< rad
  bool found = false;            ///< estimated well enough to be used
  std::vector<MountMove> moves;  ///< of the camera on the car during the drive, other than knocks
  /// It is from before a move, after which it has not been estimated again.
  bool is_outdated = false;
};

/// How the camera sits on the car.
struct MountSummary {
  std::optional<MountEstimate> estimate;  ///< empty where the rotation was given
  std::vector<MountJump> jumps;           ///< where the camera was turned by a knock; `estimate` is after the last one
};

/// What is known of a run and its drive besides the refined frames and their scale.
struct DriveFacts {
  RunInput given;
  RunEnding ending;
  ImageSummary images;
  CameraSummary camera;
  MountSummary mount;
  VehicleOptions vehicle;                       ///< the car, as assumed before the drive
  ScaleMethod method = ScaleMethod::kSmoothed;  ///< as asked for
  int processed = 0;                            ///< frames, also where no results could be computed of them
  std::vector<int> repeated;                    ///< frames that were taken for repeated images online, ascending
  SeenImages seen;                              ///< the images before the map
  std::vector<MapRestart> restarts;
  int failed_adjustments = 0;  ///< of the map (Odometry::failed_adjustments)
  /// Time of the first online pose in metres, seconds, where the online path jumps; empty if there is none.
  std::optional<double> live_metric_from;

  /// What metres follow from was given: a lever arm, or the height of the camera.
  bool has_measure() const { return vehicle.lever_arm || vehicle.camera_height; }
  /// Metres were asked for, be it by the file of a car that has neither.
  bool wants_metres() const { return has_measure() || !given.vehicle_file.empty(); }
  /// The camera-to-vehicle rotation that the estimate of the scale began with, rad: as estimated, else as given.
  YawPitchRoll camera_angles() const {
    return mount.estimate ? mount.estimate->angles : YawPitchRollFromRotation(vehicle.vehicle_from_camera);
  }
};

}  // namespace turnscale
