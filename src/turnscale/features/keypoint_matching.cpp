// SPDX-License-Identifier: MIT
#include "turnscale/features/keypoint_matching.h"

#include <opencv2/features2d.hpp>

#include "turnscale/base/check_part.h"

namespace turnscale {
namespace {

struct DescribedKeypoints {
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;  // one row per point
};

DescribedKeypoints Describe(const KeypointOptions& options, const cv::Mat& gray, const cv::Mat& mask) {
  DescribedKeypoints keypoints;
  constexpr int kLayersPerOctave = 3;
  cv::SIFT::create(options.max_keypoints, kLayersPerOctave, options.min_contrast)
      ->detectAndCompute(gray, mask, keypoints.points, keypoints.descriptors);
  return keypoints;
}

// The best match in `to` of each point of `from` that is clearly better than the second best; without crossing.
std::vector<cv::DMatch> ClearMatches(const KeypointOptions& options, const cv::Mat& from, const cv::Mat& to) {
  std::vector<std::vector<cv::DMatch>> nearest;
  cv::BFMatcher(cv::NORM_L2).knnMatch(from, to, nearest, 2);
  std::vector<cv::DMatch> clear;
  for (const std::vector<cv::DMatch>& two : nearest)
    if (two.size() == 2 && two[0].distance < options.max_distance_ratio * two[1].distance) clear.push_back(two[0]);
  return clear;
}

}  // namespace

void KeypointOptions::Check() const {
  Require(max_keypoints >= 1, "max_keypoints: has to be at least 1");
  Require(min_contrast > 0 && min_contrast < 1, "min_contrast: has to be above 0 and below 1");
  Require(max_distance_ratio > 0 && max_distance_ratio <= 1, "max_distance_ratio: has to be above 0 and up to 1");
}

std::vector<KeypointMatch> MatchKeypoints(const KeypointOptions& options, const cv::Mat& first, const cv::Mat& second,
                                          const cv::Mat& mask) {
  const DescribedKeypoints a = Describe(options, first, mask);
  const DescribedKeypoints b = Describe(options, second, mask);
  // The ratio test needs two candidates.
  if (a.points.size() < 2 || b.points.size() < 2) return {};
  const std::vector<cv::DMatch> clear = ClearMatches(options, a.descriptors, b.descriptors);
  if (clear.empty()) return {};
  cv::Mat matched;
  for (const cv::DMatch& match : clear) matched.push_back(b.descriptors.row(match.trainIdx));
  std::vector<cv::DMatch> back;
  cv::BFMatcher(cv::NORM_L2).match(matched, a.descriptors, back);
  std::vector<KeypointMatch> matches;
  for (size_t i = 0; i < clear.size(); ++i)
    if (back[i].trainIdx == clear[i].queryIdx)
      matches.push_back({a.points[clear[i].queryIdx].pt, b.points[clear[i].trainIdx].pt});
  return matches;
}

}  // namespace turnscale
