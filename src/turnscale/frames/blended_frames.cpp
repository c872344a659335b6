// SPDX-License-Identifier: MIT
#include "turnscale/frames/blended_frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

// Width of the pixels that are looked at, in pixels of the video. Compression takes away finer detail, and takes more
// of it from some images than from others; of what is larger it leaves nearly all.
constexpr double kPixelWidth = 4;
constexpr int kTileColumns = 8;
constexpr int kTileRows = 6;
constexpr int kSmallestTile = 4;  // pixels

// Gray levels that are added before the logarithm: black and uniform tiles have one, too.
constexpr double kLeastDetail = 0.3;
constexpr double kLeastGray = 8;
constexpr float kMostChange = 0.6F;
// An image whose brightness differs by more than this share from that of those beside it tells nothing.
constexpr double kMostFlash = 0.05;

// A converted video keeps its rhythm, so that a short one shows it. Long drives have parts in which they stand.
constexpr std::size_t kBlock = 64;
constexpr std::size_t kShortestBlock = 40;

// Of the rhythm, per image. A slower one, as of 24 to 25 images per second, cannot be told from the scene.
constexpr double kLowest = 0.1;
constexpr double kStep = 0.0025;
constexpr int kFrequencies = 161;
constexpr double kHighest = 0.5;

// A block shows blending if its rhythm is that strong and explains this share of the variance.
constexpr double kLeastDepth = 0.025;
constexpr double kLeastShareOfVariance = 0.3;
// Compression leaves less detail in images of type B. With one, two or three of them between others, it has these
// rhythms, and blending has to be deeper than that of video of 100 kbit/s, or of hardly any detail.
struct CompressionRhythm {
  double frequency;
  double least_depth;
};
constexpr CompressionRhythm kCompressionRhythms[] = {{1.0 / 2, 0.095}, {1.0 / 3, 0.095}, {1.0 / 4, 0.045}};
constexpr double kSameRhythm = 0.02;  // at the resolution of a block
// Less of a drive matters little, and may be chance.
constexpr double kLeastOfDrive = 0.25;

double FrequencyAt(int i) { return std::min(kLowest + kStep * i, kHighest); }

struct Rhythm {
  double depth = 0;  // amplitude of the logarithm of the fine detail
  double share = 0;  // of the variance
};

// Least squares fit of one sinusoid to values of zero mean, whose squares add up to `variance`.
Rhythm RhythmAt(double frequency, const std::vector<double>& values, double variance) {
  const double turn = 2 * std::numbers::pi * frequency;
  const std::complex<double> step = std::polar(1.0, turn);
  std::complex<double> phase = 1;
  double cc = 0;
  double cs = 0;
  double ss = 0;
  double vc = 0;
  double vs = 0;
  for (const double value : values) {
    const double c = phase.real();
    const double s = phase.imag();
    cc += c * c;
    cs += c * s;
    ss += s * s;
    vc += value * c;
    vs += value * s;
    phase *= step;
  }
  // At the highest frequency the sine vanishes, and just below it is nearly the cosine.
  constexpr double kDistinct = 0.1;
  const double determinant = cc * ss - cs * cs;
  const bool has_sine = determinant > kDistinct * cc * cc;
  const double a = has_sine ? (ss * vc - cs * vs) / determinant : vc / cc;
  const double b = has_sine ? (cc * vs - cs * vc) / determinant : 0;
  // Each value is the difference from the mean of its neighbours.
  const double gain = 1 - std::cos(turn);
  return {std::hypot(a, b) / gain, (a * vc + b * vs) / variance};
}

double LeastDepth(double frequency) {
  for (const CompressionRhythm& rhythm : kCompressionRhythms)
    if (std::abs(frequency - rhythm.frequency) < kSameRhythm) return rhythm.least_depth;
  return kLeastDepth;
}

bool ShowsBlending(const Rhythm& rhythm, int frequency) {
  return rhythm.depth >= LeastDepth(FrequencyAt(frequency)) && rhythm.share >= kLeastShareOfVariance;
}

using Spectrum = std::array<Rhythm, kFrequencies>;

Spectrum SpectrumOf(std::span<const float> changes) {
  std::vector<double> values(changes.begin(), changes.end());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  double variance = 1e-9;
  for (double& value : values) {
    value -= mean;
    variance += value * value;
  }
  Spectrum spectrum;
  for (int i = 0; i < kFrequencies; ++i) spectrum[i] = RhythmAt(FrequencyAt(i), values, variance);
  return spectrum;
}

// By how much the second of three values differs from the mean of the others: the median over tiles, which leaves out
// what does not concern the whole image.
double ChangeOf(const std::vector<float>& before, const std::vector<float>& values, const std::vector<float>& after) {
  std::vector<double> changes;
  changes.reserve(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) changes.push_back(values[i] - 0.5 * (before[i] + after[i]));
  return Median(std::move(changes));
}

}  // namespace

// Fine detail is over the mean gray: brightness drops out. Fourth powers count strong detail, which compression keeps;
// blending halves it, too.
BlendedFrames::Tiles BlendedFrames::TilesOf(const cv::Mat& image) {
  std::array<std::int64_t, kTileColumns * kTileRows> detail{};
  std::array<std::int64_t, kTileColumns * kTileRows> gray{};
  std::array<int, kTileColumns * kTileRows> pixels{};
  const int width = image.cols / kTileColumns;
  const int height = image.rows / kTileRows;
  for (int row = 0; row < kTileRows; ++row) {
    for (int y = std::max(1, row * height); y < std::min(image.rows - 1, (row + 1) * height); ++y) {
      const auto* above = image.ptr<std::uint8_t>(y - 1);
      const auto* here = image.ptr<std::uint8_t>(y);
      const auto* below = image.ptr<std::uint8_t>(y + 1);
      for (int column = 0; column < kTileColumns; ++column) {
        const int begin = std::max(1, column * width);
        const int end = std::min(image.cols - 1, (column + 1) * width);
        std::int64_t sum_detail = 0;
        int sum_gray = 0;
        for (int x = begin; x < end; ++x) {
          const int laplacian = above[x] + below[x] + here[x - 1] + here[x + 1] - 4 * here[x];
          const std::int64_t square = laplacian * laplacian;
          sum_detail += square * square;
          sum_gray += here[x];
        }
        const int tile = row * kTileColumns + column;
        detail[tile] += sum_detail;
        gray[tile] += sum_gray;
        pixels[tile] += end - begin;
      }
    }
  }
  Tiles tiles;
  tiles.brightness.reserve(detail.size());
  tiles.detail.reserve(detail.size());
  for (std::size_t i = 0; i < detail.size(); ++i) {
    const double count = pixels[i];
    const double strength = std::sqrt(std::sqrt(static_cast<double>(detail[i]) / count));
    const double brightness = std::log(static_cast<double>(gray[i]) / count + kLeastGray);
    tiles.brightness.push_back(static_cast<float>(brightness));
    tiles.detail.push_back(static_cast<float>(std::log(strength + kLeastDetail) - brightness));
  }
  return tiles;
}

BlendedFrames::BlendedFrames(double pixel_width)
    : halvings_(std::max(0, static_cast<int>(std::lround(std::log2(kPixelWidth / pixel_width))))) {}

void BlendedFrames::Add(const cv::Mat& gray, double time) {
  if (gray.size() != size_) {
    size_ = gray.size();
    tiles_ = {};
  }
  cv::Mat image = gray;
  for (int i = 0; i < halvings_; ++i) {
    // Of an even size, halving is the mean of four pixels, which is fast.
    const cv::Size half = image.size() / 2;
    if (half.empty()) return;
    cv::resize(image(cv::Rect({}, half * 2)), small_[i % 2], half, 0, 0, cv::INTER_AREA);
    image = small_[i % 2];
  }
  const double middle_time = std::exchange(last_time_, time);
  if (image.cols < kTileColumns * kSmallestTile || image.rows < kTileRows * kSmallestTile) return;
  std::rotate(tiles_.begin(), tiles_.begin() + 1, tiles_.end());
  tiles_.back() = TilesOf(image);
  const auto& [before, middle, after] = tiles_;
  if (before.detail.empty()) return;
  const bool flashes = std::abs(ChangeOf(before.brightness, middle.brightness, after.brightness)) > kMostFlash;
  const auto change = static_cast<float>(ChangeOf(before.detail, middle.detail, after.detail));
  changes_.push_back(flashes ? 0 : std::clamp(change, -kMostChange, kMostChange));
  times_.push_back(middle_time);
}

std::optional<FrameBlending> BlendedFrames::Find() const {
  const std::size_t count = changes_.size();
  if (count < kShortestBlock) return std::nullopt;
  const std::size_t blocks = std::max<std::size_t>(1, count / kBlock);
  const auto begin_of = [&](std::size_t block) { return block * count / blocks; };
  std::vector<Spectrum> spectra;
  std::array<std::size_t, kFrequencies> blended{};
  std::array<double, kFrequencies> sums{};
  for (std::size_t block = 0; block < blocks; ++block) {
    const std::size_t begin = begin_of(block);
    spectra.push_back(SpectrumOf(std::span(changes_).subspan(begin, begin_of(block + 1) - begin)));
    for (int i = 0; i < kFrequencies; ++i) {
      blended[i] += ShowsBlending(spectra.back()[i], i) ? 1 : 0;
      sums[i] += spectra.back()[i].share;
    }
  }
  int best = 0;
  for (int i = 1; i < kFrequencies; ++i)
    if (std::pair(blended[i], sums[i]) > std::pair(blended[best], sums[best])) best = i;
  if (static_cast<double>(blended[best]) < kLeastOfDrive * static_cast<double>(blocks)) return std::nullopt;
  std::optional<FrameBlending> found;
  for (std::size_t block = 0; block < blocks; ++block) {
    if (!ShowsBlending(spectra[block][best], best)) continue;
    if (!found) found = FrameBlending{.from = times_[begin_of(block)], .period = 1 / FrequencyAt(best)};
    found->to = times_[begin_of(block + 1) - 1];
  }
  return found;
}

std::string FrameBlendingText(const FrameBlending& blending, const std::string& consequence) {
  if (blending.kind == FrameBlending::Kind::kImageBefore) {
    return fmt::format(
        "each image seems to contain a copy of the one before (from {:.1f} to {:.1f} s), as blended frames or "
        "strong temporal noise reduction leave it: {}; use the video as the camera recorded it, and record later "
        "drives without temporal noise reduction",
        blending.from, blending.to, consequence);
  }
  if (blending.kind == FrameBlending::Kind::kHalfInterval) {
    return fmt::format(
        "each image seems to be the mean of two frames (from {:.1f} to {:.1f} s), as in a video whose frame rate was "
        "halved by blending: {}; use the video as the camera recorded it",
        blending.from, blending.to, consequence);
  }
  // What an even rhythm is in whole images need not be.
  const double whole = std::round(blending.period);
  const bool is_whole = std::abs(blending.period - whole) < 0.05;
  return fmt::format(
      "the sharpness of the images rises and falls every {:.{}f} images (from {:.1f} to {:.1f} s), as in a video that "
      "was converted to another frame rate by blending: each image then shows two moments, and {}; use the video as "
      "the camera recorded it",
      blending.period, is_whole ? 0 : 1, blending.from, blending.to, consequence);
}

}  // namespace turnscale
