// SPDX-License-Identifier: MIT
#include "turnscale/mapping/essential_motion.h"

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>

namespace turnscale {

EssentialMotion FindEssentialMotion(const std::vector<Eigen::Vector3d>& first,
                                    const std::vector<Eigen::Vector3d>& second, double max_error) {
  std::vector<cv::Point2d> a;
  std::vector<cv::Point2d> b;
  for (size_t i = 0; i < first.size(); ++i) {
    a.emplace_back(first[i].x(), first[i].y());
    b.emplace_back(second[i].x(), second[i].y());
  }
  constexpr double kConfidence = 0.9999;
  cv::Mat mask;
  const cv::Mat identity = cv::Mat::eye(3, 3, CV_64F);
  const cv::Mat essential = cv::findEssentialMat(a, b, identity, cv::RANSAC, kConfidence, max_error, mask);
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
  motion.inlier.assign(mask.begin<uchar>(), mask.end<uchar>());
  return motion;
}

}  // namespace turnscale
