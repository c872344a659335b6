// SPDX-License-Identifier: MIT
#include "turnscale/io/run_drive.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/io/drive_recorder.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/settings.h"
#include "turnscale/io/terminal.h"
#include "turnscale/io/vehicle_file.h"
#include "turnscale/odometry/drive_speed.h"

namespace turnscale {
namespace {

// What the odometry says of the drive so far.
struct RunResults {
  std::vector<FrameResult> frames;
  RefinedScale scale;
};

RunResults ResultsOf(const Odometry& odometry) {
  RefinedScale scale = odometry.Refined();
  std::vector<FrameResult> frames = odometry.RefinedFrames(scale);
  return {std::move(frames), std::move(scale)};
}

class Run {
 public:
  Run(const DriveToRun& drive, Odometry& odometry, Progress& progress)
      : drive_(drive), odometry_(odometry), progress_(progress), frame_(drive.next()), recorder_(odometry) {
    end_.summary = drive.summary;
    for (const std::string& warning : drive.summary.warnings) progress_.Warn(warning);
    printed_ = drive.summary.warnings.size();
  }

  RunEnd Go() {
    if (!attempts_.Try([&] { Drive(); })) end_.summary.stopped = FailureOf(attempts_.failures().front()).message;
    progress_.Finish();
    if (end_.interrupted && recorder_.frames() == 0) return end_;
    if (recorder_.tracks() && !begun_) attempts_.RethrowFirst();
    if (writer_) attempts_.Try([&] { writer_->EndLive(); });
    attempts_.Try(drive_.concluding);
    Conclude();
    const bool keeps_earlier = !recorder_.tracks() && HasPosesOfRun(drive_.output.folder);
    if (!recorder_.tracks() && !end_.interrupted && attempts_.failures().empty()) {
      const std::string why = recorder_.seen().Explanation(drive_.left);
      if (Enough() && !keeps_earlier) {
        Warn(why);
      } else {
        end_.nothing_tracked = why;
        end_.summary.stopped = why;
      }
    }
    if (keeps_earlier) {
      progress_.Warn(
          fmt::format("there are no results; {} keeps those of an earlier run", drive_.output.folder.string()));
    } else if (!writer_) {
      attempts_.Try([&] { Begin(); });
    }
    attempts_.Try([&] { Summarize(); });
    end_.begun = recorder_.tracks();
    end_.written = writer_.has_value();
    end_.failures = attempts_.failures();
    return end_;
  }

 private:
  void Drive() {
    for (; frame_ && !Stops(); frame_ = drive_.next()) Process(*frame_);
    if (frame_ || Enough()) return;
    if (const std::string notice = drive_.notice_at_end(); !notice.empty()) Warn(notice);
    end_.summary.stopped = drive_.ends_early();
    if (!end_.summary.stopped.empty()) Warn(end_.summary.stopped);
  }

  void Warn(const std::string& warning) {
    progress_.Warn(warning);
    Record(warning);
  }

  // What has been printed belongs in the summary, too.
  void Record(const std::string& warning) {
    end_.summary.warnings.push_back(warning);
    printed_ = end_.summary.warnings.size();
  }

  // Takes earlier results away and begins new ones.
  void Begin() {
    writer_.emplace(drive_.output);
    stale_ = drive_.replacing();
    writer_->WriteText(RunFiles::kSettings, SettingsText(odometry_.options()));
    const std::optional<FoundCamera>& found = drive_.summary.found_camera;
    if (found) writer_->WriteText(RunFiles::kCamera, FoundCameraText(*found));
    begun_ = true;
  }

  bool Enough() const { return drive_.max_frames && recorder_.frames() >= *drive_.max_frames; }

  bool Stops() {
    end_.interrupted = drive_.interrupted();
    if (end_.interrupted) {
      const int frames = recorder_.frames();
      end_.summary.stopped = frames == 0 ? "interrupted before the first frame"
                                         : fmt::format("interrupted after {} frame{}", frames, frames == 1 ? "" : "s");
    } else if (Enough()) {
      end_.summary.stopped = fmt::format("--max-frames {}", *drive_.max_frames);
    }
    return !end_.summary.stopped.empty();
  }

  void Process(const SourceFrame& frame) {
    FrameResult result;
    if (!frame.notice.empty()) Warn(frame.notice);
    if (frame.gray.empty()) {
      progress_.Warn(fmt::format("frame {}: {}; skipped", frame.index, frame.problem));
      result = recorder_.ProcessUnreadable(frame.time, frame.problem);
    } else {
      result = recorder_.Process(frame.gray, frame.time);
    }
    if (recorder_.tracks() && !begun_) Begin();
    if (writer_) {
      writer_->SetFirstCameraRotation(odometry_.mount().At(0));
      writer_->Add(result);
    }
    if (drive_.watch) drive_.watch(frame, result, odometry_);
    if (recorder_.camera_moved()) Warn(CameraMovedWarning(frame.index));
    progress_.Update(recorder_.frames(), fmt::format("{} keyframes, scale {}", odometry_.map().keyframes.size(),
                                                     ScaleStateName(odometry_.scale_state())));
  }

  // The final adjustment may take minutes, or fail: the results are written without it first, with a summary, so that
  // they can be read if the process is killed meanwhile.
  void Conclude() {
    Keep(Durability::kProcess);
    if (writer_) attempts_.Try([&] { SummarizeSoFar(); });
    const bool finished = attempts_.Try([&] {
      if (writer_) progress_.Say("final adjustment");
      recorder_.Finish();
    });
    progress_.Say("");
    if (finished) Keep(Durability::kPowerCut);
  }

  // Writes the results, as far as there are any.
  void Keep(Durability durability) {
    RunResults results;
    if (!attempts_.Try([&] { results = ResultsOf(odometry_); })) return;
    if (!writer_) {
      results_ = std::move(results);
      return;
    }
    writer_->SetFirstCameraRotation(odometry_.mount().At(0));
    const ScaleState state = StateAtEnd(results.scale);
    attempts_.Try([&] { writer_->WriteTrajectory(results.frames, state, durability); });
    attempts_.Try([&] { writer_->WriteTurns(results.scale.turns, durability); });
    attempts_.Try([&] {
      writer_->WriteSpeeds(SpeedsOf(results.frames, odometry_.options().vehicle.lever_arm.value_or(0.0)), durability);
    });
    attempts_.Try([&] { writer_->WriteScale(odometry_.map(), results.scale, durability); });
    attempts_.Try([&] { writer_->WriteRotations(recorder_.rotations(), durability); });
    attempts_.Try([&] {
      writer_->WriteText(RunFiles::kCar,
                         VehicleFileText(odometry_.options().vehicle, odometry_.mount().current(), results.scale),
                         durability);
    });
    attempts_.Try([&] { writer_->WriteMask(drive_.scaling.FullMask(odometry_.mask()), durability); });
    attempts_.Try([&] { writer_->WriteMap(odometry_.RefinedMap(results.scale), state, durability); });
    for (ParameterEstimate& estimate : results.scale.contradicted_calibration) estimate = drive_.scaling.Full(estimate);
    results_ = std::move(results);
  }

  // What a part of the drive lacks, the rest may have.
  void SayIfPart(RunSummary& summary) const {
    const bool cut = end_.interrupted || (Enough() && !end_.summary.stopped.empty());
    if ((cut || drive_.leaves_out()) && summary.has_measure() && !summary.pending_reason.empty())
      summary.pending_reason += "; only a part of the drive was processed, process more of it";
  }

  // What the drive and the odometry say.
  void Fill(RunSummary& summary) const {
    summary.clips = drive_.clips();
    recorder_.Summarize(results_.frames, results_.scale, summary);
    const cv::Size full = drive_.scaling.Full(cv::Size(summary.image_width, summary.image_height));
    summary.image_width = full.width;
    summary.image_height = full.height;
    summary.pinhole = drive_.scaling.Full(odometry_.camera()).pinhole;
    if (recorder_.tracks()) SayIfPart(summary);
    if (!stale_.empty()) summary.warnings.push_back(stale_);
    summary.frames = std::max(summary.frames, recorder_.frames());
  }

  void SummarizeSoFar() {
    RunSummary summary = end_.summary;
    if (!recorder_.unreadable().empty()) summary.warnings.push_back(UnreadableText(recorder_.unreadable()));
    Fill(summary);
    summary.stopped += (summary.stopped.empty() ? "" : "; ") + std::string("the final adjustment was not finished");
    writer_->WriteText(RunFiles::kSummary, SummaryJson(summary), Durability::kProcess);
  }

  void Summarize() {
    RunSummary& summary = end_.summary;
    if (!recorder_.unreadable().empty()) Record(UnreadableText(recorder_.unreadable()));
    Fill(summary);
    for (size_t i = printed_; i < summary.warnings.size(); ++i) progress_.Warn(summary.warnings[i]);
    if (summary.stopped.empty() && !attempts_.failures().empty())
      summary.stopped = FailureOf(attempts_.failures().front()).message;
    if (!writer_) return;
    writer_->WriteText(RunFiles::kSummary, SummaryJson(summary));
    // Of a run without a pose, whose folder was known by it until here.
    writer_->EndLive();
  }

  const DriveToRun& drive_;
  Odometry& odometry_;
  Progress& progress_;
  std::optional<SourceFrame> frame_;
  DriveRecorder recorder_;
  std::optional<RunWriter> writer_;  // once there is something to write
  bool begun_ = false;               // and its first files are
  RunResults results_;               // the latest that could be computed
  Attempts attempts_;
  RunEnd end_;
  size_t printed_ = 0;  // warnings that have been printed
  std::string stale_;   // what stays of an earlier run
};

}  // namespace

RunEnd RunDrive(const DriveToRun& drive, Odometry& odometry, Progress& progress) {
  return Run(drive, odometry, progress).Go();
}

}  // namespace turnscale
