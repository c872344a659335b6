// SPDX-License-Identifier: MIT
#include "turnscale/road/road_patches.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

#include "turnscale/base/check_part.h"

namespace turnscale {
namespace {

// Of an image whose side is halved: pixel (x, y) shows what pixel (2x, 2y) of the full one does.
double Shrink(int size) { return size == 0 ? 1.0 : 0.5; }

const cv::Mat& AtSize(const RoadImage& image, int size) { return size == 0 ? image.gray : image.half; }

std::optional<Eigen::Vector2d> ProjectTo(const RoadPair& pair, const Eigen::Vector3d& x, int size) {
  if (!(x.z() > 0)) return std::nullopt;
  const std::optional<Eigen::Vector2d> pixel = pair.camera.Project(x);
  return pixel ? std::optional<Eigen::Vector2d>(Shrink(size) * *pixel) : std::nullopt;
}

std::optional<Eigen::Vector3d> RayOf(const RoadPair& pair, const Eigen::Vector2d& pixel, int size) {
  const std::optional<Eigen::Vector2d> ideal = pair.camera.Undistort(pixel / Shrink(size));
  return ideal ? std::optional<Eigen::Vector3d>(pair.camera.pinhole.Ray(*ideal)) : std::nullopt;
}

bool IsInside(const cv::Mat& image, const Eigen::Vector2d& pixel, double margin) {
  return pixel.x() >= margin && pixel.y() >= margin && pixel.x() < image.cols - 1 - margin &&
         pixel.y() < image.rows - 1 - margin;
}

// Whether the mask leaves out a pixel of the box that reaches so far around `centre`.
bool IsMasked(const RoadPair& pair, const Eigen::Vector2d& centre, const Eigen::Vector2d& reach, int size) {
  if (pair.mask.empty()) return false;
  const Eigen::Vector2d first = (centre - reach) / Shrink(size);
  const Eigen::Vector2d last = (centre + reach) / Shrink(size);
  const cv::Rect box = cv::Rect(cv::Point(cvFloor(first.x()), cvFloor(first.y())),
                                cv::Point(cvCeil(last.x()) + 1, cvCeil(last.y()) + 1)) &
                       cv::Rect({}, pair.mask.size());
  return cv::countNonZero(pair.mask(box)) < box.area();
}

float GrayAt(const cv::Mat& image, const Eigen::Vector2d& pixel) {
  const int left = static_cast<int>(pixel.x());
  const int top = static_cast<int>(pixel.y());
  const auto x = static_cast<float>(pixel.x() - left);
  const auto y = static_cast<float>(pixel.y() - top);
  const uchar* above = image.ptr<uchar>(top) + left;
  const uchar* below = image.ptr<uchar>(top + 1) + left;
  const auto mix = [x](const uchar* row) {
    return (1 - x) * static_cast<float>(row[0]) + x * static_cast<float>(row[1]);
  };
  return (1 - y) * mix(above) + y * mix(below);
}

// Where a point of the road, in heights, is in the current image.
std::optional<Eigen::Vector2d> PixelOnRoad(const RoadPair& pair, const RoadRegion& region, double side, double ahead,
                                           int size) {
  const double middle = region.direction * ahead + 0.5 * region.curvature * ahead * ahead;
  return ProjectTo(pair, region.level_from_camera.transpose() * Eigen::Vector3d(middle + side, 1, ahead), size);
}

// The pixel of a cell with the largest derivative along `direction`, in steps of two pixels.
std::optional<cv::Point> MostTexture(const cv::Mat& image, const cv::Rect& cell, const Eigen::Vector2d& direction) {
  std::optional<cv::Point> best;
  double most = 0;
  for (int y = cell.y; y < cell.y + cell.height; y += 2) {
    const uchar* above = image.ptr<uchar>(y - 2);
    const uchar* row = image.ptr<uchar>(y);
    const uchar* below = image.ptr<uchar>(y + 2);
    for (int x = cell.x; x < cell.x + cell.width; x += 2) {
      const double change = std::abs(direction.x() * (row[x + 2] - row[x - 2]) + direction.y() * (below[x] - above[x]));
      if (change <= most) continue;
      most = change;
      best = cv::Point(x, y);
    }
  }
  return best;
}

std::optional<RoadPatch> PatchAt(const RoadPatchOptions& options, const RoadPair& pair, const cv::Point& centre,
                                 int size) {
  const int half = options.half_size;
  const cv::Mat& image = AtSize(pair.current, size);
  const Eigen::Vector2d pixel(centre.x, centre.y);
  const std::optional<Eigen::Vector3d> ray = RayOf(pair, pixel, size);
  const std::optional<Eigen::Vector3d> right = RayOf(pair, pixel + Eigen::Vector2d(half, 0), size);
  const std::optional<Eigen::Vector3d> down = RayOf(pair, pixel + Eigen::Vector2d(0, half), size);
  if (!ray || !right || !down) return std::nullopt;
  const int side = 2 * half + 1;
  RoadPatch patch;
  patch.ray = *ray;
  patch.ray_by_step << *right - *ray, *down - *ray;
  patch.gray.resize(side * side);
  patch.gray_x.resize(side * side);
  patch.gray_y.resize(side * side);
  for (int i = 0, y = centre.y - half; y <= centre.y + half; ++y) {
    const uchar* above = image.ptr<uchar>(y - 1);
    const uchar* row = image.ptr<uchar>(y);
    const uchar* below = image.ptr<uchar>(y + 1);
    for (int x = centre.x - half; x <= centre.x + half; ++x, ++i) {
      patch.gray[i] = row[x];
      patch.gray_x[i] = 0.5F * static_cast<float>(row[x + 1] - row[x - 1]);
      patch.gray_y[i] = 0.5F * static_cast<float>(below[x] - above[x]);
    }
  }
  patch.gray -= patch.gray.mean();
  const float norm = std::sqrt(patch.gray.square().sum());
  if (!(norm >= options.least_contrast * side)) return std::nullopt;
  patch.contrast = norm;
  patch.gray /= norm;
  patch.gray_x /= norm;
  patch.gray_y /= norm;
  return patch;
}

}  // namespace

// With lengths in heights and a vertical curvature k, a ray of slope v meets the road at the distance z where
// v z = 1 + k z^2 / 2: for a small curvature 1/z = v - k / (2 v).
double RoadSurface::InverseDepth(const Eigen::Vector3d& ray) const {
  const double flat = plane.dot(ray);
  return flat > 0 ? flat - 0.5 * vertical_curvature * plane.squaredNorm() / flat : 0.0;
}

Eigen::Vector4d RoadSurface::ByParameters(const Eigen::Vector3d& ray) const {
  const double flat = plane.dot(ray);
  const double squared = plane.squaredNorm();
  Eigen::Vector4d by;
  by << ray + 0.5 * vertical_curvature * (squared / (flat * flat) * ray - 2 / flat * plane), -0.5 * squared / flat;
  return by;
}

void RoadPatchOptions::Check() const {
  Require(half_width > 0, "half_width: has to be positive");
  Require(nearest > 0, "nearest: has to be positive");
  Require(farthest > nearest, "farthest: has to be above `nearest`");
  Require(rows > 0, "rows: has to be at least 1");
  Require(columns > 0, "columns: has to be at least 1");
  Require(half_size >= 2 && half_size <= 20, "half_size: has to be in 2...20 pixels");
  Require(least_contrast > 0, "least_contrast: has to be positive");
  Require(image_noise > 0, "image_noise: has to be positive");
  Require(least_pixel_sigma > 0, "least_pixel_sigma: has to be positive");
}

std::vector<RoadPatch> SelectRoadPatches(const RoadPatchOptions& options, const RoadPair& pair,
                                         const RoadRegion& region, int size) {
  const cv::Mat& image = AtSize(pair.current, size);
  const int margin = options.half_size + 2;
  const cv::Rect inside(margin, margin, image.cols - 2 * margin, image.rows - 2 * margin);
  const auto epipole = ProjectTo(pair, region.level_from_camera.transpose().col(2), size);
  std::vector<RoadPatch> patches;
  if (!epipole || inside.width <= 0 || inside.height <= 0) return patches;
  // Rows of equal height in the image, from the near end of what is in it: found to within a row.
  constexpr double kNearRatio = 1.05;
  // Beyond it the region is a strip of a few pixels, too narrow for rows of their own.
  constexpr double kMostNear = 0.8;
  double near = options.nearest;
  while (near < options.farthest) {
    const auto pixel = PixelOnRoad(pair, region, 0, near, size);
    if (pixel && pixel->y() < image.rows - margin) break;
    near *= kNearRatio;
  }
  if (near >= kMostNear * options.farthest) return patches;
  const auto ahead = [&](int row) {
    const double share = static_cast<double>(row) / options.rows;
    return 1 / ((1 - share) / near + share / options.farthest);
  };
  for (int row = 0; row < options.rows; ++row) {
    for (int column = 0; column < options.columns; ++column) {
      const auto side = [&](int border) { return options.half_width * (2.0 * border / options.columns - 1); };
      const auto a = PixelOnRoad(pair, region, side(column), ahead(row), size);
      const auto b = PixelOnRoad(pair, region, side(column + 1), ahead(row + 1), size);
      if (!a || !b || !a->allFinite() || !b->allFinite()) continue;
      // Far outside of any image, and still an integer.
      constexpr double kMostPixel = 1e5;
      if (a->cwiseAbs().maxCoeff() > kMostPixel || b->cwiseAbs().maxCoeff() > kMostPixel) continue;
      const cv::Rect cell(
          cv::Point(static_cast<int>(std::min(a->x(), b->x())), static_cast<int>(std::min(a->y(), b->y()))),
          cv::Point(static_cast<int>(std::max(a->x(), b->x())) + 1, static_cast<int>(std::max(a->y(), b->y())) + 1));
      const Eigen::Vector2d direction = (0.5 * (*a + *b) - *epipole).normalized();
      const auto centre = MostTexture(image, cell & inside, direction);
      // With the pixels next to the patch, of which its gradients are.
      const Eigen::Vector2d reach = Eigen::Vector2d::Constant(options.half_size + 1);
      if (!centre || IsMasked(pair, {centre->x, centre->y}, reach, size)) continue;
      if (auto patch = PatchAt(options, pair, *centre, size)) patches.push_back(std::move(*patch));
    }
  }
  return patches;
}

std::optional<PatchMatch> MatchPatch(const RoadPatchOptions& options, const RoadPair& pair, const RoadPatch& patch,
                                     const RoadSurface& surface, int size) {
  const cv::Mat& image = AtSize(pair.earlier, size);
  const RigidTransform& motion = pair.earlier_from_current;
  const auto pixel_of = [&](const Eigen::Vector3d& ray, double inverse_depth) {
    return ProjectTo(pair, motion.rotation * ray + inverse_depth * motion.translation, size);
  };
  const double inverse_depth = surface.InverseDepth(patch.ray);
  if (!(inverse_depth > 0)) return std::nullopt;
  // Of the numeric derivative: 1 % of the parallax, which is a fraction of a pixel.
  const double step = 0.01 * inverse_depth;
  const auto centre = pixel_of(patch.ray, inverse_depth);
  const auto nearer = pixel_of(patch.ray, inverse_depth + step);
  if (!centre || !nearer) return std::nullopt;
  Eigen::Matrix2d earlier_from_current;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector3d offset = patch.ray_by_step.col(axis);
    const auto ahead = pixel_of(patch.ray + offset, surface.InverseDepth(patch.ray + offset));
    const auto back = pixel_of(patch.ray - offset, surface.InverseDepth(patch.ray - offset));
    if (!ahead || !back) return std::nullopt;
    earlier_from_current.col(axis) = (*ahead - *back) / (2.0 * options.half_size);
  }
  const Eigen::Vector2d reach = (options.half_size * earlier_from_current.cwiseAbs().rowwise().sum()).array() + 1;
  if (!reach.allFinite() || !IsInside(image, *centre, reach.maxCoeff()) || IsMasked(pair, *centre, reach, size))
    return std::nullopt;
  const Eigen::Vector2d by_inverse_depth = (*nearer - *centre) / step;
  const double determinant = earlier_from_current.determinant();
  // Shrunk to a thirtieth of its side, or mirrored: no view of the road.
  constexpr double kLeastArea = 1e-3;
  if (!(determinant > kLeastArea)) return std::nullopt;
  const Eigen::Vector2d moved = earlier_from_current.inverse() * by_inverse_depth;

  const int half = options.half_size;
  Eigen::ArrayXf seen(patch.gray.size());
  for (int i = 0, y = -half; y <= half; ++y)
    for (int x = -half; x <= half; ++x, ++i)
      seen[i] = GrayAt(image, *centre + earlier_from_current * Eigen::Vector2d(x, y));
  seen -= seen.mean();
  const float norm = std::sqrt(seen.square().sum());
  if (!(norm > 0)) return std::nullopt;
  seen /= norm;
  // Free gain and offset: only the part orthogonal to the patch and to a constant depends on its position.
  Eigen::ArrayXf slope = static_cast<float>(moved.x()) * patch.gray_x + static_cast<float>(moved.y()) * patch.gray_y;
  slope -= slope.mean();
  slope -= (slope * patch.gray).sum() * patch.gray;
  const double squares = slope.square().sum();
  const double motion_squares = by_inverse_depth.squaredNorm();
  // Rounding errors: without texture along the motion the patch shows no depth.
  constexpr double kRounding = 1e-12;
  if (!(squares > kRounding * motion_squares) || !(motion_squares > 0)) return std::nullopt;
  PatchMatch match;
  match.correlation = (seen * patch.gray).sum();
  match.inverse_depth_change = -static_cast<double>((slope * (seen - patch.gray)).sum()) / squares;
  const double noise = options.image_noise / patch.contrast;
  match.variance = noise * noise / squares + options.least_pixel_sigma * options.least_pixel_sigma / motion_squares;
  return match;
}

std::optional<Eigen::Matrix<double, 1, 6>> InverseDepthChangeByMotion(const RoadPair& pair, const Eigen::Vector3d& ray,
                                                                      const RoadSurface& surface) {
  const double inverse_depth = surface.InverseDepth(ray);
  if (!(inverse_depth > 0)) return std::nullopt;
  const RigidTransform& motion = pair.earlier_from_current;
  const Eigen::Vector3d turned = motion.rotation * ray;
  const Eigen::Vector3d point = turned + inverse_depth * motion.translation;
  const auto pixel = ProjectTo(pair, point, 0);
  if (!pixel) return std::nullopt;
  // Of the numeric derivatives: a thousandth of the focal length in the image.
  const double step = 1e-3 * point.z();
  Eigen::Matrix<double, 2, 3> by_point;
  for (int axis = 0; axis < 3; ++axis) {
    const auto moved = ProjectTo(pair, point + step * Eigen::Vector3d::Unit(axis), 0);
    if (!moved) return std::nullopt;
    by_point.col(axis) = (*moved - *pixel) / step;
  }
  const Eigen::Vector2d by_inverse_depth = by_point * motion.translation;
  const double squares = by_inverse_depth.squaredNorm();
  if (!(squares > 0)) return std::nullopt;
  const Eigen::RowVector3d along = -by_inverse_depth.transpose() * by_point / squares;
  Eigen::Matrix<double, 1, 6> by_motion;
  by_motion << turned.cross(along.transpose()).transpose(), inverse_depth * along;
  return by_motion;
}

}  // namespace turnscale
