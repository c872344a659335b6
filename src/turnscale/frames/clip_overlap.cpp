// SPDX-License-Identifier: MIT
#include "turnscale/frames/clip_overlap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

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
// Blocks of so many samples in either direction are averaged to look for missing images: they differ the more, the
// further a car moves between two images.
constexpr int kBlockSide = 4;
// For missing images, two images differ by so many times as much as any consecutive ones shortly before, seconds. On
// recorded drives at 10 images per second, consecutive images differ by less, and 19 of 20 gaps of a second by more.
constexpr double kLeastJump = 1.5;
constexpr double kShortlyBefore = 1;
// Changes of consecutive images that the compression hides, gray levels.
constexpr double kLeastChange = 0.75;

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

// Relative to their mean: the exposure may change from one clip to the next.
std::vector<double> BlockMeans(const std::vector<uint8_t>& samples) {
  std::vector<double> means(samples.size() / (kBlockSide * kBlockSide));
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column)
      means[(row / kBlockSide) * (kColumns / kBlockSide) + column / kBlockSide] +=
          samples[row * kColumns + column] / double{kBlockSide * kBlockSide};
  const double mean = std::accumulate(means.begin(), means.end(), 0.0) / static_cast<double>(means.size());
  for (double& value : means) value -= mean;
  return means;
}

double Difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / static_cast<double>(a.size());
}

}  // namespace

void ClipTail::Add(const ClipImage& image) {
  images_.push_back({image.time, Samples(image.gray)});
  while (image.time - images_.front().time > kLongestOverlap) images_.pop_front();
}

bool ClipTail::IsMoving() const {
  return !images_.empty() && images_.back().time - images_.front().time >= kApart &&
         Difference(images_.front().samples, images_.back().samples) >= kLeastRatio * kLeastMotion;
}

std::optional<double> ClipTail::RepeatedBy(const std::function<std::optional<ClipImage>()>& next) const {
  if (images_.empty()) return std::nullopt;
  const std::optional<ClipImage> first = next();
  if (!first) return std::nullopt;
  const std::vector<uint8_t> samples = Samples(first->gray);
  std::vector<double> differences;
  for (const Image& image : images_) differences.push_back(Difference(image.samples, samples));
  const auto least = std::ranges::min_element(differences);
  const double begin = images_[least - differences.begin()].time;
  // A clip that continues the one before is most like its last images.
  if (images_.back().time - begin < kApart) return std::nullopt;
  double by_motion = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < images_.size(); ++i)
    if (std::abs(images_[i].time - begin) >= kApart) by_motion = std::min(by_motion, differences[i]);
  const double most = by_motion / kLeastRatio;
  if (by_motion < kLeastMotion || *least > most) return std::nullopt;

  // Either clip may lack some of the images, so that they are compared by their times.
  const auto distance = [&](const Image& image, double time) { return std::abs(image.time - time); };
  for (auto nearest = images_.begin() + (least - differences.begin()); nearest + 1 != images_.end();) {
    const std::optional<ClipImage> image = next();
    if (!image) return std::nullopt;
    const double time = begin + image->time - first->time;
    while (nearest + 1 != images_.end() && distance(*(nearest + 1), time) <= distance(*nearest, time)) ++nearest;
    if (Difference(nearest->samples, Samples(image->gray)) > most) return std::nullopt;
  }
  return begin;
}

bool ClipTail::JumpsTo(const cv::Mat& first) const {
  if (images_.empty() || images_.back().time - images_.front().time < kShortlyBefore) return false;
  double usual = kLeastChange;
  const std::vector<double> last = BlockMeans(images_.back().samples);
  std::vector<double> later = last;
  for (auto image = images_.rbegin() + 1; image != images_.rend(); ++image) {
    if (images_.back().time - image->time > kShortlyBefore) break;
    std::vector<double> means = BlockMeans(image->samples);
    usual = std::max(usual, Difference(means, later));
    later = std::move(means);
  }
  return Difference(last, BlockMeans(Samples(first))) > kLeastJump * usual;
}

}  // namespace turnscale
