// SPDX-License-Identifier: MIT
#include "turnscale/odometry/road_observer.h"

#include <algorithm>
#include <cmath>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/odometry/image_mask.h"

namespace turnscale {
namespace {

constexpr std::size_t kViews = 9;
// Keyframes in a row without the road at the last height, after which it is searched for at any height.
constexpr int kMostMisses = 5;
// The search takes place at each of the first kSearches keyframes, then at every kSearches-th.
constexpr int kSearches = 5;
// Bounds of that search, in distances between two keyframes.
constexpr double kLeastRatio = 0.2;
constexpr double kGreatestRatio = 10;
// Share of a new height in the one that the next search starts with.
constexpr double kFollow = 0.3;
// Keyframes without the road below the camera at which it is searched for above.
constexpr int kTriedAbove = 40;
// The images are upside down if at least so many of them, and this share, show it there, and fewer keyframes show it
// below. On upright drives the share is below a half, but for garages, whose floor shows nearly always.
constexpr int kFewestAbove = 6;
constexpr double kLeastShareAbove = 0.7;
// Relative standard deviation of the height per rad of turn: the body leans.
constexpr double kSigmaPerTurn = 0.6;

RoadRegion RegionAhead(const RigidTransform& current_from_earlier, const Eigen::Quaterniond& vehicle_from_camera,
                       double psi, double height) {
  const Eigen::Vector3d centre = current_from_earlier.translation;
  const Eigen::Vector3d travel = -centre.normalized();
  const Eigen::Vector3d right = vehicle_from_camera.conjugate() * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d down = travel.cross(right).normalized();
  RoadRegion region;
  region.level_from_camera << down.cross(travel).transpose(), down.transpose(), travel.transpose();
  region.direction = 0.5 * psi;
  region.curvature = psi * height / centre.norm();
  return region;
}

std::optional<RoadPlane> FindAtAnyHeight(const RoadPlaneOptions& options, const RoadPair& pair,
                                         const RoadRegion& region) {
  const double distance = pair.earlier_from_current.translation.norm();
  return FindRoadPlane(options, pair, region, kLeastRatio * distance, kGreatestRatio * distance);
}

// What the region ahead is in images that are upside down.
RoadRegion RegionAbove(RoadRegion region) {
  region.level_from_camera.topRows<2>() *= -1;
  region.direction *= -1;
  region.curvature *= -1;
  return region;
}

}  // namespace

void RoadObserverOptions::Check() const {
  plane.Check();
  if (!(min_baseline > 0)) throw InputError("min_baseline: has to be positive");
  if (!(baseline >= min_baseline)) throw InputError("baseline: has to be at least min_baseline");
  if (!(max_turn > 0 && max_turn < 1)) throw InputError("max_turn_deg: has to be above 0 and below 57.3");
}

const RoadObserver::View* RoadObserver::Reference(const Map& map, double height) const {
  const int latest = CountKeyframes(map) - 1;
  const Eigen::Vector3d centre = Centre(map.keyframes[latest]);
  const View* found = nullptr;
  for (auto view = views_.rbegin() + 1; view != views_.rend(); ++view) {
    const double distance = (Centre(map.keyframes[view->keyframe]) - centre).norm();
    if (distance >= options_.min_baseline * height) found = &*view;
    if (distance >= options_.baseline * height) break;
  }
  return found;
}

void RoadObserver::TestSide(bool is_below, const RoadPair& pair, const RoadRegion& region) {
  if (tried_above_ >= kTriedAbove) return;
  if (is_below) {
    ++below_;
    return;
  }
  ++tried_above_;
  if (HidesBelow(pair.mask)) ++hidden_;
  if (FindAtAnyHeight(options_.plane, pair, RegionAbove(region))) ++above_;
}

bool RoadObserver::IsRoadAbove() const {
  // Where a dashboard hides the floor of a garage, its ceiling is what shows.
  if (2 * hidden_ > tried_above_) return false;
  return above_ >= kFewestAbove && above_ >= kLeastShareAbove * tried_above_ && below_ < above_;
}

void RoadObserver::TakeView(const Map& map, const FlowImage& image) {
  const int latest = CountKeyframes(map) - 1;
  // Across a loss of tracking the unit changes.
  for (; next_keyframe_ <= latest; ++next_keyframe_) {
    if (!map.keyframes[next_keyframe_].after_gap) continue;
    views_.clear();
    height_.reset();
    misses_ = searches_ = 0;
  }
  views_.push_back({latest, {image.gray, image.pyramid[1]}});
  if (views_.size() > kViews) views_.pop_front();
}

bool RoadObserver::IsSearchDue() {
  if (height_) return true;
  ++searches_;
  return searches_ <= kSearches || searches_ % kSearches == 0;
}

void RoadObserver::Follow(const std::optional<RoadPlane>& road) {
  if (!road) {
    if (!height_ || ++misses_ < kMostMisses) return;
    height_.reset();
    misses_ = 0;
    return;
  }
  misses_ = searches_ = 0;
  height_ = height_ ? *height_ * std::pow(road->height / *height_, kFollow) : road->height;
}

std::optional<MeasuredHeight> RoadObserver::Observe(const Map& map, const Eigen::Quaterniond& vehicle_from_camera,
                                                    const FlowImage& image, const cv::Mat& mask) {
  if (!options_.enabled || image.pyramid.size() < 2) return std::nullopt;
  TakeView(map, image);
  if (views_.size() < 2) return std::nullopt;
  const View* reference = height_ ? Reference(map, *height_) : &views_[views_.size() - 2];
  if (reference == nullptr) return std::nullopt;
  const int latest = views_.back().keyframe;
  const RigidTransform earlier_from_current =
      map.keyframes[reference->keyframe].camera_from_world * map.keyframes[latest].camera_from_world.inverse();
  const double distance = earlier_from_current.translation.norm();
  const TurningMotion motion = TurningMotionOf(earlier_from_current, vehicle_from_camera);
  if (!(distance > 0) || !std::isfinite(distance) || std::abs(motion.psi) > options_.max_turn) return std::nullopt;
  // In reverse the road ahead is what the camera has just left; it is measured better going forward.
  if (std::abs(motion.theta) > 0.5 * M_PI || !IsSearchDue()) return std::nullopt;
  const RoadPair pair = {views_.back().image, reference->image, map.camera, earlier_from_current, mask};
  const RoadRegion region =
      RegionAhead(earlier_from_current.inverse(), vehicle_from_camera, motion.psi, height_.value_or(0));
  const std::optional<RoadPlane> road =
      height_ ? FitRoadPlane(options_.plane, pair, region, *height_) : FindAtAnyHeight(options_.plane, pair, region);
  Follow(road);
  TestSide(road.has_value(), pair, region);
  if (!road) return std::nullopt;
  return MeasuredHeight{.keyframe = latest,
                        .reference = reference->keyframe,
                        .ratio = road->height / distance,
                        .sigma = std::hypot(road->sigma, kSigmaPerTurn * motion.psi),
                        .reference_from_keyframe = earlier_from_current,
                        .by_rotation = road->by_rotation,
                        .by_direction = road->by_direction};
}

}  // namespace turnscale
