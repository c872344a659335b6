// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <optional>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "turnscale/features/optical_flow.h"
#include "turnscale/geometry/angle.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/road_heights.h"
#include "turnscale/road/road_plane.h"

namespace turnscale {

struct RoadObserverOptions {
  bool enabled = true;  ///< observe the road
  RoadPlaneOptions plane;
  /// Distance between the two keyframes that are compared, heights; less where the car is slow.
  double baseline = 0.5;
  double min_baseline = 0.1;  ///< heights
  /// Turn between the two keyframes beyond which the road is not observed, rad (6 deg): the body leans.
  double max_turn = 6.0 / kDegreesPerRadian;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Measures the height of the camera above the road from the images of keyframes.
class RoadObserver {
 public:
  explicit RoadObserver(const RoadObserverOptions& options) : options_(options) {}

  /// Takes the latest keyframe of the map. `mask`: as ImageMask::pixels. Empty where the road is not observed. Reads
  /// only the map's camera and the number, poses and gaps of its keyframes: landmarks and observations may be added
  /// meanwhile.
  std::optional<MeasuredHeight> Observe(const Map& map, const Eigen::Quaterniond& vehicle_from_camera,
                                        const FlowImage& image, const cv::Mat& mask);

  /// Whether the keyframes so far show the road above the camera rather than below: the images are upside down. Their
  /// motion alone does not tell.
  bool IsRoadAbove() const;

  /// The unit of the map's latest keyframes has changed: a length there is `factor` times what it was.
  void Rescale(double factor) {
    if (height_) *height_ *= factor;
  }

  /// The next image is not compared with those so far.
  void Restart() { views_.clear(); }

 private:
  struct View {
    int keyframe;
    RoadImage image;
  };
  const View* Reference(const Map& map, double height) const;
  /// Adds the latest keyframe to the views, and forgets those of another unit of length.
  void TakeView(const Map& map, const FlowImage& image);
  /// Whether the road is to be looked for at this keyframe: at the height where it was, or now and then at any.
  bool IsSearchDue();
  /// Starts the next search where the road was found, or at any height after some misses.
  void Follow(const std::optional<RoadPlane>& road);
  /// Counts whether the road is below the camera or, if it is not found there, above.
  void TestSide(bool is_below, const RoadPair& pair, const RoadRegion& region);

  RoadObserverOptions options_;
  int next_keyframe_ = 0;         ///< the first one that has not been looked at
  std::deque<View> views_;        ///< recent keyframes, the latest last
  std::optional<double> height_;  ///< where the next search starts, map units
  int misses_ = 0;                ///< keyframes in a row that do not show the road there
  int searches_ = 0;              ///< keyframes in a row at which it could have been searched for at any height
  int tried_above_ = 0;           ///< keyframes at which it has been searched for above the camera
  int above_ = 0;                 ///< of them, those that show it there
  int hidden_ = 0;                ///< of those tried, the ones in which what is below is hidden (HidesBelow)
  int below_ = 0;                 ///< keyframes until then that show it below
};

}  // namespace turnscale
