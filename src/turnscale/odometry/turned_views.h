// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "turnscale/mapping/map.h"

namespace turnscale {

/// An image taken before another one, and how the camera has turned since.
struct EarlierView {
  cv::Mat gray;  ///< 8 bit; empty: there is none
  Eigen::Quaterniond now_from_then = Eigen::Quaterniond::Identity();
};

/// Keeps the images of the last two keyframes between which the camera has turned: it always looks in another direction
/// than in one of them. What is far away has moved in the image since; a dashboard has not.
class TurnedViews {
 public:
  /// The image of the map's latest keyframe.
  void Add(const Map& map, const cv::Mat& gray);

  /// A new map begins: the directions before it are not known exactly.
  void Clear();

  /// The later one of the two that looks in another direction than this pose; none where the camera has not turned.
  EarlierView Before(const Map& map, const Eigen::Quaterniond& camera_from_world) const;

 private:
  struct View {
    int keyframe = 0;
    cv::Mat gray;
  };
  View earlier_;
  View later_;
};

}  // namespace turnscale
