// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_problem.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/pinhole.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// By how much a camera differs from a given one: log of the focal length's ratio (both axes together), principal point
/// x and y (pixels, further right and down), and the terms in r^2, r^4 and r^6 of the radial correction (Correct): the
/// whole of it, not what comes on top of the one that is applied to the map's pixels.
struct IntrinsicsChange {
  enum Entry { kLogFocal, kCentreX, kCentreY, kCorrection, kCorrection4, kCorrection6 };
  static constexpr int kEntries = kCorrection6 + 1;
  using Vector = Eigen::Matrix<double, kEntries, 1>;
  using Matrix = Eigen::Matrix<double, kEntries, kEntries>;
};

/// The pinhole that differs by `change` from `given`. The correction plays no part.
Pinhole ChangedPinhole(const Pinhole& given, const IntrinsicsChange::Vector& change);

/// Where the ideal pinhole camera shows the ray of a distorted pixel, and the derivative of the ray by the distorted
/// point (both on the plane z = 1).
struct CorrectedPixel {
  Eigen::Vector2d pixel;
  Eigen::Vector2d lens_point;  ///< without distortion as `camera` has it, before the correction
  Eigen::Matrix2d jacobian;
};

/// Undistorts a pixel with the lens of `camera`, the pinhole that differs by `change` from its own, and the correction
/// of `change`: on the plane z = 1, the ray moves away from the axis by the share kCorrection r^2 + kCorrection4 r^4 +
/// kCorrection6 r^6, r being the distance of the distorted point from the axis, which is bounded for any lens.
/// `camera.radial_correction` plays no part. Nothing where the lens has no ray for the pixel.
std::optional<CorrectedPixel> Correct(const CameraModel& camera, const IntrinsicsChange::Vector& change,
                                      const Eigen::Vector2d& distorted);

/// Parabola of the cost in the intrinsics, whatever poses and points may be, with residuals in the distorted image:
/// cost(change) = constant + gradient^T (change - at) + (change - at)^T information (change - at) / 2.
struct IntrinsicsEvidence {
  IntrinsicsChange::Vector at = IntrinsicsChange::Vector::Zero();
  IntrinsicsChange::Matrix information = IntrinsicsChange::Matrix::Zero();
  IntrinsicsChange::Vector gradient = IntrinsicsChange::Vector::Zero();
  double pixel_sigma = 0;  ///< standard deviation of a pixel as the residuals show it, pixels
  int landmarks = 0;
  int observations = 0;

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
  const BundleProblem& bundle() const { return bundle_; }
  /// Distance from the present principal point within which all but one in a hundred observations lie, pixels of the
  /// image.
  double ObservedRadius() const;

  /// Takes another camera; poses and points stay.
  void Change(const IntrinsicsChange::Vector& change);
  /// Brings poses and points to where they go best with the camera, with residuals of the corrected pixels. False where
  /// they are no numbers.
  bool Adjust(int max_iterations);
  /// Sets the pixels' standard deviation to what the residuals show.
  void EstimatePixelSigma();
  /// Gauss-Newton's model of the cost in the intrinsics at the present state, poses and points marginalised out. The
  /// first keyframe holds still, and the unit of length with it. Nothing where the poses are not determined.
  std::optional<IntrinsicsEvidence> Evidence();
  /// Moves poses and points along with a change of the camera from where Evidence was taken, to first order, and takes
  /// the camera over.
  void Follow(const IntrinsicsChange::Vector& change);

 private:
  BundleProblem bundle_;
  CameraModel camera_;
  // As bundle_.observations:
  std::vector<Eigen::Vector2d> distorted_;                ///< pixels of the image
  std::vector<double> stretch_;                           ///< by which correction enlarges an error there
  std::vector<std::optional<CorrectedPixel>> corrected_;  ///< with change_; nothing where this lens has no ray
  std::vector<int> first_observation_;
  IntrinsicsChange::Vector change_ = IntrinsicsChange::Vector::Zero();
  double huber_threshold_ = 0;
  double pixel_sigma_ = 0;  ///< of the distorted image
  // Of the latest evidence: step of the cameras for a step of the intrinsics and without one, and the same of points.
  Eigen::MatrixXd camera_response_;
  Eigen::VectorXd camera_step_;
  std::vector<Eigen::Matrix<double, 3, IntrinsicsChange::kEntries>> point_response_;
  std::vector<Eigen::Vector3d> point_step_;
};

/// Derivative of (predicted pixel - corrected pixel) by the intrinsics, pixels per unit of each. `pinhole` is that of
/// the prediction, `distorted` the point on the plane z = 1 that was corrected.
Eigen::Matrix<double, 2, IntrinsicsChange::kEntries> IntrinsicsJacobian(const Pinhole& pinhole,
                                                                        const Eigen::Vector3d& x_in_camera,
                                                                        const Eigen::Vector2d& distorted,
                                                                        const CorrectedPixel& corrected);

}  // namespace turnscale
