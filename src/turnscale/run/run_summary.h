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
#include "turnscale/odometry/mount_jump.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"
#include "turnscale/odometry/self_calibration.h"
#include "turnscale/run/missing_path.h"
#include "turnscale/run/run_cost.h"
#include "turnscale/run/uncertain_scale.h"

namespace turnscale {

/// That the trajectory of a run with a measured length is up to scale all the same, and why.
std::string UpToScaleText(const std::string& pending_reason);

/// Warning that a frame is skipped, and why.
std::string SkippedWarning(int frame, const std::string& problem);

/// Warning where the odometry finds, at this frame, that the camera was moved on the car.
std::string CameraMovedWarning(int frame);

/// When and how the camera has jumped on the car; the time of the jump counts from `first_time`, seconds.
std::string CameraJumpText(const MountJump& jump, double first_time);

/// Warning of `run` that the camera has jumped.
std::string CameraJumpWarning(const MountJump& jump, double first_time);

/// An image that could not be used.
struct UnreadableFrame {
  int frame = 0;
  std::string problem;
};

/// Correction of the lens calibration estimated from the drive (mapping/lens_refinement.h).
struct LensSummary {
  double correction = 0;
  double sigma = 0;
};

/// The camera-to-vehicle rotation as estimated from the drive.
struct MountSummary {
  YawPitchRoll angles;  ///< rad; as assumed if not estimated
  YawPitchRoll sigma;   ///< rad
  bool found = false;   ///< estimated well enough to be used
  int moves = 0;        ///< how often the camera was moved during the drive
  /// It is from before a move, after which it has not been estimated again.
  bool is_outdated = false;
};

/// Where tracking was lost for so long that the map began anew, in a guessed unit of length.
struct MapRestart {
  int frame = 0;          ///< the new map's first
  double time = 0;        ///< of it, seconds
  double unit_sigma = 0;  ///< relative standard deviation of its unit of length from that before
};

/// One line that names the first of them; there has to be one.
std::string UnreadableText(const std::vector<UnreadableFrame>& frames);

/// Relative standard deviation of the measured path's length up to which the scale of a drive is called known.
inline constexpr double kLargestKnownSigma = 0.15;

/// Results of a run, for summary.json and for the screen.
struct RunSummary {
  std::string version;
  std::string input;
  std::string topic;                        ///< of a bag's images; empty for other inputs
  std::string camera;                       ///< file of the intrinsics, or bag and topic; empty if there is none
  std::optional<FoundCamera> found_camera;  ///< intrinsics as estimated from the drive, if they were
  std::optional<Pinhole> pinhole;           ///< of the intrinsics that were used
  std::optional<LensModel> lens_model;      ///< likewise
  int image_width = 0;                      ///< pixels; 0 before the first image
  int image_height = 0;
  int rotate = 0;          ///< of the images, degrees clockwise (--rotate)
  std::string mask;        ///< file of the given mask; empty if there is none
  std::string pose_frame;  ///< "camera" or "vehicle"
  std::string folder;
  std::string start;            ///< of the part that is processed, as the user gave it; empty: the drive's
  std::string end;              ///< of the part; empty: the drive's
  std::vector<ClipPart> clips;  ///< the videos that were read; empty for images
  VehicleOptions vehicle;
  std::string vehicle_file;                     ///< of --vehicle; empty if there is none
  ScaleMethod method = ScaleMethod::kSmoothed;  ///< as asked for
  double first_time = 0;                        ///< of the drive's first frame, seconds; texts count from it
  int frames = 0;
  int tracked = 0;
  int repeated = 0;
  int bridged = 0;
  int initializing = 0;
  int keyframes = 0;
  std::vector<UnreadableFrame> unreadable;
  double seconds = 0;                ///< from the first frame to the last
  std::vector<MissingPart> missing;  ///< where the path is not measured
  std::vector<MapRestart> restarts;
  double missing_distance = 0;  ///< part of `distance` that lies there, interpolated or extrapolated
  double distance = 0;          ///< metres where the scale is known, else in the arbitrary unit
  ScaleState scale_state = ScaleState::kPending;
  /// Time of the first online pose in metres, seconds, where the online path jumps; empty if there is none.
  std::optional<double> live_metric_from;
  double path_sigma = 0;                ///< relative, of the path length in metres
  double scale_sigma = 0;               ///< the same without the parts of the path that are not measured
  double worst_sigma = 0;               ///< relative, the largest of the scale along the path
  double worst_sigma_time = 0;          ///< seconds, where that is
  std::optional<LensSummary> lens;      ///< empty where it was not looked for
  std::optional<MountSummary> mount;    ///< empty where it was given
  std::vector<MountJump> camera_jumps;  ///< where the camera was turned by a knock; `mount` is after the last one
  int calibration_windows = 0;          ///< parts of turns in which the intrinsics were tested
  bool calibration_agrees = true;       ///< with them, if there are any
  /// Yaw of the camera that the drive shows and the trajectory uses, rad, where it contradicts what was given.
  std::optional<double> contradicting_yaw;
  /// Empty while the scale is pending, or where the trajectory does not use it: single-turn scales.
  std::optional<CarRefinement> car;
  /// What the drive tells of the car; empty likewise, and where lever arm and camera height disagree.
  std::optional<CarEvidence> car_evidence;
  int turns_found = 0;
  int turns_used = 0;
  std::optional<HeightConflict> height_conflict;  ///< lever arm and camera height disagree
  TurnTest turn_test;                             ///< consistency of the turns
  std::optional<ImageLag> image_lag;              ///< of stabilised images, by the turns or known beforehand
  std::optional<ImageSmoothing> image_smoothing;  ///< of stabilised images, if the turns show it
  std::optional<UncertainScale> uncertain_scale;  ///< parts of the path whose scale is hardly known
  bool is_upside_down = false;                    ///< the images, by the road that they show
  std::optional<FrameBlending> blending;          ///< of the images, if there is any
  bool is_part = false;                           ///< what was processed is only a part of the drive
  std::string pending_reason;                     ///< why there is no scale; empty where there is
  std::vector<std::string> warnings;              ///< all of the run, one line each
  std::string stopped;                            ///< why the run ended before the drive did; empty if it did not
  RunCost cost;

  bool is_metric() const { return scale_state != ScaleState::kPending; }
  /// What metres follow from was given: a lever arm, or the height of the camera.
  bool has_measure() const { return vehicle.lever_arm || vehicle.camera_height; }
  /// Metres were asked for, be it by the file of a car that has neither.
  bool wants_metres() const { return has_measure() || !vehicle_file.empty(); }
  /// In metres, and exactly enough for lengths and speeds to be relied on.
  bool is_scale_known() const { return is_metric() && scale_sigma <= kLargestKnownSigma; }
};

/// The longest parts of the missing path, which a summary names.
constexpr size_t kShownMissingParts = 5;

/// "pinhole", "radial-tangential" or "equidistant".
const char* LensModelName(LensModel lens);

/// Standard deviation of the camera's height, metres, with what the sigma of the scale has for contradictions and the
/// calibration: the height is off by what the scale is off by. `calibration_sigma`: RefinedScale's.
double HeightSigma(const ScaleEstimate& estimate, double calibration_sigma = 0);

/// Fills in what follows from the refined frames and their scale, and adds the warnings. These and pending_reason also
/// depend on what the summary has of car, camera, images, clips and options. What the scale says of the calibration has
/// to be in pixels of full size.
void Summarize(const std::vector<FrameResult>& frames, const RefinedScale& scale, RunSummary& summary);

/// For a path that begins after the first frame: widens the relative sigma of its length by what it may lack, and warns
/// if it begins 2 s late, or 0.5 s and lacks 3 % of its length. Does neither if the images before it, `seen`, say that
/// the car waits. Follows Summarize.
void SummarizeBeginning(const std::vector<FrameResult>& frames, const SeenImages& seen, RunSummary& summary);

/// An estimated camera as a file that ReadCameraFile reads, with its standard deviations.
std::string FoundCameraText(const FoundCamera& found);

/// The summary as JSON; all but its "cost" is the same for the same input.
std::string SummaryJson(const RunSummary& summary);

/// The summary for people, a few lines.
std::string SummaryText(const RunSummary& summary);

/// Largest relative standard deviation that is shown as a percentage. It is one of the logarithm of the scale: above
/// this it means nothing as a share.
inline constexpr double kLargestShownSigma = 1;

/// The side slip of a car as a drive gives it, with what was assumed before the drive: "0.0041 +-0.0003 s^2/m, refined
/// from the default 0.0045 +-0.0020 s^2/m". Says so where the drive does not refine it, or would make it negative.
std::string SideSlipText(const CarRefinement& car, double assumed, double assumed_sigma);

/// The focal length of an estimated camera with its standard deviation, pixels: "600.0 +-6.0"; both focal lengths where
/// they differ, as those of pixels that are not square do.
std::string FocalLengthText(const CameraModel& camera);

}  // namespace turnscale
