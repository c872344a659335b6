// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// Options that leave a part of the drive, or of its images.
struct LeftByOptions {
  std::string part;       ///< such as "--start 1:30 --end 1:31"; empty: the whole drive
  std::string mask;       ///< such as "--mask bonnet.png"; empty: the whole images
  double mask_share = 1;  ///< of the image that the mask leaves
};

/// What the images of a drive look like as long as there is no map, to say why none begins.
class SeenImages {
 public:
  /// `tracked`: number of features that were tracked into the image.
  void Add(const cv::Mat& gray, double time, int tracked);

  /// Why nothing could be tracked, and what to try: one sentence.
  std::string Explanation(const LeftByOptions& left = {}) const;

  /// The same without the number of images; empty where they are too few to tell.
  std::string Cause(const LeftByOptions& left = {}) const;

  /// Whether the images show something that hardly changes: the car waits.
  bool Still() const;

 private:
  std::vector<double> brightness_;  // mean gray of each image
  std::vector<double> contrast_;    // standard deviation of gray
  std::vector<double> tracked_;
  std::vector<double> changes_;  // mean change of gray in a second
  cv::Mat compared_;             // small image of at least a second before
  double compared_time_ = 0;
  double first_time_ = 0;
  double last_time_ = 0;
};

}  // namespace turnscale
