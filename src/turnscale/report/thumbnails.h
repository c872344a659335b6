// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/odometry/odometry.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// Why a frame has a thumbnail.
enum class ThumbnailReason {
  kDrive,  ///< one of many along the drive
  kTurn,   ///< in a turn
  kLost,   ///< tracking failed
};

/// The image did not give the pose: tracking failed in it, or it cannot be read.
bool IsLost(TrackingState state);

/// "drive", "turn" or "lost".
const char* ThumbnailReasonName(ThumbnailReason reason);

/// A small picture of a frame; its comments tell the features that were tracked and the pixels that were left out.
struct Thumbnail {
  int frame = 0;
  double time = 0;  ///< seconds
  ThumbnailReason reason = ThumbnailReason::kDrive;
  std::string jpeg;  ///< the file, see AnnotatedJpeg
};

/// A tracked feature in the image as it came.
struct DrawnFeature {
  cv::Point2f pixel;
  bool has_depth = false;
};

/// What the latest image of the odometry shows.
std::vector<DrawnFeature> FeaturesOf(const Odometry& odometry);

/// The gray image as a colour image of at most this width: features as dots (green with a depth, amber without),
/// left-out pixels (0 in `mask`, which may be empty) tinted red.
cv::Mat DrawTracking(const cv::Mat& gray, const std::vector<DrawnFeature>& features, const cv::Mat& mask, int width);

/// The gray image as a JPEG file of at most this width. What DrawTracking draws is in comments (COM segments), for a
/// page that draws it on demand: "turnscale features" and "turnscale mask", each ended by a zero byte. Then follow
/// points of three bytes: 12 bits of x and 11 of y, high first, as shares of the width and height less one pixel, and a
/// bit that is 1 for a feature with a depth. Contours of the mask begin with their number of points, two bytes, high
/// first; what an odd number of them encloses is left out. Throws InternalError if the image cannot be encoded.
std::string AnnotatedJpeg(const cv::Mat& gray, const std::vector<DrawnFeature>& features, const cv::Mat& mask,
                          int width, int quality);

struct ThumbnailOptions {
  int width = 480;       ///< pixels, at most
  int quality = 60;      ///< of the JPEG, per cent
  double interval = 1;   ///< seconds of driving between thumbnails of a short drive
  double turn_rate = 8;  ///< of a turn that deserves thumbnails, degrees/s
  /// Bytes of all thumbnails; in a page they take a third more.
  std::size_t budget = 2'100'000;
};

/// Keeps thumbnails of a drive within a budget: when it is spent, every second one of the most numerous kind is dropped
/// and the interval of that kind doubled; one of each kind stays. The same drive gives the same thumbnails.
class ThumbnailCollector {
 public:
  explicit ThumbnailCollector(const ThumbnailOptions& options = {}) : options_(options) {}

  /// After each frame: `gray` is its image (empty: none), `frame` its result.
  void Add(const cv::Mat& gray, const FrameResult& frame, const Odometry& odometry);

  /// In the order of time.
  const std::vector<Thumbnail>& thumbnails() const { return thumbnails_; }

 private:
  bool IsDue(const FrameResult& frame, ThumbnailReason& reason);
  void KeepWithinBudget();
  void DropEverySecond(ThumbnailReason reason);

  ThumbnailOptions options_;
  std::vector<Thumbnail> thumbnails_;
  double last_time_ = -1e300;
  double last_turn_time_ = -1e300;
  double last_keyframe_time_ = -1e300;
  TrackingState last_state_ = TrackingState::kInitializing;
  double interval_factor_ = 1;
  double turn_interval_factor_ = 1;
  std::size_t bytes_ = 0;
};

/// Writes the thumbnails to `folder`/thumbnails, in place of those of an earlier run. Throws OutputError.
void WriteThumbnails(const std::filesystem::path& folder, const std::vector<Thumbnail>& thumbnails);

/// Takes away the thumbnails of an earlier run; other files stay.
void RemoveThumbnails(const std::filesystem::path& folder);

/// Those that WriteThumbnails has written, in the order of time; `frames` are those of the run.
std::vector<Thumbnail> ReadThumbnails(const std::filesystem::path& folder, const std::vector<FrameResult>& frames);

}  // namespace turnscale
