// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/feature_tracks.h"
#include "turnscale/odometry/gap_rotation.h"
#include "turnscale/odometry/map_initializer.h"
#include "turnscale/odometry/motion_model.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/results.h"
#include "turnscale/odometry/unit_guess.h"

namespace turnscale {

/// The unit of a start in that of the map before a gap: from the depths of the nearest quarter of the scene on both
/// sides, and from the speed before the gap.
UnitGuess UnitAfterGap(const TrackingOptions& options, const Map& map, const MotionModel& motion,
                       const InitialMap& start);

/// Whether the car stood when the first view of a start was taken, and for a moment after it: hardly anything had moved
/// in the image then.
bool BeginsAtStandstill(const StaticRegionOptions& options, const InitialMap& start);

struct PredictedStart {
  RigidTransform first_from_world;  ///< of the first view
  double turn_sigma = 0;            ///< standard deviation of the angle turned since the last pose, rad
  bool turn_is_measured = false;    ///< in the images
};

/// Predicts the pose of a start after a gap. `measured`: the camera's rotation since the last pose before the gap,
/// where the images show it; else it follows from the turning rates before and after the gap. `metres_per_unit`: before
/// the gap, if it is known.
PredictedStart PredictStart(const MotionModel& motion, const InitialMap& start,
                            const std::optional<GapRotation>& measured, std::optional<double> metres_per_unit);

/// Where a start is put in the map.
struct StartPlace {
  PredictedStart predicted;
  UnitGuess unit{1, 0};      ///< its unit of length in that of the map
  bool after_gap = false;    ///< the map has keyframes from before
  double contrast_left = 1;  ///< Keyframe::contrast_left
};

/// What a start has become in the map.
struct AddedStart {
  int keyframe = 0;                  ///< of the first view; that of the second view is the next
  int first_landmark = 0;            ///< of the first feature; the others follow in order
  std::vector<FeatureTrack> tracks;  ///< of the second view
};

/// Adds the two views of a start as keyframes, and its features as landmarks. Throws InternalError if its pixels have
/// another radial correction than the map's.
AddedStart AddStart(const InitialMap& start, const StartPlace& place, Map& map);

/// A frame from before the map, and its pose.
struct LocatedFrame {
  FrameResult result;
  RigidTransform camera_from_world;
};

/// The poses of the frames that waited for the map, except that of the second view, which is a keyframe. The motion
/// model goes along to the second view.
std::vector<LocatedFrame> LocateWaitingFrames(const OdometryOptions& options, const InitialMap& start,
                                              const AddedStart& added, const Map& map, MotionModel& motion);

}  // namespace turnscale
