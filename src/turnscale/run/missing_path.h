// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/frames/seen_images.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// Why a part of the path is not measured.
enum class MissingReason {
  kNotBegun,     ///< before the map begins
  kLost,         ///< tracking failed: poses are interpolated, or extrapolated at the end
  kUnreadable,   ///< likewise, as none of its images could be read
  kNotRecorded,  ///< there are no images
};

/// A part of the drive in which the path is not measured.
struct MissingPart {
  MissingReason reason = MissingReason::kLost;
  double from = 0;  ///< time of the first frame without a measured pose, seconds; where there are no images, when the
                    ///< first of them would have come
  double to = 0;    ///< time of the next frame with a measured pose; at the end of the drive that of the last frame
  int frames = 0;   ///< in it
};

/// Where tracking was lost for so long that the map began anew, in a guessed unit of length.
struct MapRestart {
  int frame = 0;          ///< the new map's first
  double time = 0;        ///< of it, seconds
  double unit_sigma = 0;  ///< relative standard deviation of its unit of length from that before
  double turn_sigma = 0;  ///< standard deviation of the angle by which the car has turned since the map before, rad
  bool turn_is_measured = false;  ///< that angle, in the images on both sides
  double contrast_left = 1;  ///< ratio: of the first image that was not tracked, over that of the last one that was
};

/// All missing parts, in the order of time.
std::vector<MissingPart> FindMissingParts(const std::vector<FrameResult>& frames);

/// The longest parts, in the order of time.
std::vector<MissingPart> LongestParts(const std::vector<MissingPart>& parts, size_t most);

/// A part of a drive with its times counted from the drive's first frame, as texts have them.
template <class Part>
Part SinceFirst(Part part, double first_time) {
  part.from -= first_time;
  part.to -= first_time;
  return part;
}

/// Sum of their lengths, seconds.
double TotalSeconds(const std::vector<MissingPart>& parts);

/// The part before the first measured pose, with pauses of the recording in it. Nothing if the first frame is measured,
/// or none is.
std::optional<MissingPart> PartBeforeMap(const std::vector<FrameResult>& frames);

/// A map needs a moment to begin: a path that begins this much after the first frame is late, seconds.
inline constexpr double kLateSeconds = 2;

/// Whether a part before the map is at least kLateSeconds long, and that share of the drive.
bool IsLate(const MissingPart& before, const std::vector<FrameResult>& frames, double least_share);

/// Whether a part before the map is late, and most of the drive.
bool IsMostOfDrive(const MissingPart& before, const std::vector<FrameResult>& frames);

/// One line: until when there is no map. `frames`: of the whole drive.
std::string NoMapBeforeText(const MissingPart& before, int frames);

/// The same, and why, by the images until then, `seen`. Empty if they say that the car waits, which is no fault.
std::string LateBeginningText(const MissingPart& before, int frames, const SeenImages& seen);

/// How far the car drives before the map begins, if it has the speed of the first second after that: a rough estimate,
/// in the unit of the poses.
double LengthBefore(const MissingPart& before, const std::vector<FrameResult>& frames);

/// Whether the path between two frames that follow one another, by their times, is in one of the parts, which are in
/// the order of time.
bool IsMissing(const std::vector<MissingPart>& parts, double from, double to);

/// "before initialisation", "tracking lost", "images unreadable" or "not recorded".
const char* MissingReasonName(MissingReason reason);

/// Such as "tracking lost from 12.3 s to 15.1 s (28 frames)".
std::string MissingPartText(const MissingPart& part);

}  // namespace turnscale
