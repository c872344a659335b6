// SPDX-License-Identifier: MIT
#include "turnscale/mapping/essential_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>

#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/geometry/triangulation.h"

namespace turnscale {
namespace {

// Any four matches agree with a homography.
constexpr std::size_t kFewestOfPlane = 5;

std::vector<cv::Point2d> AsPoints(const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<cv::Point2d> points;
  for (const Eigen::Vector2d& pixel : pixels) points.emplace_back(pixel.x(), pixel.y());
  return points;
}

std::vector<cv::Point2d> AtDepthOne(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<cv::Point2d> points;
  for (const Eigen::Vector2d& pixel : pixels) {
    const Eigen::Vector3d ray = pinhole.Ray(pixel);
    points.emplace_back(ray.x(), ray.y());
  }
  return points;
}

std::vector<char> FlagsOf(const cv::Mat& mask) {
  std::vector<char> flags;
  for (const uchar flag : cv::Mat_<uchar>(mask)) flags.push_back(flag != 0 ? 1 : 0);
  return flags;
}

std::vector<cv::Point2d> InliersOf(const EssentialMotion& motion, const std::vector<cv::Point2d>& points) {
  std::vector<cv::Point2d> inliers;
  for (std::size_t i = 0; i < motion.inlier.size(); ++i)
    if (motion.inlier[i] != 0) inliers.push_back(points[i]);
  return inliers;
}

// The homography with which most matches agree.
struct PlaneFit {
  cv::Mat homography;  // 3x3, second from first; empty if there is none
  double share = 0;    // of the matches that agree
};

PlaneFit FitPlane(const std::vector<cv::Point2d>& first, const std::vector<cv::Point2d>& second, double max_error) {
  cv::Mat mask;
  PlaneFit fit{.homography = cv::findHomography(first, second, cv::RANSAC, max_error, mask)};
  if (!fit.homography.empty())
    fit.share = static_cast<double>(cv::countNonZero(mask)) / static_cast<double>(first.size());
  return fit;
}

// Whether the camera sees the side of the plane with this normal wherever the points are.
bool IsBefore(const cv::Mat& normal, const std::vector<cv::Point2d>& points) {
  const cv::Point3d n(normal.at<double>(0), normal.at<double>(1), normal.at<double>(2));
  const auto before = std::ranges::count_if(points, [&](const cv::Point2d& x) { return n.dot({x.x, x.y, 1}) > 0; });
  return 2 * before > static_cast<std::ptrdiff_t>(points.size());
}

}  // namespace

EssentialMotion FindEssentialMotion(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& first,
                                    const std::vector<Eigen::Vector2d>& second, double max_error) {
  const std::vector<cv::Point2d> a = AtDepthOne(pinhole, first);
  const std::vector<cv::Point2d> b = AtDepthOne(pinhole, second);
  constexpr double kConfidence = 0.9999;
  cv::Mat mask;
  const cv::Mat identity = cv::Mat::eye(3, 3, CV_64F);
  const cv::Mat essential = cv::findEssentialMat(a, b, identity, cv::RANSAC, kConfidence, max_error / pinhole.fx, mask);
  EssentialMotion motion;
  if (essential.rows != 3) return motion;
  motion.agrees = FlagsOf(mask);
  cv::Mat rotation;
  cv::Mat translation;
  // Points farther than this many baselines do not decide which of the four motions is right.
  constexpr double kFarthest = 500;
  cv::recoverPose(essential, a, b, identity, rotation, translation, kFarthest, mask);
  Eigen::Matrix3d R;
  cv::cv2eigen(rotation, R);
  motion.second_from_first.rotation = Eigen::Quaterniond(R).normalized();
  motion.second_from_first.translation = {translation.at<double>(0), translation.at<double>(1),
                                          translation.at<double>(2)};
  motion.inlier = FlagsOf(mask);
  return motion;
}

double ShareOnPlane(const EssentialMotion& motion, const std::vector<Eigen::Vector2d>& first,
                    const std::vector<Eigen::Vector2d>& second, double max_error) {
  const std::vector<cv::Point2d> a = InliersOf(motion, AsPoints(first));
  const std::vector<cv::Point2d> b = InliersOf(motion, AsPoints(second));
  return a.size() < kFewestOfPlane ? 1 : FitPlane(a, b, max_error).share;
}

bool MayBePassingVehicle(const Pinhole& pinhole, const EssentialMotion& motion,
                         const std::vector<Eigen::Vector2d>& first, const std::vector<Eigen::Vector2d>& second,
                         double max_error, const Eigen::Quaterniond& vehicle_from_camera) {
  constexpr double kNearlyAll = 0.9;
  constexpr double kSideways = 0.7;  // share of the motion along the x axis
  const std::vector<cv::Point2d> a = InliersOf(motion, AtDepthOne(pinhole, first));
  const std::vector<cv::Point2d> b = InliersOf(motion, AtDepthOne(pinhole, second));
  if (a.size() < kFewestOfPlane) return false;
  const PlaneFit plane = FitPlane(a, b, max_error / pinhole.fx);
  if (plane.share < kNearlyAll) return false;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  std::vector<cv::Mat> normals;
  const int motions =
      cv::decomposeHomographyMat(plane.homography, cv::Mat::eye(3, 3, CV_64F), rotations, translations, normals);
  for (int i = 0; i < motions; ++i) {
    const cv::Mat in_camera = rotations[i].t() * translations[i];
    const Eigen::Vector3d travel =
        vehicle_from_camera *
        Eigen::Vector3d(in_camera.at<double>(0), in_camera.at<double>(1), in_camera.at<double>(2));
    if (IsBefore(normals[i], a) && std::abs(travel.x()) > kSideways * travel.norm()) return true;
  }
  return false;
}

std::optional<TwoViewGeometry> AdjustTwoViews(const Pinhole& pinhole, const EssentialMotion& motion,
                                              const std::vector<Eigen::Vector2d>& first,
                                              const std::vector<Eigen::Vector2d>& second) {
  BundleProblem problem;
  problem.pinhole = pinhole;
  problem.camera_from_world = {RigidTransform{}, motion.second_from_first};
  problem.camera_is_fixed = {1, 0};
  TwoViewGeometry geometry;
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (motion.inlier[i] == 0) continue;
    const std::array<CameraRay, 2> rays = {CameraRay{problem.camera_from_world[0], pinhole.Ray(first[i])},
                                           CameraRay{problem.camera_from_world[1], pinhole.Ray(second[i])}};
    const std::optional<Eigen::Vector3d> x = Triangulate(rays);
    if (!x) continue;
    const int point = static_cast<int>(problem.points.size());
    problem.points.push_back(*x);
    problem.observations.push_back({0, point, first[i], 1.0});
    problem.observations.push_back({1, point, second[i], 1.0});
    geometry.match_of_point.push_back(i);
  }
  if (problem.points.empty()) return std::nullopt;
  const BundleOptions options;
  if (!TryAdjustBundle(options, problem)) return std::nullopt;
  geometry.second_from_first = problem.camera_from_world[1];
  geometry.points = std::move(problem.points);
  return geometry;
}

}  // namespace turnscale
