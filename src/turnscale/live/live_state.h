// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/odometry/odometry.h"
#include "turnscale/report/thumbnails.h"

namespace turnscale {

/// State of a run in progress, for its viewers. One thread adds frames, any number of others ask. Texts and pictures
/// are made when they are asked for, once for all viewers, by the thread that asks.
class LiveState {
 public:
  /// Browsers let pages in the background ask once a minute.
  static constexpr std::chrono::milliseconds kPauseKept{150'000};

  /// `frames` are those expected, 0 if that is not known; with more, they are no longer shown. `first_time` is that of
  /// the drive's first frame, seconds, from which the page counts. A pause ends when nobody has asked for `pause_kept`:
  /// whoever paused has left. `report` is the file of the report to come, for viewers who miss its arrival; empty:
  /// there will be none.
  LiveState(std::string title, std::string version, int frames, double first_time, std::string report = "",
            std::chrono::milliseconds pause_kept = kPauseKept);

  /// After each frame. Copies what the page shows only if somebody has asked lately.
  void Add(const cv::Mat& gray, const FrameResult& frame, const Odometry& odometry);
  /// What the program does other than to run over the frames, such as "final adjustment", which cannot be paused;
  /// empty: it runs over the frames.
  void SetPhase(const std::string& phase);
  /// Viewers get the first ones and the number of the others.
  void AddWarning(const std::string& warning);
  /// No frame follows.
  void Finish();

  void SetPaused(bool paused);
  bool IsPaused() const;
  /// Ends a pause without viewers.
  void EndStalePause();

  /// The numbers, JSON; see LiveState in web/src/live.ts.
  std::string StateJson();
  /// The path so far, as data of a report.
  std::string PathJson();
  /// The latest image with its features, JPEG; empty before the first.
  std::string Image();

 private:
  using Clock = std::chrono::steady_clock;

  // Of the keyframes so far, thinned.
  struct PathCopy {
    std::vector<FrameResult> frames;
    Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
    bool metric = false;
  };

  void CopyPath(const FrameResult& frame, const Odometry& odometry);

  const std::string title_;
  const std::string version_;
  const int frames_;
  const double first_time_;
  const std::string report_;
  const std::chrono::milliseconds pause_kept_;

  mutable std::mutex mutex_;  // of all below but for what is made of them
  std::string phase_;
  FrameResult latest_;
  int frames_done_ = 0;
  int keyframes_ = 0;
  std::vector<std::string> warnings_;  // the first ones
  size_t more_warnings_ = 0;
  bool paused_ = false;
  bool finished_ = false;
  std::deque<Clock::time_point> done_at_;  // of the latest frames
  Clock::time_point asked_at_;
  Clock::time_point copied_path_at_;
  Clock::time_point copied_image_at_;
  std::vector<ScaleState> keyframe_states_;
  PathCopy path_;
  int path_number_ = 0;
  cv::Mat image_;
  cv::Mat mask_;
  std::vector<DrawnFeature> features_;
  int image_number_ = 0;

  std::mutex making_;  // of the texts and pictures
  std::string path_json_;
  int path_json_number_ = -1;
  std::string jpeg_;
  int jpeg_number_ = -1;
};

}  // namespace turnscale
