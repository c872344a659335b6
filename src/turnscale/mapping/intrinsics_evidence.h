// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_problem.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/intrinsics_change.h"
#include "turnscale/mapping/intrinsics_elimination.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// Parabola of the cost in the intrinsics, whatever poses and points may be, with residuals in the distorted image:
/// cost(change) = constant + gradient^T (change - at) + (change - at)^T information (change - at) / 2.
struct IntrinsicsEvidence {
  IntrinsicsChange::Vector at = IntrinsicsChange::Vector::Zero();
  IntrinsicsChange::Matrix information = IntrinsicsChange::Matrix::Zero();
  IntrinsicsChange::Vector gradient = IntrinsicsChange::Vector::Zero();
  double pixel_sigma = 0;  ///< standard deviation of a pixel as the residuals show it, pixels
  int landmarks = 0;
  int observations = 0;
  IntrinsicsResponse response;  ///< of poses and points, from where they are

  /// information times the place of the parabola's minimum, which adds up over windows.
  IntrinsicsChange::Vector weighted_minimum() const { return information * at - gradient; }
};

/// The part of a map that is used, and its weights.
struct IntrinsicsWindow {
  int first = 0;  ///< keyframe
  int last = 0;   ///< keyframe, included; no gap in the tracking lies between
  /// Most landmarks that take part: from each part of the view in equal numbers, within a part those seen by the most
  /// keyframes. The longest tracks of all lie near its middle, where a focal length and a distortion look alike. Cost
  /// is linear in it.
  int max_landmarks = 500;
  /// Where bundle adjustment starts to weigh residuals linearly, in sigmas.
  double huber_threshold = 2.0;
};

/// A window of keyframes whose camera can be changed, with poses and points that follow. The map stays as it is.
class IntrinsicsProblem {
 public:
  /// `camera` is the one by which the map's pixels are undistorted, and that intrinsics are changes of (Correct); the
  /// problem begins with its radial correction. `pixel_sigma`: standard deviation of a pixel (pixels) until it is
  /// estimated from the residuals.
  IntrinsicsProblem(const Map& map, const CameraModel& camera, const IntrinsicsWindow& window, double pixel_sigma);

  /// Landmarks that take part; none where the window has none that three of its keyframes see.
  int landmarks() const { return static_cast<int>(bundle_.points.size()); }
  const IntrinsicsChange::Vector& change() const { return change_; }
  /// In which rows follow one another.
  const ReadDirection& read_direction() const { return camera_.read_direction; }
  const BundleProblem& bundle() const { return bundle_; }
  /// Distance from the present principal point within which all but one in a hundred observations lie, pixels of the
  /// image.
  double ObservedRadius() const;

  /// From now on, rows are taken to follow one another across the direction so far (Across). Poses and points stay.
  void ReadAcross();
  /// Takes another camera; poses and points stay.
  void Change(const IntrinsicsChange::Vector& change);
  /// Brings poses and points to where they go best with the camera, with residuals of the corrected pixels. False where
  /// they are no numbers.
  bool Adjust(int max_iterations);
  /// Sets the pixels' standard deviation to what the residuals show.
  void EstimatePixelSigma();
  double pixel_sigma() const { return pixel_sigma_; }  ///< pixels of the distorted image
  /// Lengths of the residuals, pixels of the distorted image: of each observation, in an order that stays; infinite
  /// where the present state has no prediction.
  std::vector<double> Residuals() const;
  /// Gauss-Newton's model of the cost in the intrinsics at the present state, poses and points marginalised out. The
  /// first keyframe holds still, and the unit of length with it. Nothing where the poses are not determined.
  std::optional<IntrinsicsEvidence> Evidence() const;
  /// Moves poses and points along with a change of the camera, to first order, and takes the camera over. `evidence`:
  /// that of the present state.
  void Follow(const IntrinsicsEvidence& evidence, const IntrinsicsChange::Vector& change);

 private:
  BundleProblem bundle_;
  CameraModel camera_;
  // As bundle_.observations:
  std::vector<Eigen::Vector2d> distorted_;                ///< pixels of the image
  std::vector<Eigen::Vector2d> row_motion_;               ///< of its pixel without distortion (IntrinsicsJacobian)
  std::vector<Eigen::Vector2d> across_motion_;            ///< the same with rows across the read direction
  std::vector<double> stretch_;                           ///< by which correction enlarges an error there
  std::vector<std::optional<CorrectedPixel>> corrected_;  ///< with change_; nothing where this lens has no ray
  std::vector<int> first_observation_;
  IntrinsicsChange::Vector change_ = IntrinsicsChange::Vector::Zero();
  double huber_threshold_ = 0;
  double pixel_sigma_ = 0;  ///< of the distorted image
};

}  // namespace turnscale
