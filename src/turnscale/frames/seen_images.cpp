// SPDX-License-Identifier: MIT
#include "turnscale/frames/seen_images.h"

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

const cv::Size kSmall = {64, 48};
constexpr double kComparedAfter = 1;  // s
constexpr double kDark = 25;          // of 255
constexpr double kFlat = 6;           // of 255
constexpr double kStill = 1.5;        // of 255, with the noise of small images far below
constexpr double kFewTracked = 60;
constexpr double kShort = 2;             // s
constexpr double kLittleLeft = 1.0 / 3;  // of the image

}  // namespace

void SeenImages::Add(const cv::Mat& gray, double time, int tracked) {
  cv::Mat small;
  cv::resize(gray, small, kSmall, 0, 0, cv::INTER_AREA);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(small, mean, deviation);
  if (brightness_.empty()) first_time_ = time;
  last_time_ = time;
  brightness_.push_back(mean[0]);
  contrast_.push_back(deviation[0]);
  if (brightness_.size() > 1) tracked_.push_back(tracked);
  if (!compared_.empty() && time - compared_time_ < kComparedAfter) return;
  if (!compared_.empty())
    changes_.push_back(cv::norm(small, compared_, cv::NORM_L1) / static_cast<double>(small.total()));
  compared_ = small;
  compared_time_ = time;
}

std::string SeenImages::Explanation(const LeftByOptions& left) const {
  if (brightness_.empty()) return "no image could be read";
  std::string cause = Cause(left);
  if (cause.empty())
    cause = left.part.empty() ? "the drive is too short; give a longer one"
                              : fmt::format("the part of the drive ({}) is too short; widen it", left.part);
  return fmt::format("nothing could be tracked in {} image{} ({:.1f} s): {}", brightness_.size(),
                     brightness_.size() == 1 ? "" : "s", last_time_ - first_time_, cause);
}

std::string SeenImages::Cause(const LeftByOptions& left) const {
  if (brightness_.empty()) return "";
  if (Median(brightness_) < kDark) return "the images are dark; check the exposure and whether the lens is covered";
  if (Median(contrast_) < kFlat)
    return "the images show hardly any detail; check whether the lens is covered, dirty or out of focus";
  if (Still()) return "the images hardly change, as if the car stood still all along; give a part in which it drives";
  if (last_time_ - first_time_ < kShort) return "";
  const bool is_few = Median(tracked_) < kFewTracked;
  if (is_few && left.mask_share < kLittleLeft)
    return fmt::format("{} leaves only {:.0f} % of the image; leave out less of it", left.mask, 100 * left.mask_share);
  if (is_few)
    return fmt::format(
        "only about {:.0f} points can be followed from image to image; check for blur and rain, and that "
        "no frames are left out",
        Median(tracked_));
  return "the points that are seen do not move as they do from a car that drives; check that the camera looks ahead, "
         "that its calibration is the right one, and that the car drives";
}

bool SeenImages::Still() const {
  return !changes_.empty() && Median(changes_) < kStill && Median(brightness_) >= kDark && Median(contrast_) >= kFlat;
}

}  // namespace turnscale
