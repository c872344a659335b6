// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/frames/blended_frames.h"
#include "turnscale/frames/double_images.h"
#include "turnscale/frames/image_scaling.h"
#include "turnscale/frames/image_source.h"
#include "turnscale/frames/seen_images.h"
#include "turnscale/io/terminal.h"
#include "turnscale/odometry/odometry.h"
#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"
#include "turnscale/run/drive_facts.h"
#include "turnscale/run/run_cost.h"
#include "turnscale/run/run_summary.h"
#include "turnscale/run/run_writer.h"

namespace turnscale {

/// The refined results of a drive.
struct RefinedResults {
  std::vector<FrameResult> frames;
  RefinedScale scale;                     ///< what it says of the calibration is in pixels of full size
  std::optional<FrameBlending> blending;  ///< of the images; its error is part of `scale`
};

/// Runs the odometry frame by frame and keeps what the summary and the files of a drive need besides its results.
class DriveRecorder {
 public:
  /// `scaling`: of the images that are processed. `started`: from when on the drive's cost counts.
  explicit DriveRecorder(Odometry& odometry, const ImageScaling& scaling = {},
                         const ProcessClocks& started = ReadClocks())
      : odometry_(odometry), scaling_(scaling), started_(started), blended_(scaling.pixel_width()) {}

  /// As Odometry::Process.
  FrameResult Process(const cv::Mat& gray, double time);

  /// As Odometry::ProcessUnreadable; `problem`: why there is no image.
  FrameResult ProcessUnreadable(double time, const std::string& problem);

  /// As Odometry::Finish.
  void Finish();

  int frames() const { return frames_; }

  /// There is a map, or there was.
  bool tracks() const { return tracks_; }

  /// Warnings that the camera was moved on the car, as far as they have not been taken yet. Take them after each frame,
  /// and after Finish, also where it fails.
  std::vector<std::string> TakeMoveWarnings();

  /// The images before the map.
  const SeenImages& seen() const { return seen_; }

  /// The camera-to-vehicle rotation from the first frame on.
  const std::vector<RotationRecord>& rotations() const { return rotations_; }

  /// Those of the frames so far.
  RefinedResults Refined() const;

  /// All that the drive tells, by these results. Its warnings are those that follow from them.
  RunSummary Summary(const RunInput& given, const RefinedResults& results, const RunEnding& ending = {}) const;

 private:
  // Where an image shows a landmark. Landmarks may move to other indices; the pixel of their reference view stays.
  struct TrackedPixel {
    cv::Point2f pixel;
    cv::Point2f reference;
  };

  void Keep(const FrameResult& result);
  DriveFacts Facts(const RunInput& given, const RunEnding& ending, const RefinedResults& results) const;
  // Points of the scene that this image and the one before show.
  std::vector<MovedPoint> MovedPoints(const FrameResult& result);

  Odometry& odometry_;
  ImageScaling scaling_;
  ProcessClocks started_;
  int frames_ = 0;
  double first_time_ = 0;
  double last_time_ = 0;
  bool tracks_ = false;
  // Moves of the camera on the car whose warnings have been taken.
  int moves_ = 0;
  std::size_t jumps_ = 0;
  SeenImages seen_;
  BlendedFrames blended_;
  DoubleImages double_;
  // Of landmarks, in the image before; empty where it was not tracked.
  std::unordered_map<int, TrackedPixel> last_pixels_;
  cv::Size image_size_;
  std::vector<RotationRecord> rotations_;
  std::vector<UnreadableFrame> unreadable_;
  std::vector<double> latencies_;  // of images, seconds
  std::vector<int> repeated_;      // frames that repeat the one before, as known online
  std::optional<double> live_metric_from_;
};

/// Processes a frame as its source gives it: with its image, or skipped with a warning where that cannot be read.
FrameResult ProcessFrame(const SourceFrame& frame, DriveRecorder& recorder, Progress& progress);

}  // namespace turnscale
