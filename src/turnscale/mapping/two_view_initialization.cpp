// SPDX-License-Identifier: MIT
#include "turnscale/mapping/two_view_initialization.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/geometry/triangulation.h"
#include "turnscale/mapping/cell_weights.h"
#include "turnscale/mapping/essential_motion.h"
#include "turnscale/mapping/landmarks.h"
#include "turnscale/mapping/left_out.h"

namespace turnscale {
namespace {

// Of the least parallax: at this, more of it shows hardly any more landmarks.
constexpr double kAmpleParallax = 2;

std::vector<Eigen::Vector3d> Rays(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<Eigen::Vector3d> rays;
  rays.reserve(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels) rays.push_back(pinhole.Ray(pixel));
  return rays;
}

// Of the pixels, in the image.
double MedianMotion(const std::vector<Eigen::Vector2d>& first, const std::vector<Eigen::Vector2d>& second) {
  std::vector<double> motion;
  motion.reserve(first.size());
  for (size_t i = 0; i < first.size(); ++i) motion.push_back((second[i] - first[i]).norm());
  return Median(std::move(motion));
}

// Motion of each match that no rotation explains, pixels.
std::vector<double> Parallaxes(const Pinhole& pinhole, const std::vector<Eigen::Vector3d>& first_rays,
                               const std::vector<Eigen::Vector3d>& second_rays,
                               const std::vector<Eigen::Vector2d>& second) {
  const Eigen::Quaterniond rotation = FitRotation(first_rays, second_rays);
  std::vector<double> parallax;
  for (size_t i = 0; i < second.size(); ++i) {
    const Eigen::Vector3d rotated = rotation * first_rays[i];
    if (rotated.z() > 0) parallax.push_back((second[i] - pinhole.Project(rotated)).norm());
  }
  return parallax;
}

// Near features move most, and soon go out of view. Then the upper quartile of those that remain stays low, although
// the baseline suffices.
bool HaveNearGone(const TwoViewOptions& options, const std::vector<double>& parallaxes, double least, int gone) {
  constexpr double kLeastShare = 0.5;
  const auto moved = std::ranges::count_if(parallaxes, [&](double parallax) { return parallax >= least; });
  const auto all = static_cast<double>(parallaxes.size()) + gone;
  return moved >= options.min_landmarks && static_cast<double>(moved) + gone >= kLeastShare * all;
}

// Pixels: the larger of the two bounds.
double LeastParallax(const TwoViewOptions& options, const Pinhole& pinhole) {
  return std::max(options.min_parallax, options.min_parallax_deg / kDegreesPerRadian * pinhole.fx);
}

double LandmarksNeeded(const TwoViewOptions& options, const Pinhole& pinhole, double parallax, size_t matches) {
  const double ample = std::min((parallax / LeastParallax(options, pinhole) - 1) / (kAmpleParallax - 1), 1.0);
  const double share = options.min_landmark_share * (2 - ample);
  return std::clamp<double>(share * static_cast<double>(matches), options.fewest_landmarks, options.min_landmarks);
}

int Count(const std::vector<char>& flags) { return static_cast<int>(std::ranges::count(flags, 1)); }

bool AgreeEnough(const TwoViewOptions& options, int agreeing, size_t matches) {
  return agreeing >= options.min_inlier_share * static_cast<double>(matches);
}

using Pixels = std::vector<Eigen::Vector2d>;

// Matches that share a motion, and how many others there are that share another.
struct CommonMotion {
  EssentialMotion motion;
  size_t set_aside = 0;
};

// The motion of most matches, unless those near enough for a depth have too few cells of the image, and the others
// share another motion: a vehicle ahead may have most of the matches. Then the motion with more cells, if they are
// enough; none where cells and matches contradict each other.
CommonMotion FindSceneMotion(const TwoViewOptions& options, const Pinhole& pinhole, const Pixels& first,
                             const Pixels& second) {
  CommonMotion most{.motion = FindEssentialMotion(pinhole, first, second, options.max_epipolar_error)};
  const std::vector<char>& of_most = most.motion.inlier;
  if (of_most.empty() || IsScene(options, pinhole, second, of_most)) return most;
  const Pixels other_first = Without(of_most, first);
  const size_t others = other_first.size();
  if (static_cast<int>(others) < options.fewest_landmarks) return most;
  CommonMotion rest{
      .motion = FindEssentialMotion(pinhole, other_first, Without(of_most, second), options.max_epipolar_error)};
  if (rest.motion.agrees.empty() || !AgreeEnough(options, Count(rest.motion.agrees), others)) return most;
  // Where most of the scene is far away, the others have the same motion.
  if (AgreeEnough(options, Count(most.motion.agrees) - Count(of_most), others)) return most;
  rest.motion.agrees = OfAll(of_most, rest.motion.agrees, char{0});
  rest.motion.inlier = OfAll(of_most, rest.motion.inlier, char{0});
  std::vector<char> of_either = of_most;
  for (size_t i = 0; i < of_either.size(); ++i) of_either[i] |= rest.motion.inlier[i];
  const double share_of_most = ShareOfCells(pinhole, second, of_most, of_either);
  const double share_of_rest = ShareOfCells(pinhole, second, rest.motion.inlier, of_either);
  // The motion of fewer matches has to have clearly more cells.
  constexpr double kClearly = 1.25;
  const bool is_rest = share_of_rest > kClearly * share_of_most;
  if (!is_rest && share_of_rest > share_of_most) return {};
  const double least = options.min_cell_share * (1 - std::min(share_of_most, share_of_rest));
  if (std::max(share_of_most, share_of_rest) < least) return {};
  most.set_aside = Count(rest.motion.inlier);
  rest.set_aside = Count(of_most);
  return is_rest ? rest : most;
}

// Takes the motion and the landmarks, and returns how many landmarks there are. The baseline defines the unit.
int TakeLandmarks(const TwoViewOptions& options, const Pinhole& pinhole, const TwoViewGeometry& geometry,
                  const std::vector<Eigen::Vector2d>& first, const std::vector<Eigen::Vector2d>& second,
                  TwoViewResult& result) {
  result.second_from_first = geometry.second_from_first;
  result.triangulated.assign(first.size(), 0);
  result.points.assign(first.size(), Eigen::Vector3d::Zero());
  const double unit = options.initial_baseline / result.second_from_first.translation.norm();
  int landmarks = 0;
  for (size_t k = 0; k < geometry.match_of_point.size(); ++k) {
    const size_t i = geometry.match_of_point[k];
    const Eigen::Vector3d& x = geometry.points[k];
    const double angle = ParallaxAngle(RigidTransform{}, result.second_from_first, x);
    if (angle * kDegreesPerRadian < options.min_landmark_parallax_deg) continue;
    if (ReprojectionError(pinhole, RigidTransform{}, x, first[i]) > options.max_epipolar_error) continue;
    if (ReprojectionError(pinhole, result.second_from_first, x, second[i]) > options.max_epipolar_error) continue;
    result.triangulated[i] = 1;
    result.points[i] = unit * x;
    ++landmarks;
  }
  result.second_from_first.translation *= unit;
  return landmarks;
}

}  // namespace

void TwoViewOptions::Check() const {
  if (!(min_motion >= 0)) throw InputError("min_motion: must not be negative");
  if (!(min_parallax > 0)) throw InputError("min_parallax: has to be positive");
  if (!(min_parallax_deg > 0)) throw InputError("min_parallax_deg: has to be positive");
  if (!(max_epipolar_error > 0)) throw InputError("max_epipolar_error: has to be positive");
  if (min_landmarks < 8) throw InputError("min_landmarks: has to be at least 8");
  if (!(min_landmark_share >= 0 && min_landmark_share <= 1)) throw InputError("min_landmark_share: has to be in 0...1");
  if (fewest_landmarks < 8 || fewest_landmarks > min_landmarks)
    throw InputError("fewest_landmarks: has to be from 8 to min_landmarks");
  if (!(min_inlier_share >= 0 && min_inlier_share <= 1)) throw InputError("min_inlier_share: has to be in 0...1");
  if (!(min_cell_share >= 0 && min_cell_share <= 1)) throw InputError("min_cell_share: has to be in 0...1");
  if (!(min_landmark_parallax_deg > 0)) throw InputError("min_landmark_parallax_deg: has to be positive");
  if (!(initial_baseline > 0 && std::isfinite(initial_baseline)))
    throw InputError("initial_baseline: has to be a positive number");
}

bool IsScene(const TwoViewOptions& options, const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels,
             const std::vector<char>& is_counted) {
  return ShareOfCells(pinhole, pixels, is_counted, is_counted) >= options.min_cell_share;
}

TwoViewResult InitializeFromTwoViews(const TwoViewOptions& options, const Pinhole& pinhole,
                                     const std::vector<Eigen::Vector2d>& first,
                                     const std::vector<Eigen::Vector2d>& second, int gone) {
  TwoViewResult result;
  if (static_cast<int>(first.size()) < options.min_landmarks) return result;
  result.motion = MedianMotion(first, second);
  if (result.motion < options.min_motion) {
    result.status = TwoViewStatus::kStandstill;
    return result;
  }
  const std::vector<Eigen::Vector3d> first_rays = Rays(pinhole, first);
  const std::vector<Eigen::Vector3d> second_rays = Rays(pinhole, second);
  const std::vector<double> parallaxes = Parallaxes(pinhole, first_rays, second_rays, second);
  if (!parallaxes.empty()) result.parallax = Quantile(parallaxes, 0.75);
  const double least = LeastParallax(options, pinhole);
  const bool near_have_gone = result.parallax < least && HaveNearGone(options, parallaxes, least, gone);
  if (result.parallax < least && !near_have_gone) {
    result.status = TwoViewStatus::kLowParallax;
    return result;
  }
  const auto [motion, set_aside] = FindSceneMotion(options, pinhole, first, second);
  if (motion.agrees.empty()) return result;
  const size_t matches = first.size() - set_aside;

  // Where most features are far away, too few of those that agree are near enough for a depth.
  const int agreeing = Count(near_have_gone ? motion.agrees : motion.inlier);
  if (!AgreeEnough(options, agreeing, matches)) return result;
  const std::optional<TwoViewGeometry> geometry = AdjustTwoViews(pinhole, motion, first, second);
  if (!geometry) return result;
  const int landmarks = TakeLandmarks(options, pinhole, *geometry, first, second, result);
  if (landmarks >= LandmarksNeeded(options, pinhole, result.parallax, matches))
    result.status = TwoViewStatus::kInitialized;
  result.essential = motion;
  return result;
}

}  // namespace turnscale
