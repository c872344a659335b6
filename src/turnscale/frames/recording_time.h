// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "turnscale/frames/video_file.h"

namespace turnscale {

/// Time of day in a file name: year, month, day, hour, minute and second, with or without single separators between
/// them, such as 20230501_120000. In seconds since 1970 on the recorder's clock, whatever its time zone.
std::optional<double> TimeInName(std::string_view name);

/// The same with a year of two digits, such as 230501_120000 or 23-05-01_12-00-00: with a separator between date and
/// time, and alike within each of them. Other numbers may look so, too.
std::optional<double> ShortTimeInName(std::string_view name);

/// Such as 2023-05-01T12:00:00: of seconds as TimeInName has them, which are rounded down.
std::string RecorderTimeText(double seconds);

/// When the clips of a drive were recorded, to the second. Cameras that split a recording may write the creation time
/// of its beginning into all of its files: clips with the same creation time follow one another without a gap.
class RecordingTimes {
 public:
  /// From the names of the files if all have a time, else from the creation times in the files if all have one. Times
  /// with a year of two digits (ShortTimeInName) count only where the clips follow one another by them, as
  /// CheckContinuity demands: other numbers and other orders of day, month and year hardly do.
  RecordingTimes(const std::vector<std::filesystem::path>& clips, const std::vector<VideoHeader>& headers);

  bool AreKnown() const { return !starts_.empty() && !guessed_; }
  /// The first clip that is only taken to follow the one before: both have the same creation time, as clips of two
  /// cameras have, and the names do not tell that it is the next chapter. Empty if there is none.
  std::optional<size_t> Guessed() const { return guessed_; }
  /// The names tell when each clip began; creation times may be those of the end.
  bool AreInNames() const { return by_name_; }
  /// When the first clip began by its name, as TimeInName has it; empty if the names do not tell.
  std::optional<double> Begin() const { return by_name_ ? std::optional(starts_.front()) : std::nullopt; }
  /// Why times in the names are not used though nothing else tells, one line; empty if there are none, or they are not
  /// needed.
  const std::string& WhyNotByNames() const { return why_not_by_names_; }

  /// Throws InputError if a clip begins more than a few seconds before the one before it ends (kLongestOverlap), or so
  /// long after it that it is of another drive, or where a chapter of a recording is missing and no time tells how long
  /// it was.
  void CheckContinuity() const;

  /// Seconds between the end of a clip of that duration and the start of the next; 0 if they continue one another or
  /// nothing tells.
  double GapAfter(size_t clip, double duration) const;
  /// The same where images are missing between the two clips (ClipTail::JumpsTo), which a pause within the resolution
  /// of the times may hold: half a second or more; 0 if nothing tells when they were recorded, or the names leave no
  /// time for a gap.
  double GapAtJump(size_t clip, double duration) const;
  /// The same where the names tell a pause that is within the resolution of their times, but longer than rounding them
  /// explains: about a second or more.
  double LikelyGapAfter(size_t clip, double duration) const;
  /// Seconds by which the next clip begins before the end of a clip of that duration; 0 if it does not, or if nothing
  /// tells.
  double OverlapAfter(size_t clip, double duration) const;

 private:
  bool Coincides(size_t clip) const;
  bool OverlapsTooFar(size_t clip) const;
  std::optional<size_t> FirstApart() const;
  std::string PlaceAfter(size_t clip) const;
  void PlaceCoinciding();
  void CheckChapters() const;
  double PauseAfter(size_t clip, double duration) const;

  std::vector<std::filesystem::path> clips_;
  std::vector<double> durations_;  // as the headers say
  std::vector<double> created_;    // empty unless the starts are from them
  std::vector<double> starts_;     // empty if unknown
  std::optional<size_t> guessed_;
  bool by_name_ = false;
  std::string why_not_by_names_;
};

}  // namespace turnscale
