// SPDX-License-Identifier: MIT
#include "turnscale/odometry/pose_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <opencv2/core/utility.hpp>

#include "turnscale/mapping/pose_estimation.h"

namespace turnscale {
namespace {

// Halvings of the image after which a pixel is about this large, radians: then a pose that is off by a degree still
// shows landmarks at nearly the right pixels, and patches are distinct.
constexpr double kCoarsePixel = 0.012;
// Distance of neighbouring hypotheses, in coarse pixels.
constexpr double kTurnStep = 1.25;
// Shares of the expected speed.
constexpr std::array kSpeeds = {0.3, 0.5, 0.65, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5};
// Landmarks that all hypotheses are compared by.
constexpr size_t kScoredLandmarks = 100;
// And those by which the best are aligned.
constexpr size_t kMostLandmarks = 500;
constexpr size_t kBestHypotheses = 6;
// Correlation that counts in favour of a hypothesis from here on: what random patches reach.
constexpr float kRandomCorrelation = 0.5F;
constexpr float kLeastMatch = 0.7F;
constexpr int kHalf = 4;
constexpr int kSide = 2 * kHalf + 1;
constexpr int kReach = 2;  // of the alignment, in pixels of its level
constexpr int kFinestLevel = 1;
constexpr size_t kLeastInliers = 25;
// Of the landmarks in sight. After gaps of 0.5 to 1 s in KITTI, more than half agree with the right pose, and at most a
// fifth with a wrong one.
constexpr double kLeastInlierShare = 0.25;

using Patch = std::array<float, kSide * kSide>;  // mean 0, sum of squares 1

bool Normalize(Patch& patch) {
  const float mean = std::accumulate(patch.begin(), patch.end(), 0.0F) / static_cast<float>(patch.size());
  float squares = 0;
  for (float& value : patch) {
    value -= mean;
    squares += value * value;
  }
  if (!(squares > static_cast<float>(patch.size()))) return false;
  const float factor = 1 / std::sqrt(squares);
  for (float& value : patch) value *= factor;
  return true;
}

// The patch around a pixel of the reference image as another view shows it.
std::optional<Patch> PatchInOtherView(const cv::Mat& reference, const Eigen::Vector2d& pixel,
                                      const Eigen::Matrix2d& reference_from_current) {
  Patch patch;
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column) {
      const Eigen::Vector2d at = pixel + reference_from_current * Eigen::Vector2d(column - kHalf, row - kHalf);
      if (!(at.x() >= 0 && at.y() >= 0 && at.x() < reference.cols - 1 && at.y() < reference.rows - 1))
        return std::nullopt;
      const int x = static_cast<int>(at.x());
      const int y = static_cast<int>(at.y());
      const float right = static_cast<float>(at.x() - x);
      const float down = static_cast<float>(at.y() - y);
      const uchar* above = reference.ptr<uchar>(y) + x;
      const uchar* below = reference.ptr<uchar>(y + 1) + x;
      const float top = static_cast<float>(above[0]) + right * static_cast<float>(above[1] - above[0]);
      const float bottom = static_cast<float>(below[0]) + right * static_cast<float>(below[1] - below[0]);
      patch[row * kSide + column] = top + down * (bottom - top);
    }
  if (!Normalize(patch)) return std::nullopt;
  return patch;
}

float Correlation(const Patch& patch, const cv::Mat& image, int x, int y) {
  float sum = 0;
  float squares = 0;
  float product = 0;
  for (int row = 0; row < kSide; ++row) {
    const uchar* pixels = image.ptr<uchar>(y - kHalf + row) + x - kHalf;
    const float* values = &patch[row * kSide];
    for (int column = 0; column < kSide; ++column) {
      const float gray = pixels[column];
      sum += gray;
      squares += gray * gray;
      product += gray * values[column];
    }
  }
  constexpr float kPixels = kSide * kSide;
  const float variance = squares - sum * sum / kPixels;
  return variance > kPixels ? product / std::sqrt(variance) : 0.0F;
}

struct Match {
  float correlation = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // of the full image
};

class Search {
 public:
  Search(const Map& map, const ImageStep& step)
      : map_(map),
        last_pyramid_(step.last_image.pyramid),
        last_from_world_(step.last_from_world),
        pyramid_(step.image.pyramid),
        coarsest_(CoarsestLevel(map.camera.pinhole.fx, static_cast<int>(pyramid_.size()))),
        tracks_(SampleWithDepth(map, step.tracks, kMostLandmarks)) {}

  bool HasLandmarks() const { return tracks_.size() >= kLeastInliers; }

  double TurnStep() const { return kTurnStep * (1 << coarsest_) / map_.camera.pinhole.fx; }

  // How well a pose explains the coarse image.
  double Score(const RigidTransform& pose) const {
    double score = 0;
    const size_t count = std::min(tracks_.size(), kScoredLandmarks);
    for (size_t i = 0; i < count; ++i) {
      const std::optional<Match> match = Find(*tracks_[i * tracks_.size() / count], pose, coarsest_, 1);
      if (match) score += std::max(0.0F, match->correlation - kRandomCorrelation);
    }
    return score;
  }

  PoseEstimate Align(RigidTransform pose) const {
    PoseEstimate estimate;
    for (int level = coarsest_; level >= std::min(kFinestLevel, coarsest_); --level)
      for (int round = 0; round < 2; ++round) {
        std::vector<PointSighting> sightings;
        for (const FeatureTrack* track : tracks_) {
          const std::optional<Match> match = Find(*track, pose, level, kReach);
          if (!match || match->correlation < kLeastMatch) continue;
          const std::optional<Eigen::Vector2d> undistorted = map_.camera.Undistort(match->pixel);
          if (undistorted) sightings.push_back({map_.landmarks[track->landmark].position, *undistorted});
        }
        if (sightings.size() < kLeastInliers) return {};
        const double pixel = 1 << level;
        estimate = EstimatePose({.inlier_threshold = 1.5 * pixel, .huber_threshold = 0.5 * pixel}, map_.camera.pinhole,
                                sightings, pose);
        pose = estimate.camera_from_world;
      }
    return estimate;
  }

  // The pose if it explains enough of what should be in sight. A share of the matches would tell little: they are
  // looked for within a few pixels of the pose, where most are inliers whatever the image shows.
  std::optional<RigidTransform> Believed(const PoseEstimate& estimate) const {
    const auto in_sight = std::ranges::count_if(tracks_, [&](const FeatureTrack* track) {
      return PixelOf(map_, track->landmark, estimate.camera_from_world).has_value();
    });
    const double share = kLeastInlierShare * static_cast<double>(in_sight);
    if (estimate.inliers < std::max(static_cast<double>(kLeastInliers), share)) return std::nullopt;
    return estimate.camera_from_world;
  }

 private:
  static int CoarsestLevel(double focal_length, int levels) {
    const int wanted = static_cast<int>(std::lround(std::log2(kCoarsePixel * focal_length)));
    return std::min(std::max(wanted, kFinestLevel), levels - 1);
  }

  // What has grown is taken from a larger image, so that it is as sharp as what it is compared with.
  int LevelOfPatch(int level, double growth) const {
    const int halvings = static_cast<int>(std::lround(std::log2(std::clamp(growth, 0.1, 10.0))));
    return std::clamp(level - halvings, 0, static_cast<int>(last_pyramid_.size()) - 1);
  }

  // The landmark in the image of a level, at most `reach` of its pixels from where the pose has it.
  std::optional<Match> Find(const FeatureTrack& track, const RigidTransform& pose, int level, int reach) const {
    const std::optional<cv::Point2f> expected = PixelOf(map_, track.landmark, pose);
    if (!expected) return std::nullopt;
    const cv::Mat& image = pyramid_[level];
    const double size = 1 << level;
    const int x = static_cast<int>(std::lround(expected->x / size));
    const int y = static_cast<int>(std::lround(expected->y / size));
    const int margin = kHalf + reach;
    if (x < margin || y < margin || x >= image.cols - margin || y >= image.rows - margin) return std::nullopt;
    const std::optional<Eigen::Matrix2d> current_from_last =
        CurrentFromReference(map_.camera, map_.landmarks[track.landmark].position, last_from_world_, pose);
    if (!current_from_last || !(current_from_last->determinant() > 0)) return std::nullopt;
    const int last_level = LevelOfPatch(level, std::sqrt(current_from_last->determinant()));
    const double last_size = 1 << last_level;
    const std::optional<Patch> patch =
        PatchInOtherView(last_pyramid_[last_level], Eigen::Vector2d(track.pixel.x, track.pixel.y) / last_size,
                         current_from_last->inverse() * (size / last_size));
    if (!patch) return std::nullopt;
    Match best;
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx) {
        const float correlation = Correlation(*patch, image, x + dx, y + dy);
        if (correlation > best.correlation) best = {correlation, size * Eigen::Vector2d(x + dx, y + dy)};
      }
    return best;
  }

  const Map& map_;
  const std::vector<cv::Mat>& last_pyramid_;
  RigidTransform last_from_world_;
  const std::vector<cv::Mat>& pyramid_;
  int coarsest_;
  std::vector<const FeatureTrack*> tracks_;
};

}  // namespace

std::optional<RigidTransform> SearchPose(const Map& map, const ImageStep& step) {
  const Search search(map, step);
  if (!search.HasLandmarks()) return std::nullopt;
  std::vector<RigidTransform> hypotheses;
  const int turns = static_cast<int>(std::ceil(step.motion.TurnReach(step.time) / search.TurnStep()));
  for (int turn = -turns; turn <= turns; ++turn)
    for (const double speed : kSpeeds)
      hypotheses.push_back(step.motion.PredictOtherwise(step.time, turn * search.TurnStep(), speed));
  std::vector<double> scores(hypotheses.size());
  cv::parallel_for_(cv::Range(0, static_cast<int>(hypotheses.size())), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) scores[i] = search.Score(hypotheses[i]);
  });
  std::vector<size_t> order(hypotheses.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, [&](size_t a, size_t b) { return scores[a] > scores[b]; });
  std::vector<PoseEstimate> aligned(std::min(order.size(), kBestHypotheses));
  cv::parallel_for_(cv::Range(0, static_cast<int>(aligned.size())), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) aligned[i] = search.Align(hypotheses[order[i]]);
  });
  // Of equals the one that the coarse image favours.
  return search.Believed(*std::ranges::max_element(aligned, {}, &PoseEstimate::inliers));
}

std::optional<RigidTransform> AlignPose(const Map& map, const ImageStep& step, const RigidTransform& initial) {
  const Search search(map, step);
  return search.Believed(search.Align(initial));
}

}  // namespace turnscale
