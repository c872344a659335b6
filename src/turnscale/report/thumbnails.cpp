// SPDX-License-Identifier: MIT
#include "turnscale/report/thumbnails.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/file_text.h"
#include "turnscale/base/number_text.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/image_file/image_encoder.h"
#include "turnscale/io/output_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr auto kFolder = "thumbnails";
constexpr std::array<std::pair<ThumbnailReason, const char*>, 3> kReasonNames = {
    {{ThumbnailReason::kDrive, "drive"}, {ThumbnailReason::kTurn, "turn"}, {ThumbnailReason::kLost, "lost"}}};

// "000123-turn.jpg"; nothing for other files.
std::optional<std::pair<int, ThumbnailReason>> ParseName(const fs::path& path) {
  const std::string stem = path.stem().string();
  const size_t dash = stem.find('-');
  if (path.extension() != ".jpg" || dash == std::string::npos) return std::nullopt;
  const auto frame = ParseNumber<int>(std::string_view(stem).substr(0, dash));
  for (const auto& [reason, name] : kReasonNames)
    if (frame && stem.substr(dash + 1) == name) return std::pair(*frame, reason);
  return std::nullopt;
}

// In the order of the frames, whose numbers need not have the same number of digits.
std::vector<fs::path> ThumbnailFiles(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (fs::directory_iterator entry(folder / kFolder, none), end; entry != end; entry.increment(none))
    if (ParseName(entry->path())) files.push_back(entry->path());
  std::ranges::sort(files, {}, [](const fs::path& file) { return std::pair(ParseName(file), file); });
  return files;
}

cv::Mat Shrunk(const cv::Mat& gray, int width) {
  const double scale = std::min(1.0, static_cast<double>(width) / gray.cols);
  cv::Mat small;
  cv::resize(gray, small, {}, scale, scale, cv::INTER_AREA);
  return small;
}

// A place in an image of this size, with a flag: 12, 11 and 1 bits.
std::string PackedPoint(const cv::Point2f& pixel, const cv::Size& size, bool flag) {
  constexpr int kMostX = 4095;
  constexpr int kMostY = 2047;
  const auto steps = [](float place, int length, int most) {
    return std::clamp(cvRound(place * static_cast<float>(most) / static_cast<float>(std::max(length - 1, 1))), 0, most);
  };
  const int bits = steps(pixel.x, size.width, kMostX) << 12 | steps(pixel.y, size.height, kMostY) << 1 | (flag ? 1 : 0);
  return {static_cast<char>(bits >> 16 & 0xFF), static_cast<char>(bits >> 8 & 0xFF), static_cast<char>(bits & 0xFF)};
}

std::string PackedFeatures(const std::vector<DrawnFeature>& features, const cv::Size& size) {
  std::string bytes;
  for (const DrawnFeature& feature : features) bytes += PackedPoint(feature.pixel, size, feature.has_depth);
  return bytes;
}

std::string PackedMask(const cv::Mat& mask, int width) {
  if (mask.empty()) return "";
  const cv::Mat left_out = Shrunk(mask, width) < 128;
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(left_out, contours, cv::RETR_CCOMP, cv::CHAIN_APPROX_SIMPLE);
  std::string bytes;
  for (const std::vector<cv::Point>& contour : contours) {
    std::vector<cv::Point> corners;
    constexpr double kPixels = 1;
    cv::approxPolyDP(contour, corners, kPixels, true);
    constexpr size_t kFewest = 3;
    constexpr size_t kMost = 0xFFFF;
    if (corners.size() < kFewest || corners.size() > kMost) continue;
    bytes += {static_cast<char>(corners.size() >> 8U), static_cast<char>(corners.size() & 0xFFU)};
    for (const cv::Point& corner : corners) bytes += PackedPoint(corner, left_out.size(), false);
  }
  return bytes;
}

// A COM segment; none for no bytes, or for more than a segment holds.
std::string Comment(const std::string& name, const std::string& bytes) {
  const size_t length = 2 + name.size() + 1 + bytes.size();
  constexpr size_t kMost = 0xFFFF;
  if (bytes.empty() || length > kMost) return "";
  std::string segment = {'\xFF', '\xFE', static_cast<char>(length >> 8U), static_cast<char>(length & 0xFFU)};
  return segment + name + '\0' + bytes;
}

}  // namespace

bool IsLost(TrackingState state) { return state == TrackingState::kBridged || state == TrackingState::kUnreadable; }

const char* ThumbnailReasonName(ThumbnailReason reason) { return kReasonNames[static_cast<size_t>(reason)].second; }

std::vector<DrawnFeature> FeaturesOf(const Odometry& odometry) {
  std::vector<DrawnFeature> features;
  for (const FeatureTrack& track : odometry.tracks())
    features.push_back({track.pixel, odometry.map().landmarks[track.landmark].valid});
  return features;
}

cv::Mat DrawTracking(const cv::Mat& gray, const std::vector<DrawnFeature>& features, const cv::Mat& mask, int width) {
  const double scale = std::min(1.0, static_cast<double>(width) / gray.cols);
  cv::Mat image;
  cv::cvtColor(Shrunk(gray, width), image, cv::COLOR_GRAY2BGR);
  if (!mask.empty()) {
    cv::Mat left_out;
    cv::resize(mask, left_out, image.size(), 0, 0, cv::INTER_NEAREST);
    const cv::Mat tinted = 0.55 * image + cv::Scalar(20, 20, 110);
    tinted.copyTo(image, left_out == 0);
  }
  // Many dots are small ones, so that the picture stays visible between them.
  constexpr double kShare = 0.03;  // of the picture's area, in all
  const double whole = image.cols / 250.0;
  const double fair =
      std::sqrt(kShare * image.size().area() / (CV_PI * std::max(static_cast<double>(features.size()), 1.0)));
  const double radius = std::clamp(fair, 0.55 * whole, whole);
  constexpr int kShift = 4;
  const auto fixed = [](double pixel) { return cvRound(pixel * (1 << kShift)); };
  for (const DrawnFeature& feature : features) {
    const cv::Scalar colour = feature.has_depth ? cv::Scalar(120, 230, 70) : cv::Scalar(40, 175, 255);
    const cv::Point centre(fixed((feature.pixel.x + 0.5) * scale - 0.5), fixed((feature.pixel.y + 0.5) * scale - 0.5));
    cv::circle(image, centre, fixed(radius), colour, cv::FILLED, cv::LINE_AA, kShift);
  }
  return image;
}

std::string AnnotatedJpeg(const cv::Mat& gray, const std::vector<DrawnFeature>& features, const cv::Mat& mask,
                          int width, int quality) {
  std::string jpeg = EncodeJpeg(Shrunk(gray, width), quality);
  // Behind the start of the image and the JFIF header, which has to be the first segment.
  const auto byte = [&](size_t place) -> size_t { return static_cast<unsigned char>(jpeg.at(place)); };
  constexpr size_t kStart = 2;
  const bool has_header = byte(kStart) == 0xFF && byte(kStart + 1) == 0xE0;
  const size_t place = has_header ? kStart + 2 + (byte(kStart + 2) << 8U | byte(kStart + 3)) : kStart;
  return jpeg.insert(place, Comment("turnscale features", PackedFeatures(features, gray.size())) +
                                Comment("turnscale mask", PackedMask(mask, width)));
}

bool ThumbnailCollector::IsDue(const FrameResult& frame, ThumbnailReason& reason) {
  const TrackingState last_state = std::exchange(last_state_, frame.state);
  const bool lost = IsLost(frame.state) && !IsLost(last_state);
  bool turns = false;
  if (frame.keyframe) {
    const double rate = std::abs(frame.psi) * kDegreesPerRadian / (frame.time - last_keyframe_time_);
    turns = rate > options_.turn_rate && frame.time - last_turn_time_ >= options_.interval * turn_interval_factor_;
    last_keyframe_time_ = frame.time;
  }
  reason = lost ? ThumbnailReason::kLost : turns ? ThumbnailReason::kTurn : ThumbnailReason::kDrive;
  return lost || turns || frame.time - last_time_ >= options_.interval * interval_factor_;
}

void ThumbnailCollector::Add(const cv::Mat& gray, const FrameResult& frame, const Odometry& odometry) {
  Thumbnail thumbnail{frame.frame, frame.time, {}, {}};
  if (!IsDue(frame, thumbnail.reason) || gray.empty()) return;
  // Where tracking failed, the tracks are those of an earlier image.
  const bool tracked = frame.state == TrackingState::kTracked;
  const std::vector<DrawnFeature> features = tracked ? FeaturesOf(odometry) : std::vector<DrawnFeature>();
  thumbnail.jpeg = AnnotatedJpeg(gray, features, odometry.mask(), options_.width, options_.quality);
  last_time_ = frame.time;
  if (thumbnail.reason == ThumbnailReason::kTurn) last_turn_time_ = frame.time;
  bytes_ += thumbnail.jpeg.size();
  thumbnails_.push_back(std::move(thumbnail));
  KeepWithinBudget();
}

void ThumbnailCollector::KeepWithinBudget() {
  while (bytes_ > options_.budget && thumbnails_.size() > 1) {
    const auto count = [&](ThumbnailReason reason) {
      return std::count_if(thumbnails_.begin(), thumbnails_.end(), [&](const auto& t) { return t.reason == reason; });
    };
    // The most numerous kind is thinned, so that none displaces the others.
    const auto most = std::max({ThumbnailReason::kDrive, ThumbnailReason::kTurn, ThumbnailReason::kLost},
                               [&](ThumbnailReason a, ThumbnailReason b) { return count(a) < count(b); });
    // One of each kind stays, however small the budget.
    if (count(most) < 2) return;
    if (most == ThumbnailReason::kDrive) interval_factor_ *= 2;
    if (most == ThumbnailReason::kTurn) turn_interval_factor_ *= 2;
    DropEverySecond(most);
  }
}

void ThumbnailCollector::DropEverySecond(ThumbnailReason reason) {
  std::vector<Thumbnail> kept;
  bool drop = false;
  bytes_ = 0;
  for (Thumbnail& thumbnail : thumbnails_) {
    if (thumbnail.reason == reason && std::exchange(drop, !drop)) continue;
    bytes_ += thumbnail.jpeg.size();
    kept.push_back(std::move(thumbnail));
  }
  thumbnails_ = std::move(kept);
}

void RemoveThumbnails(const fs::path& folder) {
  std::error_code none;
  for (const fs::path& file : ThumbnailFiles(folder)) fs::remove(file, none);
  // Only where nothing else is in it.
  fs::remove(folder / kFolder, none);
}

void WriteThumbnails(const fs::path& folder, const std::vector<Thumbnail>& thumbnails) {
  RemoveThumbnails(folder);
  if (thumbnails.empty()) return;
  std::error_code error;
  fs::create_directories(folder / kFolder, error);
  if (error) throw OutputError((folder / kFolder).string() + ": cannot be made: " + error.message());
  for (const Thumbnail& thumbnail : thumbnails) {
    ReplaceFile(folder / kFolder / fmt::format("{:06}-{}.jpg", thumbnail.frame, ThumbnailReasonName(thumbnail.reason)),
                thumbnail.jpeg, Durability::kProcess);
  }
}

std::vector<Thumbnail> ReadThumbnails(const fs::path& folder, const std::vector<FrameResult>& frames) {
  std::vector<Thumbnail> thumbnails;
  for (const fs::path& file : ThumbnailFiles(folder)) {
    const auto [frame, reason] = *ParseName(file);
    if (frame < 0 || frame >= static_cast<int>(frames.size())) continue;
    thumbnails.push_back({frame, frames[frame].time, reason, FileText(file).value_or("")});
  }
  return thumbnails;
}

}  // namespace turnscale
