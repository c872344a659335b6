// SPDX-License-Identifier: MIT
#include "turnscale/io/clip_overlap.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace turnscale {
namespace {

// A grid of so many samples stands for an image.
constexpr int kColumns = 64;
constexpr int kRows = 36;
// Images so far apart in time, seconds, differ by motion: by at least so many gray levels on average, and by so many
// times as much as two compressions of the same image.
constexpr double kApart = 0.3;
constexpr double kLeastMotion = 1.5;
constexpr double kLeastRatio = 2;

std::vector<uint8_t> Samples(const cv::Mat& gray) {
  std::vector<uint8_t> samples;
  samples.reserve(size_t{kColumns} * kRows);
  for (int row = 0; row < kRows; ++row) {
    const auto* pixels = gray.ptr<uint8_t>((2 * row + 1) * gray.rows / (2 * kRows));
    for (int column = 0; column < kColumns; ++column)
      samples.push_back(pixels[(2 * column + 1) * gray.cols / (2 * kColumns)]);
  }
  return samples;
}

// Mean absolute difference, gray levels.
double Difference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  int sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(int{a[i]} - int{b[i]});
  return static_cast<double>(sum) / static_cast<double>(a.size());
}

}  // namespace

void ClipTail::Add(double time, const cv::Mat& gray) {
  images_.push_back({time, Samples(gray)});
  while (time - images_.front().time > kLongestOverlap) images_.pop_front();
}

std::optional<ClipOverlap> ClipTail::RepeatedBy(const std::function<cv::Mat()>& next) const {
  const cv::Mat first = next();
  if (first.empty() || images_.empty()) return std::nullopt;
  const std::vector<uint8_t> samples = Samples(first);
  std::vector<double> differences;
  for (const Image& image : images_) differences.push_back(Difference(image.samples, samples));
  const auto least = std::ranges::min_element(differences);
  const auto begin = static_cast<size_t>(least - differences.begin());
  // A clip that continues the one before is most like its last images.
  if (images_.back().time - images_[begin].time < kApart) return std::nullopt;
  double by_motion = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < images_.size(); ++i)
    if (std::abs(images_[i].time - images_[begin].time) >= kApart) by_motion = std::min(by_motion, differences[i]);
  const double most = by_motion / kLeastRatio;
  if (!std::isfinite(by_motion) || by_motion < kLeastMotion || *least > most) return std::nullopt;

  for (size_t i = begin + 1; i < images_.size(); ++i) {
    const cv::Mat image = next();
    if (image.empty() || Difference(images_[i].samples, Samples(image)) > most) return std::nullopt;
  }
  return ClipOverlap{images_.size() - begin, images_[begin].time};
}

}  // namespace turnscale
