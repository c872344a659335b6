// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/evaluation/association.h"
#include "turnscale/io/floor_plan_file.h"
#include "turnscale/report/thumbnails.h"
#include "turnscale/run/result_folder.h"

namespace turnscale {

/// A number for the top of the page, as text.
struct ReportFact {
  std::string name;
  std::string value;
  std::string note;  ///< such as its sigma; may be empty
};

/// What a page shows. Whatever is empty is left out of it.
struct ReportData {
  std::string title;  ///< a path is shortened, see ShortPath
  std::string version;
  bool metric = false;                ///< lengths are metres, else the odometry's unit
  std::vector<std::string> warnings;  ///< on top
  std::vector<std::string> notes;     ///< below the title: what was done
  std::vector<ReportFact> facts;
  std::vector<FrameResult> frames;
  bool timed = true;                  ///< else the times are the numbers of the poses
  std::optional<double> time_origin;  ///< that the page counts from, seconds; empty: TimeOrigin
  bool has_tracking = true;           ///< the frames say how they were tracked; else they are poses only
  bool has_scale_state = true;        ///< the frames say how their scale is known
  Eigen::Quaterniond vehicle_from_body = Eigen::Quaterniond::Identity();
  std::vector<TurnResult> turns;
  std::vector<SpeedReading> speeds;
  std::vector<ScaleRow> scale;
  std::vector<RotationRow> rotations;
  std::vector<Eigen::Vector3f> landmarks;
  std::vector<Thumbnail> thumbnails;
  /// The estimate's poses with the true ones, in any world frames. Their first poses are drawn one on the other;
  /// without metres the truth is scaled and laid on the whole path.
  PosePairs truth;
  std::vector<ReportFact> errors;  ///< from the comparison with the truth
  FloorPlan outlines;              ///< in the frame of the true poses, seen from above (x right, z ahead)
  std::string settings;
  std::string earlier;  ///< data of an earlier page of the same path: its truth is kept where `truth` is empty
};

/// Upper bounds, so that the page of a long drive opens quickly.
struct ReportLimits {
  int path_points = 5000;
  int landmarks = 50000;
  int scale_points = 2000;
  int truth_points = 2500;
};

/// A file or folder as the page names it, with the folder it is in: the rest of the path may tell who the reader of the
/// page need not know.
std::string ShortPath(const std::string& path);

/// The time that the page counts from, seconds: that of the first frame if the times are those of a clock (since 1970,
/// or since a machine was started), else 0.
double TimeOrigin(const std::vector<FrameResult>& frames);

/// The data as the page reads it (web/src/report.ts), JSON without '<'. Positions are in level axes (LevelFromWorld).
std::string ReportJson(const ReportData& data, const ReportLimits& limits = {});

}  // namespace turnscale
