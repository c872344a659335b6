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

// A pixel as a point on the plane z = 1 by the pinhole alone, and its ray there.
struct RayPair {
  Eigen::Vector2d shown;
  Eigen::Vector2d ray;
};

struct Fit {
  CameraModel camera;
  double error = 0;  ///< largest over the image, pixels
};

std::vector<Eigen::Vector2d> GridOver(int width, int height) {
  std::vector<Eigen::Vector2d> pixels;
  for (int row = 0; row <= kRows; ++row)
    for (int column = 0; column <= kColumns; ++column)
      pixels.emplace_back((width - 1.0) * column / kColumns, (height - 1.0) * row / kRows);
  return pixels;
}

// Coefficients k of shown = base (1 + k1 base^2 + k2 base^4 + ...), by least squares.
std::array<double, 5> FitSeries(const std::vector<RayPair>& pairs, int terms,
                                const std::function<double(double)>& base_of_ray) {
  const auto rows = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXd A(rows, terms);
  Eigen::VectorXd b(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double base = base_of_ray(pairs[i].ray.norm());
    double power = base;
    for (int term = 0; term < terms; ++term) A(i, term) = power *= base * base;
    b[i] = pairs[i].shown.norm() - base;
  }
  const Eigen::VectorXd k = A.colPivHouseholderQr().solve(b);
  std::array<double, 5> coefficients = {0, 0, 0, 0, 0};
  std::copy(k.begin(), k.end(), coefficients.begin());
  return coefficients;
}

// All coefficients of the radial-tangential model, by least squares.
std::array<double, 5> FitRadialTangential(const std::vector<RayPair>& pairs) {
  Eigen::MatrixXd A(2 * static_cast<Eigen::Index>(pairs.size()), 5);
  Eigen::VectorXd b(A.rows());
  for (size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector2d& ray = pairs[i].ray;
    const double square = ray.squaredNorm();
    const Eigen::Matrix2d across = square * Eigen::Matrix2d::Identity() + 2 * ray * ray.transpose();
    const auto row = 2 * static_cast<Eigen::Index>(i);
    A.middleRows<2>(row) << square * ray, square * square * ray, across.col(1), across.col(0),
        square * square * square * ray;
    b.segment<2>(row) = pairs[i].shown - ray;
  }
  const Eigen::VectorXd k = A.colPivHouseholderQr().solve(b);
  std::array<double, 5> coefficients = {0, 0, 0, 0, 0};
  std::copy(k.begin(), k.end(), coefficients.begin());
  return coefficients;
}

// Largest distance of a pixel from the line through the principal point along its ray, on the plane z = 1.
double LargestAcross(const std::vector<RayPair>& pairs) {
  double largest = 0;
  for (const auto& [shown, ray] : pairs)
    if (ray.norm() > 0) largest = std::max(largest, std::abs(shown.x() * ray.y() - shown.y() * ray.x()) / ray.norm());
  return largest;
}

}  // namespace

std::optional<CameraModel> FitLens(const Pinhole& pinhole, int width, int height, const RayOfPixel& ray_of) {
  const double focal = std::sqrt(pinhole.fx * pinhole.fy);
  std::vector<RayPair> pairs;
  const std::vector<Eigen::Vector2d> grid = GridOver(width, height);
  for (const Eigen::Vector2d& pixel : grid)
    if (const std::optional<Eigen::Vector2d> ray = ray_of(pixel); ray && ray->allFinite())
      pairs.push_back({pinhole.Ray(pixel).head<2>(), *ray});
  if (pairs.size() < grid.size() / 2) return std::nullopt;
  double largest = 0;
  for (const RayPair& pair : pairs) largest = std::max(largest, pair.ray.norm());

  const auto error_of = [&](const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& shown_of_ray) {
    double error = 0;
    for (const auto& [shown, ray] : pairs) error = std::max(error, focal * (shown_of_ray(ray) - shown).norm());
    return error;
  };
  const CameraModel plain{pinhole, LensModel::kPinhole, {0, 0, 0, 0, 0}, width, height};
  if (error_of([](const Eigen::Vector2d& ray) { return ray; }) < kNoDistortion) return plain;

  std::optional<Fit> best;
  const auto consider = [&](LensModel lens, const std::array<double, 5>& k) {
    const double error = error_of([&](const Eigen::Vector2d& ray) -> Eigen::Vector2d {
      if (lens == LensModel::kRadialTangential) return DistortRadialTangential(k, ray).point;
      const double length = ray.norm();
      return length > 0 ? Eigen::Vector2d(DistortAngle(k, std::atan(length)) / length * ray) : ray;
    });
    if (best && best->error <= error) return;
    best = {plain, error};
    best->camera.lens = lens;
    best->camera.distortion = k;
  };
  const std::array<double, 5> radial = FitSeries(pairs, 2, [](double ray) { return ray; });
  if (RadialRisesUpTo(radial, largest)) consider(LensModel::kRadialTangential, radial);
  // Two coefficients that all programs know are preferred to a fit that no image can tell from theirs.
  if (best && best->error < kSmallError) return best->camera;
  const std::array<double, 5> fisheye = FitSeries(pairs, 3, [](double ray) { return std::atan(ray); });
  if (AngleRisesUpTo(fisheye, std::atan(largest))) consider(LensModel::kEquidistant, fisheye);
  if (focal * LargestAcross(pairs) > kNoDistortion) {
    const std::array<double, 5> all = FitRadialTangential(pairs);
    if (RadialRisesUpTo(all, largest)) consider(LensModel::kRadialTangential, all);
  }
  return best ? std::optional(best->camera) : std::nullopt;
}

}  // namespace turnscale
