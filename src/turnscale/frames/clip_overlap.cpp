// SPDX-License-Identifier: MIT
#include "turnscale/frames/clip_overlap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

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
// For missing images, two images differ by so many times as much as any two shortly before, seconds, that are
// consecutive or this far apart: at any rate, a jump is more than the motion of a moment. On recorded drives at 10
// images per second, consecutive images differ by less, and most gaps of a second by more.
constexpr double kLeastJump = 1.5;
// The same where images are missing as likely as not. On recorded drives, consecutive images rarely differ by more,
// and images a second apart rarely by less.
constexpr double kLeastLikelyJump = 1.2;
constexpr double kShortlyBefore = 1;
constexpr double kMoment = 0.09;
constexpr int kFewestPairs = 5;
// Least change of images of a moving car within that time, in standard deviations of their blocks.
constexpr double kLeastChange = 0.03;

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

// Less their mean, over their standard deviation: the exposure may change from one clip to the next.
std::vector<double> BlockMeans(const std::vector<uint8_t>& samples) {
  std::vector<double> means(samples.size() / (kBlockSide * kBlockSide));
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column)
      means[(row / kBlockSide) * (kColumns / kBlockSide) + column / kBlockSide] +=
          samples[row * kColumns + column] / double{kBlockSide * kBlockSide};
  const double mean = std::accumulate(means.begin(), means.end(), 0.0) / static_cast<double>(means.size());
  double square = 0;
  for (double& value : means) {
    value -= mean;
    square += value * value;
  }
  const double deviation = std::sqrt(square / static_cast<double>(means.size()));
  if (deviation > 0)
    for (double& value : means) value /= deviation;
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

bool ClipTail::JumpsTo(const cv::Mat& first, bool likely) const {
  if (!IsMoving()) return false;
  const double end = images_.back().time;
  std::vector<double> times;
  std::vector<std::vector<double>> means;
  for (const Image& image : images_) {
    if (end - image.time > kShortlyBefore + kMoment) continue;
    times.push_back(image.time);
    means.push_back(BlockMeans(image.samples));
  }
  double usual = 0;
  int pairs = 0;
  for (size_t i = 0, k = 0; i < means.size(); ++i) {
    // The latest image that is a moment before, or the one before.
    while (k + 1 < i && times[k + 1] <= times[i] - kMoment) ++k;
    if (i == 0) continue;
    usual = std::max(usual, Difference(means[k], means[i]));
    ++pairs;
  }
  if (pairs < kFewestPairs || usual < kLeastChange) return false;
  const std::vector<double> next = BlockMeans(Samples(first));
  const double jump = Difference(means.back(), next);
  if (likely) return jump > kLeastLikelyJump * usual;
  // An image that is clearly more like an earlier one repeats it.
  const bool repeats =
      std::ranges::any_of(means, [&](const auto& earlier) { return kLeastJump * Difference(earlier, next) < jump; });
  return !repeats && jump > kLeastJump * usual;
}

}  // namespace turnscale
