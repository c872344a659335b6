// SPDX-License-Identifier: MIT
#include "turnscale/features/keypoint_matching.h"

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/check_part.h"

namespace turnscale {
namespace {

// The best match in `to` of each point of `from` that is clearly better than the second best.
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
  Require(max_width >= 100, "max_width: has to be at least 100");
  Require(max_distance_ratio > 0 && max_distance_ratio <= 1, "max_distance_ratio: has to be above 0 and up to 1");
}

DescribedKeypoints DescribeKeypoints(const KeypointOptions& options, const cv::Mat& gray, const cv::Mat& mask) {
  constexpr int kLayersPerOctave = 3;
  DescribedKeypoints described;
  cv::Mat image = gray;
  cv::Mat kept = mask;
  while (image.cols > options.max_width) {
    const cv::Size half(image.cols / 2, image.rows / 2);
    described.scale *= 2;
    cv::resize(image, image, half, 0, 0, cv::INTER_AREA);
    if (!kept.empty()) cv::resize(kept, kept, half, 0, 0, cv::INTER_NEAREST);
  }
  std::vector<cv::KeyPoint> points;
  cv::SIFT::create(options.max_keypoints, kLayersPerOctave, options.min_contrast)
      ->detectAndCompute(image, kept, points, described.descriptors);
  // The centre of a pixel has whole coordinates.
  const auto in_image = [&](float x) { return static_cast<float>((x + 0.5) * described.scale - 0.5); };
  for (const cv::KeyPoint& point : points) described.pixels.emplace_back(in_image(point.pt.x), in_image(point.pt.y));
  return described;
}

std::vector<KeypointMatch> MatchKeypoints(const KeypointOptions& options, const DescribedKeypoints& first,
                                          const DescribedKeypoints& second) {
  // The ratio test needs two candidates.
  if (first.pixels.size() < 2 || second.pixels.size() < 2) return {};
  const std::vector<cv::DMatch> clear = ClearMatches(options, first.descriptors, second.descriptors);
  if (clear.empty()) return {};
  cv::Mat matched;
  for (const cv::DMatch& match : clear) matched.push_back(second.descriptors.row(match.trainIdx));
  std::vector<cv::DMatch> back;
  cv::BFMatcher(cv::NORM_L2).match(matched, first.descriptors, back);
  std::vector<KeypointMatch> matches;
  for (size_t i = 0; i < clear.size(); ++i)
    if (back[i].trainIdx == clear[i].queryIdx)
      matches.push_back({first.pixels[clear[i].queryIdx], second.pixels[clear[i].trainIdx]});
  return matches;
}

}  // namespace turnscale
