// SPDX-License-Identifier: MIT
#include "turnscale/mapping/essential_motion.h"

#include <array>
#include <utility>

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>

#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/geometry/triangulation.h"

namespace turnscale {

EssentialMotion FindEssentialMotion(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& first,
                                    const std::vector<Eigen::Vector2d>& second, double max_error) {
  const auto at_depth_one = [&](const std::vector<Eigen::Vector2d>& pixels) {
    std::vector<cv::Point2d> points;
    for (const Eigen::Vector2d& pixel : pixels) {
      const Eigen::Vector3d ray = pinhole.Ray(pixel);
      points.emplace_back(ray.x(), ray.y());
    }
    return points;
  };
  const std::vector<cv::Point2d> a = at_depth_one(first);
  const std::vector<cv::Point2d> b = at_depth_one(second);
  constexpr double kConfidence = 0.9999;
  cv::Mat mask;
  const cv::Mat identity = cv::Mat::eye(3, 3, CV_64F);
  const cv::Mat essential = cv::findEssentialMat(a, b, identity, cv::RANSAC, kConfidence, max_error / pinhole.fx, mask);
  EssentialMotion motion;
  if (essential.rows != 3) return motion;
  motion.agreeing = cv::countNonZero(mask);
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
  for (const uchar flag : cv::Mat_<uchar>(mask)) motion.inlier.push_back(flag != 0 ? 1 : 0);
  return motion;
}

double ShareOnPlane(const EssentialMotion& motion, const std::vector<Eigen::Vector2d>& first,
                    const std::vector<Eigen::Vector2d>& second, double max_error) {
  constexpr std::size_t kFewest = 5;
  std::vector<cv::Point2d> a;
  std::vector<cv::Point2d> b;
  for (std::size_t i = 0; i < motion.inlier.size(); ++i) {
    if (motion.inlier[i] == 0) continue;
    a.emplace_back(first[i].x(), first[i].y());
    b.emplace_back(second[i].x(), second[i].y());
  }
  // Any four are.
  if (a.size() < kFewest) return 1;
  cv::Mat mask;
  if (cv::findHomography(a, b, cv::RANSAC, max_error, mask).empty()) return 0;
  return static_cast<double>(cv::countNonZero(mask)) / static_cast<double>(a.size());
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
