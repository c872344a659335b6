// SPDX-License-Identifier: MIT
#include "turnscale/camera/lens_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/QR>

namespace turnscale {
namespace {

// Pixels: below what tracking resolves.
constexpr double kNoDistortion = 0.1;
constexpr double kSmallError = 0.3;
constexpr int kColumns = 24;
constexpr int kRows = 16;

// A pixel's distance from the principal point in the image and that of its ray on the plane z = 1.
struct RadiusPair {
  double shown = 0;  ///< in focal lengths
  double ray = 0;
};

struct Fit {
  CameraModel camera;
  double error = 0;  ///< largest over the pixels that count, pixels
};

std::vector<Eigen::Vector2d> GridOver(int width, int height) {
  std::vector<Eigen::Vector2d> pixels;
  for (int row = 0; row <= kRows; ++row)
    for (int column = 0; column <= kColumns; ++column)
      pixels.emplace_back((width - 1.0) * column / kColumns, (height - 1.0) * row / kRows);
  return pixels;
}

// Coefficients k of shown = base (1 + k1 base^2 + k2 base^4 + ...), by least squares.
std::array<double, 5> FitSeries(const std::vector<RadiusPair>& pairs, int terms,
                                const std::function<double(double)>& base_of_ray) {
  const auto rows = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXd A(rows, terms);
  Eigen::VectorXd b(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double base = base_of_ray(pairs[i].ray);
    double power = base;
    for (int term = 0; term < terms; ++term) A(i, term) = power *= base * base;
    b[i] = pairs[i].shown - base;
  }
  const Eigen::VectorXd k = A.colPivHouseholderQr().solve(b);
  std::array<double, 5> coefficients = {0, 0, 0, 0, 0};
  std::copy(k.begin(), k.end(), coefficients.begin());
  return coefficients;
}

}  // namespace

std::optional<CameraModel> FitLens(const Pinhole& pinhole, int width, int height, const RayOfPixel& ray_of,
                                   double radius) {
  const double focal = std::sqrt(pinhole.fx * pinhole.fy);
  std::vector<RadiusPair> pairs;
  const std::vector<Eigen::Vector2d> grid = GridOver(width, height);
  size_t rays = 0;
  for (const Eigen::Vector2d& pixel : grid) {
    const std::optional<Eigen::Vector2d> ray = ray_of(pixel);
    if (!ray || !ray->allFinite()) continue;
    ++rays;
    if ((pixel - Eigen::Vector2d(pinhole.cx, pinhole.cy)).norm() <= radius)
      pairs.push_back({pinhole.Ray(pixel).head<2>().norm(), ray->norm()});
  }
  if (rays < grid.size() / 2 || pairs.empty()) return std::nullopt;
  const double largest = std::ranges::max(pairs, {}, &RadiusPair::ray).ray;

  const auto error_of = [&](const auto& shown_of_ray) {
    double error = 0;
    for (const RadiusPair& pair : pairs) error = std::max(error, focal * std::abs(shown_of_ray(pair.ray) - pair.shown));
    return error;
  };
  const CameraModel plain{pinhole, LensModel::kPinhole, {0, 0, 0, 0, 0}, width, height};
  if (error_of([](double ray) { return ray; }) < kNoDistortion) return plain;

  std::optional<Fit> best;
  const auto consider = [&](LensModel lens, const std::array<double, 5>& k, const auto& shown_of_ray) {
    const double error = error_of(shown_of_ray);
    if (best && best->error <= error) return;
    best = {plain, error};
    best->camera.lens = lens;
    best->camera.distortion = k;
  };
  const std::array<double, 5> radial = FitSeries(pairs, 2, [](double ray) { return ray; });
  if (RadialRisesUpTo(radial, largest))
    consider(LensModel::kRadialTangential, radial, [&](double ray) {
      return DistortRadialTangential(radial, {ray, 0}).point.x();
    });
  // Two coefficients that all programs know are preferred to a fit that no image can tell from theirs.
  if (best && best->error < kSmallError) return best->camera;
  const std::array<double, 5> fisheye = FitSeries(pairs, 3, [](double ray) { return std::atan(ray); });
  if (AngleRisesUpTo(fisheye, std::atan(largest)))
    consider(LensModel::kEquidistant, fisheye, [&](double ray) { return DistortAngle(fisheye, std::atan(ray)); });
  return best ? std::optional(best->camera) : std::nullopt;
}

}  // namespace turnscale
