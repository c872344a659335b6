// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "turnscale/geometry/pinhole.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// What counts as standing still in the image while the scene moves: dashboard, bonnet, reflections, dirt on the
/// windscreen, burnt-in text.
struct StaticRegionOptions {
  /// Cells of the image in which evidence is collected, over its width; fewer in a small image. They are square.
  int columns = 64;
  /// A feature stands still if it has moved by at most this, pixels.
  double max_motion = 1.0;
  /// The camera's motion has to move whatever is at its pixel, at any depth, by at least this much, pixels. Far points
  /// stand still too while the camera does not turn: straight ahead they are not classified.
  double min_expected_motion = 5.0;
  /// A cell is left out when features have stood still there in so many more keyframes than others have moved.
  int min_evidence = 3;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Distance of an undistorted pixel from where a camera motion can take it, pixels: the least over all depths of what
/// it shows. Where it is large, a feature that has not moved does not belong to the scene.
double LeastSceneMotion(const Pinhole& pinhole, const RigidTransform& second_from_first,
                        const Eigen::Vector2d& undistorted);

/// Whether all keyframes have seen a landmark within so many pixels of an undistorted one.
bool HasStayed(const Landmark& landmark, const Eigen::Vector2d& undistorted, double max_motion);

/// How a feature has moved in the image, as evidence of whether it belongs to the scene.
struct ObservedMotion {
  cv::Point2f pixel;          ///< in the image as it came
  bool stands_still = false;  ///< although the scene moves there; else it has moved
};

/// Whether a mask (8 bit; empty: no mask) keeps the pixel nearest to a point.
bool IsKept(const cv::Mat& mask, const cv::Point2f& point);

/// Whether a mask (likewise) leaves out much of the lower half of the image, and less of the upper one: a dashboard or
/// bonnet in front of a camera that is upright.
bool HidesBelow(const cv::Mat& mask);

/// Which pixels of the image show the scene. Some are left out from the start (SetGiven); others as features turn out
/// to stand still there.
class ImageMask {
 public:
  explicit ImageMask(const StaticRegionOptions& options = {}) : options_(options) {}

  /// Sets the image's size. Throws InputError when it is not that of the given mask.
  void SetSize(const cv::Size& size);

  /// Leaves out pixels that are 0 in an 8-bit image.
  void SetGiven(const cv::Mat& mask);

  /// Takes the motion of features since the last keyframe.
  void Observe(const std::vector<ObservedMotion>& motion);

  /// Takes features that certainly stand still in the image: their cells are left out at once, unless as many features
  /// have moved there.
  void LeaveOut(const std::vector<ObservedMotion>& motion);

  /// 8 bit: 0 where pixels are left out, else 255. Empty if none are.
  const cv::Mat& pixels() const { return pixels_; }

  /// Of the images; empty before SetSize.
  const cv::Size& size() const { return size_; }

 private:
  struct Cell {
    double evidence = 0;  ///< keyframes in which features stood still, less those in which they moved
    bool left_out = false;
    bool seen = false;  ///< a feature here was classified
  };
  std::vector<int> Votes(const std::vector<ObservedMotion>& motion);
  int rows() const { return static_cast<int>(cells_.size()) / columns_; }
  bool IsLeftOut(int column, int row) const;
  void Render();

  StaticRegionOptions options_;
  cv::Size size_;
  double cell_size_ = 0;  ///< pixels
  int columns_ = 0;
  std::vector<Cell> cells_;
  cv::Mat given_;
  cv::Mat pixels_;
};

}  // namespace turnscale
