// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/frames/image_scaling.h"
#include "turnscale/frames/image_source.h"
#include "turnscale/frames/seen_images.h"
#include "turnscale/io/terminal.h"
#include "turnscale/odometry/odometry.h"
#include "turnscale/run/drive_facts.h"
#include "turnscale/run/run_cost.h"
#include "turnscale/run/run_summary.h"
#include "turnscale/run/run_writer.h"
#include "turnscale/run/settings.h"

namespace turnscale {

/// What the end of a drive, or of the part that is processed, shows.
struct EndOfDrive {
  std::string begins_late = {};      ///< why the drive begins after it should, which `warnings` tell; may be empty
  std::string lacks = {};            ///< why images within it are missing, which notices tell; may be empty
  std::string ends_early = {};       ///< why the drive ends before it should; empty if it does not
  std::string notice = {};           ///< what the user should know about the drive after its last frame; may be empty
  bool leaves_out = false;           ///< the drive has images outside the part of it that was asked for
  std::vector<ClipPart> clips = {};  ///< the videos of the drive; empty for images
};

/// A drive that the odometry is to be run over.
struct DriveToRun {
  std::function<std::optional<SourceFrame>()> next;                  ///< the next frame; nothing at the end
  std::function<bool()> interrupted = [] { return false; };          ///< asked before every frame
  std::function<EndOfDrive()> at_end = [] { return EndOfDrive(); };  ///< asked once, after the last frame
  std::optional<int> max_frames = {};                                ///< where to stop early
  ImageScaling scaling = {};                                         ///< of the frames; results are at full size
  Settings settings = {};                                            ///< kept beside the results
  RunWriterOptions output;                                           ///< where the results go
  RunInput given;                                                    ///< what the run was given, for its summary
  std::vector<std::string> warnings = {};                            ///< of the drive, known beforehand
  std::size_t warned = 0;                                            ///< this many of them are printed
  ProcessClocks started = ReadClocks();                              ///< from when on its cost counts
  /// Called after every frame with its result. What it throws ends the run.
  std::function<void(const SourceFrame&, const FrameResult&, const Odometry&)> watch = {};
  /// Called when no frame follows, before the final adjustment, which may take minutes.
  std::function<void()> concluding = [] {};
  /// Called before the first result is written, when those of an earlier run are taken away. Says which of its files
  /// stay, in one line for the summary; empty where none do.
  std::function<std::string()> replacing = [] { return std::string(); };
  LeftByOptions left = {};  ///< of the drive and its images, by what was asked for
};

/// How a run ended.
struct RunEnd {
  RunSummary summary;
  bool interrupted = false;
  bool begun = false;    ///< there is a pose
  bool written = false;  ///< the folder has what this run computed, and nothing of an earlier one
  /// Why nothing could be tracked from the first frame to the last, and what to try; empty if a map began, or if the
  /// run stopped early as asked and wrote its summary.
  std::string nothing_tracked;
  /// What ended the run before the drive did or kept a result from being computed or written, in the order of time;
  /// empty where all went well.
  std::vector<std::exception_ptr> failures;
};

/// Runs the odometry from the first frame to the files of the results. Whatever ends it, all that was computed is
/// written as at a normal end, each file whether or not the others can be, and summary.json says why it is incomplete.
/// Results of an earlier run are replaced when there is a first pose; a run without one leaves them as they are. A run
/// that is interrupted before the first frame writes nothing. Throws what the first frame, the folder and settings.yaml
/// throw, as then there is no result yet.
RunEnd RunDrive(const DriveToRun& drive, Odometry& odometry, Progress& progress);

}  // namespace turnscale
