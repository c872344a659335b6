// SPDX-License-Identifier: MIT
#include "turnscale/odometry/feature_tracks.h"

#include <optional>

namespace turnscale {
namespace {

cv::Point2f ToPoint(const Eigen::Vector2d& pixel) {
  return {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
}

}  // namespace

std::vector<cv::Point2f> PredictPixels(const Map& map, const CameraModel& camera,
                                       const std::vector<FeatureTrack>& tracks, const RigidTransform& last_from_world,
                                       const RigidTransform& predicted_from_world) {
  const Eigen::Quaterniond predicted_from_last = predicted_from_world.rotation * last_from_world.rotation.conjugate();
  std::vector<cv::Point2f> guesses;
  guesses.reserve(tracks.size());
  for (const FeatureTrack& track : tracks) {
    const Landmark& landmark = map.landmarks[track.landmark];
    const Eigen::Vector3d x = landmark.valid
                                  ? Eigen::Vector3d(predicted_from_world * landmark.position)
                                  : Eigen::Vector3d(predicted_from_last * map.pinhole.Ray(track.undistorted));
    const std::optional<Eigen::Vector2d> pixel = x.z() > 0 ? camera.Project(x) : std::nullopt;
    guesses.push_back(pixel ? ToPoint(*pixel) : track.pixel);
  }
  return guesses;
}

std::vector<FeatureTrack> FollowTracks(const FlowOptions& options, const CameraModel& camera, const FlowImage& first,
                                       const FlowImage& second, const std::vector<FeatureTrack>& tracks,
                                       const std::vector<cv::Point2f>& guesses) {
  const FlowResult flow = TrackPoints(options, first, second, PixelsOf(tracks), guesses);
  std::vector<FeatureTrack> followed;
  followed.reserve(tracks.size());
  for (size_t i = 0; i < tracks.size(); ++i) {
    if (flow.found[i] == 0) continue;
    const cv::Point2f& pixel = flow.points[i];
    const std::optional<Eigen::Vector2d> undistorted = camera.Undistort({pixel.x, pixel.y});
    if (!undistorted) continue;
    followed.push_back(tracks[i]);
    followed.back().pixel = pixel;
    followed.back().undistorted = *undistorted;
  }
  return followed;
}

std::vector<cv::Point2f> PixelsOf(const std::vector<FeatureTrack>& tracks) {
  std::vector<cv::Point2f> pixels;
  pixels.reserve(tracks.size());
  for (const FeatureTrack& track : tracks) pixels.push_back(track.pixel);
  return pixels;
}

}  // namespace turnscale
