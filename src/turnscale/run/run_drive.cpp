// SPDX-License-Identifier: MIT
#include "turnscale/run/run_drive.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/frames/frame_reader.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/terminal.h"
#include "turnscale/odometry/drive_speed.h"
#include "turnscale/run/drive_recorder.h"
#include "turnscale/run/frame_warnings.h"
#include "turnscale/run/settings.h"
#include "turnscale/run/vehicle_file.h"

namespace turnscale {
namespace {

// Why the summary does not call a run complete.
enum class Stop {
  kNo,
  kLacksImages,  // of the drive
  kMaxFrames,
  kInterrupted,
  kFailed,          // an exception, also where the results are computed or written
  kNothingTracked,  // from the first frame to the last
};

class Run {
 public:
  Run(const DriveToRun& drive, Odometry& odometry, Progress& progress)
      : drive_(drive),
        odometry_(odometry),
        progress_(progress),
        frame_(drive.next()),
        recorder_(odometry, drive.scaling, drive.started),
        warnings_(drive.warnings) {
    for (std::size_t i = drive.warned; i < warnings_.size(); ++i) progress_.Warn(warnings_[i]);
  }

  RunEnd Go() {
    if (!attempts_.Try([&] { stop_ = ProcessFrames(); })) stop_ = Stop::kFailed;
    attempts_.Try([&] { LookAtEnd(); });
    progress_.Finish();
    if (stop_ == Stop::kInterrupted && recorder_.frames() == 0) return End(Known());
    if (recorder_.tracks() && !begun_) attempts_.RethrowFirst();
    if (writer_) attempts_.Try([&] { writer_->EndLive(); });
    attempts_.Try(drive_.concluding);
    Adjust();
    if (!recorder_.tracks()) ConcludeWithoutMap();
    if (stop_ == Stop::kNo && !attempts_.failures().empty()) stop_ = Stop::kFailed;
    RunSummary summary = Known();
    attempts_.Try([&] {
      summary = Summary();
      Publish(summary);
    });
    return End(std::move(summary));
  }

 private:
  Stop ProcessFrames() {
    for (; frame_; frame_ = drive_.next()) {
      if (drive_.interrupted()) return Stop::kInterrupted;
      if (Enough()) return Stop::kMaxFrames;
      Process(*frame_);
    }
    return Stop::kNo;
  }

  void LookAtEnd() {
    at_end_ = drive_.at_end();
    if (stop_ != Stop::kNo || Enough()) return;
    if (!at_end_.notice.empty()) Warn(at_end_.notice);
    if (!at_end_.ends_early.empty()) Warn(at_end_.ends_early);
    if (!LackingImages().empty()) stop_ = Stop::kLacksImages;
  }

  // Of the beginning of the drive, within it, and of its end.
  std::string LackingImages() const {
    std::string why = at_end_.begins_late;
    AddSentence(why, at_end_.lacks);
    AddSentence(why, at_end_.ends_early);
    return why;
  }

  bool Enough() const { return drive_.max_frames && recorder_.frames() >= *drive_.max_frames; }

  // What has been printed belongs in the summary, too.
  void Warn(const std::string& warning) {
    progress_.Warn(warning);
    warnings_.push_back(warning);
  }

  void WarnOfMoves() {
    for (const std::string& warning : recorder_.TakeMoveWarnings()) Warn(warning);
  }

  // Takes earlier results away and begins new ones.
  void Begin() {
    writer_.emplace(drive_.output);
    stale_ = drive_.replacing();
    Settings settings = drive_.settings;
    settings.odometry = odometry_.options();
    writer_->WriteText(RunFiles::kSettings, SettingsText(settings));
    const std::optional<FoundCamera>& found = drive_.given.found_camera;
    if (found) writer_->WriteText(RunFiles::kCamera, FoundCameraText(*found, std::nullopt, false));
    begun_ = true;
  }

  void Process(const SourceFrame& frame) {
    if (!frame.notice.empty()) Warn(frame.notice);
    const FrameResult result = ProcessFrame(frame, recorder_, progress_);
    if (recorder_.tracks() && !begun_) Begin();
    if (writer_) writer_->Add(result, odometry_.mount().At(0));
    if (drive_.watch) drive_.watch(frame, result, odometry_);
    WarnOfMoves();
    progress_.Update(recorder_.frames(), fmt::format("{} keyframes, scale {}", odometry_.map().keyframes.size(),
                                                     ScaleStateName(odometry_.scale_state())));
  }

  // The final adjustment may take minutes, or fail: the results are written without it first, with a summary, so that
  // they can be read if the process is killed meanwhile.
  void Adjust() {
    Keep(Durability::kProcess);
    if (writer_) attempts_.Try([&] { SummarizeSoFar(); });
    const bool finished = attempts_.Try([&] {
      if (writer_) progress_.Say("final adjustment");
      recorder_.Finish();
    });
    progress_.Say("");
    WarnOfMoves();
    if (finished) Keep(Durability::kPowerCut);
  }

  // Writes the results, as far as there are any.
  void Keep(Durability durability) {
    if (!attempts_.Try([&] { results_ = recorder_.Refined(); }) || !writer_) return;
    const std::vector<FrameResult>& frames = results_.frames;
    const RefinedScale& scale = results_.scale;
    const Eigen::Quaterniond& first_rotation = odometry_.mount().At(0);
    const ScaleState state = StateAtEnd(scale);
    attempts_.Try([&] { writer_->WriteTrajectory(frames, first_rotation, state, durability); });
    attempts_.Try([&] { writer_->WriteTurns(scale.turns, durability); });
    attempts_.Try([&] {
      writer_->WriteSpeeds(SpeedsOf(frames, odometry_.options().vehicle.lever_arm.value_or(0.0)), durability);
    });
    attempts_.Try([&] { writer_->WriteScale(odometry_.map(), scale, durability); });
    attempts_.Try([&] { writer_->WriteRotations(recorder_.rotations(), durability); });
    attempts_.Try([&] {
      writer_->WriteText(RunFiles::kCar,
                         VehicleFileText(odometry_.options().vehicle, odometry_.mount().current(), scale), durability);
    });
    if (const std::optional<FoundCamera>& found = drive_.given.found_camera)
      attempts_.Try([&] {
        writer_->WriteText(RunFiles::kCamera, FoundCameraText(*found, scale.readout, scale.calibration_windows > 0),
                           durability);
      });
    attempts_.Try([&] { writer_->WriteMask(drive_.scaling.FullMask(odometry_.mask()), durability); });
    attempts_.Try([&] { writer_->WriteMap(odometry_.RefinedMap(scale), first_rotation, state, durability); });
  }

  // Only the summary is written, unless the folder keeps the results of an earlier run.
  void ConcludeWithoutMap() {
    const bool keeps_earlier = HasPosesOfRun(drive_.output.folder);
    if (stop_ != Stop::kInterrupted && attempts_.failures().empty()) {
      const std::string why = recorder_.seen().Explanation(drive_.left);
      if (Enough() && !keeps_earlier) {
        Warn(why);
      } else {
        stop_ = Stop::kNothingTracked;
        nothing_tracked_ = why;
      }
    }
    if (keeps_earlier) {
      progress_.Warn(
          fmt::format("there are no results; {} keeps those of an earlier run", drive_.output.folder.string()));
    } else {
      attempts_.Try([&] { Begin(); });
    }
  }

  // For the summary; empty where the drive was processed to its end.
  std::string StopText() const {
    switch (stop_) {
      case Stop::kNo:
        return "";
      case Stop::kLacksImages:
        return LackingImages();
      case Stop::kMaxFrames:
        return fmt::format("--max-frames {}", *drive_.max_frames);
      case Stop::kInterrupted:
        return recorder_.frames() == 0 ? "interrupted before the first frame"
                                       : fmt::format("interrupted after {} frame{}", recorder_.frames(),
                                                     recorder_.frames() == 1 ? "" : "s");
      case Stop::kFailed:
        return FailureOf(attempts_.failures().front()).message;
      case Stop::kNothingTracked:
        return nothing_tracked_;
    }
    return "";
  }

  RunEnding Ending() const {
    return {.clips = at_end_.clips,
            .is_part = stop_ == Stop::kInterrupted || stop_ == Stop::kMaxFrames || at_end_.leaves_out,
            .stopped = StopText()};
  }

  // What is known of the run without its results.
  RunSummary Known() const {
    RunSummary summary;
    summary.drive.given = drive_.given;
    summary.drive.ending = Ending();
    summary.warnings = warnings_;
    return summary;
  }

  RunSummary Summary() const {
    RunSummary summary = recorder_.Summary(drive_.given, results_, Ending());
    summary.warnings.insert(summary.warnings.begin(), warnings_.begin(), warnings_.end());
    if (!stale_.empty()) summary.warnings.push_back(stale_);
    return summary;
  }

  void SummarizeSoFar() {
    RunSummary summary = Summary();
    std::string& stopped = summary.drive.ending.stopped;
    stopped += (stopped.empty() ? "" : "; ") + std::string("the final adjustment was not finished");
    writer_->WriteText(RunFiles::kSummary, SummaryJson(summary), Durability::kProcess);
  }

  // Prints what only the results show, and writes the summary.
  void Publish(const RunSummary& summary) {
    // Each image that cannot be used has been named when it came, instead of all in one line.
    const std::vector<UnreadableFrame>& frames = summary.drive.images.unreadable;
    const std::string unreadable = frames.empty() ? "" : UnreadableText(frames);
    for (std::size_t i = warnings_.size(); i < summary.warnings.size(); ++i)
      if (summary.warnings[i] != unreadable) progress_.Warn(summary.warnings[i]);
    if (!writer_) return;
    writer_->WriteText(RunFiles::kSummary, SummaryJson(summary));
    // Of a run without a pose, whose folder was known by it until here.
    writer_->EndLive();
  }

  RunEnd End(RunSummary summary) const {
    return {.summary = std::move(summary),
            .interrupted = stop_ == Stop::kInterrupted,
            .begun = recorder_.tracks(),
            .written = writer_.has_value(),
            .nothing_tracked = nothing_tracked_,
            .failures = attempts_.failures()};
  }

  const DriveToRun& drive_;
  Odometry& odometry_;
  Progress& progress_;
  std::optional<SourceFrame> frame_;
  DriveRecorder recorder_;
  std::vector<std::string> warnings_;  // until now: all of them have been printed
  Stop stop_ = Stop::kNo;
  EndOfDrive at_end_;
  std::string nothing_tracked_;      // RunEnd's
  std::optional<RunWriter> writer_;  // once there is something to write
  bool begun_ = false;               // and its first files are
  RefinedResults results_;           // the latest that could be computed
  Attempts attempts_;
  std::string stale_;  // what stays of an earlier run
};

}  // namespace

RunEnd RunDrive(const DriveToRun& drive, Odometry& odometry, Progress& progress) {
  return Run(drive, odometry, progress).Go();
}

}  // namespace turnscale
