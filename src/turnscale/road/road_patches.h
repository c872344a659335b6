// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// The road in a camera's axes.
struct RoadSurface {
  /// The plane that is tangent to the road below the camera, by the inverse depth of its points: plane.dot(ray) = 1/z
  /// for rays with z = 1. It is the plane's normal, which points away from the camera, over its distance.
  Eigen::Vector3d plane = Eigen::Vector3d::UnitY();
  /// Curvature of the road along the way, rad per height of the camera, positive where it curves down (a crest).
  double vertical_curvature = 0;

  /// 1/z where a ray with z = 1 meets the road; not positive where it does not.
  double InverseDepth(const Eigen::Vector3d& ray) const;
  /// Derivative of InverseDepth by the plane's three numbers and the vertical curvature.
  Eigen::Vector4d ByParameters(const Eigen::Vector3d& ray) const;
};

/// An image at full and at half size, 8-bit gray.
struct RoadImage {
  cv::Mat gray;
  cv::Mat half;
};

/// Two images and the camera's motion between them.
struct RoadPair {
  const RoadImage& current;
  const RoadImage& earlier;
  const CameraModel& camera;
  RigidTransform earlier_from_current;
  cv::Mat mask;  ///< 8 bit, full size: patches that cover a pixel of 0, in either image, are left out; empty: none
};

/// Where the road is expected in the current image. Lengths are in heights of the camera above the road.
struct RoadRegion {
  /// Axes x right, y down, z forward, the road's plane being x-z.
  Eigen::Matrix3d level_from_camera = Eigen::Matrix3d::Identity();
  double direction = 0;  ///< of travel here, relative to z, rad, positive to the right
  double curvature = 0;  ///< of the path ahead, horizontal, rad per height, positive to the right
};

/// Numbers of pixels below are those of KITTI's images: focal length 718 pixels, camera 1.65 m above the road, compared
/// with an image half a height behind.
struct RoadPatchOptions {
  /// Of the region, heights: a lane of 3.5 m below a camera at 1.6 m.
  double half_width = 1.1;
  /// End of the region, heights ahead: 34 degrees below the horizon. Where images end before it, so does the region;
  /// KITTI's end at 4 heights. A smaller one matters to images that show more, whose rows would be higher.
  double nearest = 1.5;
  /// Other end, heights ahead: 18 m. There, 1 % of the height moves a patch by 0.03 pixels (at 4 heights by 0.2). A
  /// larger one tells more of the road's pitch, but takes in more of its crests and dips.
  double farthest = 11.0;
  /// Cells of the region, one patch each: 12 pixels high and 10 to 27 wide, so that patches hardly overlap. Time is
  /// linear in their number.
  int rows = 9;
  int columns = 14;
  /// Half the side of a patch, pixels: the side is 2 * half_size + 1. Larger ones are more distinct, but fewer fit in
  /// the region, and more of them reach beyond its edge.
  int half_size = 4;
  /// Standard deviation of the gray levels of a patch: about the noise of one image below. A larger one leaves out
  /// smooth asphalt: 5 takes a third of the inliers on KITTI 07. A smaller one adds hardly any there.
  double least_contrast = 2.0;
  /// Standard deviation of a gray level, interpolated, of both images together: 2.1 of each. A larger one gives patches
  /// of little contrast less weight, and heights a somewhat larger sigma.
  double image_noise = 3.0;
  /// Of the position of a patch, pixels, however strong its contrast. With a smaller one, few patches of strong
  /// contrast, such as lane markings, decide; with a larger one, all patches of the same place count alike.
  double least_pixel_sigma = 0.1;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// A patch of the current image at one of its two sizes.
struct RoadPatch {
  Eigen::Vector3d ray;                      ///< of its centre, z = 1
  Eigen::Matrix<double, 3, 2> ray_by_step;  ///< change of the ray by half_size pixels to the right and down
  Eigen::ArrayXf gray;                      ///< less its mean, over its norm
  Eigen::ArrayXf gray_x;                    ///< derivatives of `gray`, per pixel
  Eigen::ArrayXf gray_y;
  double contrast = 0;  ///< the norm
};

/// Patches of the road region with the most texture along the image motion. `size`: 0 full, 1 half.
std::vector<RoadPatch> SelectRoadPatches(const RoadPatchOptions& options, const RoadPair& pair,
                                         const RoadRegion& region, int size);

/// How a patch looks in the earlier image, if it lies on the road.
struct PatchMatch {
  double correlation = 0;
  double inverse_depth_change = 0;  ///< by which the patch itself would be nearer or farther, first order
  double variance = 0;              ///< of it
};

/// Empty where the patch leaves the earlier image, or its depth cannot be seen.
std::optional<PatchMatch> MatchPatch(const RoadPatchOptions& options, const RoadPair& pair, const RoadPatch& patch,
                                     const RoadSurface& surface, int size);

/// Derivatives of PatchMatch::inverse_depth_change by a small rotation (rad) and translation that follow
/// `earlier_from_current`, in the axes of the earlier camera. A shift of the patch across its epipolar line is taken to
/// leave the match as it is. Empty where MatchPatch would be.
std::optional<Eigen::Matrix<double, 1, 6>> InverseDepthChangeByMotion(const RoadPair& pair, const Eigen::Vector3d& ray,
                                                                      const RoadSurface& surface);

}  // namespace turnscale
