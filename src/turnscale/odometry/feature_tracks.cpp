// SPDX-License-Identifier: MIT
#include "turnscale/odometry/feature_tracks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

namespace turnscale {
namespace {

cv::Point2f ToPoint(const Eigen::Vector2d& pixel) {
  return {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
}

// Halvings of the image that cover what the parallax of the last image leaves unknown.
constexpr int kLevelsNearby = 1;

// Share of the distance that the camera moves now over which a parallax has to be measured: the pixel predicted by it
// is then wrong by a few pixels at most. At standstill it is noise.
constexpr double kLeastParallaxBase = 1.0 / 16;

// Tracks whose reference views are prefetched while one is aligned.
constexpr int kTracksAhead = 2;

// Notes how far beyond the `distant` pixels the tracks have been found. `found` are some of `tracks`, in their order.
void NoteParallax(const std::vector<FeatureTrack>& tracks, const std::vector<cv::Point2f>& distant, double moved,
                  std::vector<FeatureTrack>& found) {
  size_t i = 0;
  for (FeatureTrack& track : found) {
    while (tracks[i].landmark != track.landmark) ++i;
    const cv::Point2f beyond = track.pixel - distant[i];
    if (moved > 0) track.parallax = Eigen::Vector2d(beyond.x, beyond.y) / moved;
    track.parallax_base = moved;
  }
}

}  // namespace

std::vector<cv::Point2f> PredictPixels(const Map& map, const std::vector<FeatureTrack>& tracks,
                                       const RigidTransform& last_from_world,
                                       const RigidTransform& predicted_from_world) {
  const Eigen::Quaterniond predicted_from_last = predicted_from_world.rotation * last_from_world.rotation.conjugate();
  std::vector<cv::Point2f> guesses;
  guesses.reserve(tracks.size());
  for (const FeatureTrack& track : tracks) {
    const Landmark& landmark = map.landmarks[track.landmark];
    const Eigen::Vector3d x = landmark.valid
                                  ? Eigen::Vector3d(predicted_from_world * landmark.position)
                                  : Eigen::Vector3d(predicted_from_last * map.camera.pinhole.Ray(track.undistorted));
    const std::optional<Eigen::Vector2d> pixel = map.camera.ProjectInFront(x);
    guesses.push_back(pixel ? ToPoint(*pixel) : track.pixel);
  }
  return guesses;
}

FollowedTracks FollowTracks(const FlowOptions& options, const Map& map, const FlowImage& first, const FlowImage& second,
                            const std::vector<FeatureTrack>& tracks, const std::vector<cv::Point2f>& guesses,
                            std::optional<int> levels) {
  const std::vector<cv::Point2f> pixels = PixelsOf(tracks);
  FlowResult flow = TrackPoints(options, first, second, pixels, guesses, levels);
  // A landmark with a depth is going to be compared with its reference view, which is stricter than tracking back.
  std::vector<uchar> without_depth;
  without_depth.reserve(tracks.size());
  for (const FeatureTrack& track : tracks) without_depth.push_back(map.landmarks[track.landmark].valid ? 0 : 1);
  CheckReturn(options, first, second, pixels, without_depth, flow);
  FollowedTracks followed;
  for (size_t i = 0; i < tracks.size(); ++i) {
    const cv::Point2f& pixel = flow.points[i];
    const std::optional<Eigen::Vector2d> undistorted =
        flow.found[i] != 0 ? map.camera.Undistort({pixel.x, pixel.y}) : std::nullopt;
    if (!undistorted) {
      followed.lost.push_back(tracks[i]);
      continue;
    }
    followed.found.push_back(tracks[i]);
    followed.found.back().pixel = pixel;
    followed.found.back().undistorted = *undistorted;
    followed.found.back().parallax.reset();
  }
  return followed;
}

FollowedTracks FollowWithoutDepth(const FlowOptions& options, const Map& map, const LocatedImage& first,
                                  const LocatedImage& second, const std::vector<FeatureTrack>& tracks) {
  const double moved =
      (second.camera_from_world.inverse().translation - first.camera_from_world.inverse().translation).norm();
  const auto distant_pixels = [&](const std::vector<FeatureTrack>& some) {
    return PredictPixels(map, some, first.camera_from_world, second.camera_from_world);
  };
  std::vector<FeatureTrack> known;
  std::vector<FeatureTrack> others;
  for (const FeatureTrack& track : tracks) {
    const bool is_known = track.parallax && track.parallax_base >= kLeastParallaxBase * moved;
    (is_known ? known : others).push_back(track);
  }
  const std::vector<cv::Point2f> known_distant = distant_pixels(known);
  std::vector<cv::Point2f> guesses = known_distant;
  for (size_t i = 0; i < known.size(); ++i) guesses[i] += ToPoint(moved * *known[i].parallax);
  FollowedTracks followed = FollowTracks(options, map, first.image, second.image, known, guesses, kLevelsNearby);
  NoteParallax(known, known_distant, moved, followed.found);

  std::ranges::move(followed.lost, std::back_inserter(others));
  const std::vector<cv::Point2f> distant = distant_pixels(others);
  FollowedTracks more = FollowTracks(options, map, first.image, second.image, others, distant);
  NoteParallax(others, distant, moved, more.found);
  std::ranges::move(more.found, std::back_inserter(followed.found));
  followed.lost = std::move(more.lost);
  return followed;
}

std::optional<Eigen::Matrix2d> CurrentFromReference(const Map& map, const FeatureTrack& track,
                                                    const RigidTransform& camera_from_world) {
  return CurrentFromReference(map.camera, map.landmarks[track.landmark].position,
                              map.keyframes[track.reference_keyframe].camera_from_world, camera_from_world);
}

std::optional<Eigen::Matrix2d> CurrentFromReference(const CameraModel& camera, const Eigen::Vector3d& point,
                                                    const RigidTransform& reference_from_world,
                                                    const RigidTransform& camera_from_world) {
  const RigidTransform current_from_reference = camera_from_world * reference_from_world.inverse();
  const Eigen::Vector3d x = reference_from_world * point;
  if (!(x.z() > 0)) return std::nullopt;
  // Two points beside the landmark, about a pixel away, at the same depth.
  const double offset = x.z() / camera.pinhole.fx;
  // The radial correction changes both views alike.
  CameraModel lens = camera;
  lens.radial_correction = 0;
  const std::array<Eigen::Vector3d, 3> points = {x, x + offset * Eigen::Vector3d::UnitX(),
                                                 x + offset * Eigen::Vector3d::UnitY()};
  std::array<Eigen::Vector2d, 3> in_reference;
  std::array<Eigen::Vector2d, 3> in_current;
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d moved = current_from_reference * points[i];
    const std::optional<Eigen::Vector2d> reference = lens.Project(points[i]);
    const std::optional<Eigen::Vector2d> current = lens.ProjectInFront(moved);
    if (!reference || !current) return std::nullopt;
    in_reference[i] = *reference;
    in_current[i] = *current;
  }
  Eigen::Matrix2d reference_by_offset;
  reference_by_offset << in_reference[1] - in_reference[0], in_reference[2] - in_reference[0];
  Eigen::Matrix2d current_by_offset;
  current_by_offset << in_current[1] - in_current[0], in_current[2] - in_current[0];
  return current_by_offset * reference_by_offset.inverse();
}

bool AlignTrack(const PatchAlignmentOptions& options, const Map& map, const LocatedImage& current,
                const cv::Point2f& guess, FeatureTrack& track) {
  const std::optional<Eigen::Matrix2d> current_from_reference =
      CurrentFromReference(map, track, current.camera_from_world);
  if (!current_from_reference) return false;
  const std::optional<Eigen::Vector2d> pixel =
      AlignPatch(options, *track.reference_image, {track.reference_pixel.x, track.reference_pixel.y},
                 current_from_reference->inverse(), current.image.gray, {guess.x, guess.y});
  const std::optional<Eigen::Vector2d> undistorted = pixel ? map.camera.Undistort(*pixel) : std::nullopt;
  if (!undistorted) return false;
  track.pixel = ToPoint(*pixel);
  track.undistorted = *undistorted;
  return true;
}

std::vector<uchar> AlignTracks(const PatchAlignmentOptions& options, const Map& map, const LocatedImage& current,
                               const std::vector<std::optional<cv::Point2f>>& guesses,
                               std::vector<FeatureTrack>& tracks) {
  std::vector<uchar> aligned(tracks.size(), 0);
  cv::parallel_for_(cv::Range(0, static_cast<int>(tracks.size())), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      if (const int later = i + kTracksAhead; later < range.end && guesses[later]) {
        const FeatureTrack& track = tracks[later];
        PrefetchPatch(options, *track.reference_image, {track.reference_pixel.x, track.reference_pixel.y});
      }
      if (guesses[i] && AlignTrack(options, map, current, *guesses[i], tracks[i])) aligned[i] = 1;
    }
  });
  return aligned;
}

std::optional<cv::Point2f> PixelOf(const Map& map, int landmark, const RigidTransform& camera_from_world) {
  const Eigen::Vector3d x = camera_from_world * map.landmarks[landmark].position;
  const std::optional<Eigen::Vector2d> pixel = map.camera.ProjectInFront(x);
  if (!pixel || pixel->x() < 0 || pixel->y() < 0) return std::nullopt;
  if (pixel->x() > map.camera.width - 1 || pixel->y() > map.camera.height - 1) return std::nullopt;
  return ToPoint(*pixel);
}

std::vector<const FeatureTrack*> SampleWithDepth(const Map& map, const std::vector<FeatureTrack>& tracks, size_t most) {
  std::vector<const FeatureTrack*> with_depth;
  for (const FeatureTrack& track : tracks)
    if (map.landmarks[track.landmark].valid) with_depth.push_back(&track);
  const size_t size = std::min(with_depth.size(), most);
  std::vector<const FeatureTrack*> sample;
  sample.reserve(size);
  for (size_t i = 0; i < size; ++i) sample.push_back(with_depth[i * with_depth.size() / size]);
  return sample;
}

std::vector<cv::Point2f> PixelsOf(const std::vector<FeatureTrack>& tracks) {
  std::vector<cv::Point2f> pixels;
  pixels.reserve(tracks.size());
  for (const FeatureTrack& track : tracks) pixels.push_back(track.pixel);
  return pixels;
}

}  // namespace turnscale
