// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/pinhole.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/mapping/essential_motion.h"

namespace turnscale {

struct TwoViewOptions {
  /// Median motion of the features below which the camera counts as standing still, pixels: what tracking noise alone
  /// can look like, in any image.
  double min_motion = 1.0;
  /// Motion that a quarter of the features have to exceed after the best pure rotation has been taken out, pixels: less
  /// is too noisy to tell depths (pure rotation, low parallax). A quarter, since on an open road most of what
  /// stays in sight is far away; min_landmarks suffice where near features have gone out of view.
  double min_parallax = 12.0;
  /// The same as an angle at the image's centre, degrees: 12 pixels at a focal length of 707 pixels. In sharper images
  /// a baseline that is too short beside the depth of the scene already moves many pixels.
  double min_parallax_deg = 0.97;
  /// Largest distance of a match to its epipolar line, and largest reprojection error of a first landmark, pixels.
  double max_epipolar_error = 1.0;
  /// Least number of matches, and of landmarks of a map.
  int min_landmarks = 80;
  /// Where there are few matches (night), or few of them become landmarks (fog, rain): share of the matches that
  /// suffices instead from twice the least parallax on. At the least parallax it takes twice that share.
  double min_landmark_share = 0.25;
  /// Least number of landmarks even then.
  int fewest_landmarks = 40;
  /// Share of the matches that have to agree with the motion found.
  double min_inlier_share = 0.6;
  /// What moves as one has to have this share of the cells of the image in its rows (ShareOfCells), or it may be a
  /// vehicle ahead. It counts where other matches share another motion, or stand still while it moves back.
  double min_cell_share = 0.6;
  /// Angle under which a landmark has to be seen by both views, degrees.
  double min_landmark_parallax_deg = 0.6;
  /// Length of the first baseline: the arbitrary unit of the map.
  double initial_baseline = 1.0;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

enum class TwoViewStatus { kStandstill, kLowParallax, kFailed, kInitialized };

struct TwoViewResult {
  TwoViewStatus status = TwoViewStatus::kFailed;
  double motion = 0;    ///< median motion of the features, pixels
  double parallax = 0;  ///< motion that a quarter exceed after the best pure rotation, pixels; 0 at standstill
  RigidTransform second_from_first;
  EssentialMotion essential;            ///< from which the motion was adjusted, with the matches that agree
  std::vector<char> triangulated;       ///< one flag per match
  std::vector<Eigen::Vector3d> points;  ///< in the first camera, where triangulated
};

/// Whether features at these undistorted pixels that are counted (one flag per pixel) have enough of the image's cells
/// to be those of the scene (min_cell_share).
bool IsScene(const TwoViewOptions& options, const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels,
             const std::vector<char>& is_counted);

/// Relative pose and first landmarks from matched undistorted pixels of two views: five-point essential matrix with
/// RANSAC, the one of its four motions that puts points in front of both cameras, two-view bundle adjustment. Where two
/// groups of matches move differently, the motion is that of the group with more cells of the image (min_cell_share).
/// Says why not where the views do not suffice. `gone`: how many features of the first view have been seen after it,
/// but not in the second view.
TwoViewResult InitializeFromTwoViews(const TwoViewOptions& options, const Pinhole& pinhole,
                                     const std::vector<Eigen::Vector2d>& first,
                                     const std::vector<Eigen::Vector2d>& second, int gone = 0);

}  // namespace turnscale
