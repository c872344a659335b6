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
// Five times the coefficients of a radial-tangential lens.
constexpr size_t kFewestPairs = 10;

// A pixel's distance from the principal point in the image and that of its ray on the plane z = 1.
struct RadiusPair {
  double shown = 0;  ///< in focal lengths
  double ray = 0;
};

struct Fit {
  CameraModel camera;
  double error = 0;           ///< largest within the radius, pixels
  bool covers_image = false;  ///< has a ray for every pixel
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
                                   double radius, const std::array<double, 2>& tangential) {
  const bool is_tangential = tangential != std::array<double, 2>{0, 0};
  const auto tangential_shift = [&](const Eigen::Vector2d& ray) -> Eigen::Vector2d {
    return DistortRadialTangential({0, 0, tangential[0], tangential[1], 0}, ray).point - ray;
  };
  const double focal = std::sqrt(pinhole.fx * pinhole.fy);
  const Eigen::Vector2d centre(pinhole.cx, pinhole.cy);
  std::vector<RadiusPair> pairs;
  std::vector<Eigen::Vector2d> grid = GridOver(width, height);
  const Eigen::Vector2d farthest =
      *std::ranges::max_element(grid, {}, [&](const Eigen::Vector2d& pixel) { return (pixel - centre).norm(); });
  std::erase_if(grid, [&](const Eigen::Vector2d& pixel) { return (pixel - centre).norm() > radius; });
  for (const Eigen::Vector2d& pixel : grid)
    if (const std::optional<Eigen::Vector2d> ray = ray_of(pixel); ray && ray->allFinite())
      pairs.push_back({(pinhole.Ray(pixel).head<2>() - tangential_shift(*ray)).norm(), ray->norm()});
  if (pairs.size() < std::max(kFewestPairs, grid.size() / 2)) return std::nullopt;
  const double largest = std::ranges::max(pairs, {}, &RadiusPair::ray).ray;

  const auto error_of = [&](const auto& shown_of_ray) {
    double error = 0;
    for (const RadiusPair& pair : pairs) error = std::max(error, focal * std::abs(shown_of_ray(pair.ray) - pair.shown));
    return error;
  };
  const CameraModel plain{pinhole, LensModel::kPinhole, {0, 0, 0, 0, 0}, width, height};
  if (!is_tangential && error_of([](double ray) { return ray; }) < kNoDistortion) return plain;

  // A fold within the image is only believed where no other model is as good.
  const auto is_better = [](const Fit& one, const Fit& other) {
    const bool both_exact = std::max(one.error, other.error) < kSmallError;
    return both_exact && one.covers_image != other.covers_image ? one.covers_image : one.error < other.error;
  };
  std::optional<Fit> best;
  const auto consider = [&](LensModel lens, const std::array<double, 5>& k, const auto& shown_of_ray) {
    Fit fit{plain, error_of(shown_of_ray)};
    fit.camera.lens = lens;
    fit.camera.distortion = k;
    fit.covers_image = fit.camera.Undistort(farthest).has_value();
    if (!best || is_better(fit, *best)) best = fit;
  };
  const std::array<double, 5> radial = FitSeries(pairs, 2, [](double ray) { return ray; });
  if (RadialRisesUpTo(radial, largest))
    consider(LensModel::kRadialTangential, {radial[0], radial[1], tangential[0], tangential[1], 0}, [&](double ray) {
      return DistortRadialTangential(radial, {ray, 0}).point.x();
    });
  if (is_tangential) return best ? std::optional(best->camera) : FitLens(pinhole, width, height, ray_of, radius);
  // Two coefficients that all programs know are preferred to a fit that no image can tell from theirs.
  if (best && best->error < kSmallError && best->covers_image) return best->camera;
  const std::array<double, 5> fisheye = FitSeries(pairs, 3, [](double ray) { return std::atan(ray); });
  if (AngleRisesUpTo(fisheye, std::atan(largest)))
    consider(LensModel::kEquidistant, fisheye, [&](double ray) { return DistortAngle(fisheye, std::atan(ray)); });
  return best ? std::optional(best->camera) : std::nullopt;
}

}  // namespace turnscale
