// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/frames/clip_overlap.h"
#include "turnscale/frames/frame_reader.h"
#include "turnscale/frames/recording_time.h"
#include "turnscale/frames/video_clock.h"
#include "turnscale/frames/video_file.h"

namespace turnscale {

struct ClipOptions {
  bool timed = true;               ///< give each image its time; else only their numbers tell
  std::optional<double> fps = {};  ///< frames per second, instead of the videos' own time stamps
  bool in_any_order = false;       ///< only the times of recording tell how the clips follow one another
  double start = 0;                ///< images before this time of the drive are not given, seconds
};

/// Reads videos, one or several that continue one another, as one drive. A clip follows the end of the one before, one
/// frame interval after its last frame; where it is known when they were recorded (RecordingTimes), the time between
/// two clips is included. Images at the beginning of a clip that repeat the last ones of the clip before (ClipTail) are
/// left out.
class ClipReader : public FrameReader {
 public:
  /// A clip of several that cannot be decoded, as recorders leave them when the power goes, is left out where it is the
  /// first or the last one or the names tell how long it was (RecordingTimes). Throws InputError if there is no other,
  /// if a video has another image size than the first, or begins more than a few seconds before the one before it ends.
  ClipReader(const std::vector<std::filesystem::path>& clips, const ClipOptions& options);

  std::optional<DriveImage> Read() override;
  std::string EndsEarly() const override { return ends_early_; }
  std::string NoticeAtEnd() const override { return notice_; }

  /// Those that are read.
  const std::vector<std::filesystem::path>& clips() const { return clips_; }
  /// When the drive begins by the clips' names (RecordingTimes::Begin); empty if they do not tell.
  std::optional<double> RecordedFrom() const { return recorded_ ? recorded_->Begin() : std::nullopt; }
  /// What the user should know about the times of recording, one line; may be empty.
  std::string NoticeOfTimes() const { return recorded_ ? recorded_->WhyNotByNames() : std::string(); }
  /// Why clips are left out, one line for each.
  const std::vector<std::string>& left_out() const { return left_out_; }

  /// Why the drive begins after it should; empty if it does not.
  std::string BeginsLate() const;

  /// Width of a pixel over its height, as the first clip says.
  double pixel_aspect() const { return headers_.front().pixel_aspect; }

  /// So many images at the beginning of the drive are not given.
  void Skip(size_t frames) { skip_ = frames; }
  double LatestTime() const override { return latest_; }

  /// Number of frames as the headers say; 0 if one does not.
  int count() const { return count_; }
  /// The same for a part of the drive, as for a constant rate; gaps count as far as the headers tell of them.
  int CountBetween(double start, const std::optional<double>& end) const;
  /// Whether the headers or the options tell the times of the frames.
  bool HasTimes() const;

 private:
  void ReadHeaders(const std::vector<std::filesystem::path>& clips);
  void Open();
  void Close();
  std::string LackBefore(size_t clip) const;
  void PassOverStart();
  std::optional<double> EndByStamps() const;
  std::optional<double> TimeNext();
  std::string StartsInGap(double time) const;
  void BeginNext(double seconds);
  void BeginAfterGap(double seconds, double gap, const std::string& why);

  std::vector<std::filesystem::path> clips_;
  ClipOptions options_;
  std::vector<VideoHeader> headers_;
  std::vector<std::string> left_out_;
  std::map<size_t, std::filesystem::path> left_out_before_;  // the first clip that is left out before a clip
  std::optional<RecordingTimes> recorded_;
  int count_ = 0;

  size_t clip_ = 0;
  std::unique_ptr<VideoFile> video_;
  VideoClock clock_{0, 0};
  double begin_ = 0;                    // of the clip, in the drive
  int frames_ = 0;                      // of the clip
  std::optional<double> latest_stamp_;  // of the clip
  double new_from_ =
      -std::numeric_limits<double>::infinity();  // time of the drive: the clip before has what is earlier
  ClipTail tail_;                                // of the clip, by times of the drive
  size_t skip_ = 0;
  size_t passed_ = 0;  // of the drive
  double latest_ = 0;
  bool open_ = false;
  bool begun_ = false;   // an image has been given
  std::string overlap_;  // its notice, before the next image
  bool overlap_named_ = false;
  double gap_ = 0;            // before the next image
  bool unknown_gap_ = false;  // before the next image
  double likely_gap_ = 0;     // before the next image
  std::string notice_;        // before the next image
  std::string lacks_;         // before the next image
  std::string ends_early_;
};

}  // namespace turnscale
