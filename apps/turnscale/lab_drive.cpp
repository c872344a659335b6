// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "lab_experiments.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/laboratory/parallel_runs.h"
#include "turnscale/laboratory/scale_drive.h"

namespace turnscale {
namespace {

constexpr std::array<const char*, 3> kLevelNames = {"low", "mid", "high"};
constexpr std::array<const char*, 3> kLevelColors = {"#1565c0", "#2e9e5b", "#e08a00"};
constexpr auto kOdometryColor = "#d32f2f";
constexpr auto kTurnColor = "#f6c343";

PlotPoints FromAbove(const std::vector<RigidTransform>& poses) {
  PlotPoints points;
  for (const RigidTransform& pose : poses) points.emplace_back(pose.translation.x(), pose.translation.z());
  return points;
}

ScaleDrive DriveOf(const LabSettings& settings, double pixel_noise) {
  ScaleDriveOptions options;
  options.pixel_noise = pixel_noise;
  options.seed = SeedOfRun(settings.seed, 0);
  return MakeScaleDrive(options);
}

PlotLine Squares(const std::vector<TurningRegion>& regions, const PlotPoints& path) {
  PlotLine squares{{}, "turning frames", "#1565c0", 1.2};
  squares.marker = 's';
  squares.marker_size = 3.5;
  for (const TurningRegion& region : regions) {
    for (int k = region.first; k <= region.last + 1; ++k) squares.points.push_back(path[k]);
  }
  return squares;
}

PlotPanel PanelFromAbove(const std::string& title) {
  PlotPanel panel;
  panel.title = title;
  panel.x_label = "x [m]";
  panel.y_label = "z [m]";
  panel.equal_axes = true;
  return panel;
}

// Steps from station to station of a path, each with its moment.
template <class Value>
PlotPoints OverSteps(const ScaleDrive& drive, const std::vector<RigidTransform>& poses, const Value& value) {
  PlotPoints points;
  for (std::size_t i = 1; i < drive.stations.size(); ++i) {
    const RigidTransform motion = poses[drive.stations[i - 1]].inverse() * poses[drive.stations[i]];
    points.emplace_back(drive.truth.keyframes[drive.stations[i]].frame,
                        value(TurningMotionOf(motion, Eigen::Quaterniond::Identity())));
  }
  return points;
}

double StepLength(const TurningMotion& motion) { return motion.step; }
double StepAngle(const TurningMotion& motion) { return motion.psi * kDegreesPerRadian; }
double StepObserved(const TurningMotion& motion) { return ObservedDistance(motion.psi, motion.theta, 1); }

std::vector<PlotArea> TurnAreas(const ScaleDrive& drive, const std::vector<TurningRegion>& regions, PlotRange y) {
  std::vector<PlotArea> areas;
  for (const TurningRegion& region : regions) {
    const double a = drive.truth.keyframes[region.first].frame;
    const double b = drive.truth.keyframes[region.last + 1].frame;
    areas.push_back({{{a, y.low}, {b, y.low}, {b, y.high}, {a, y.high}}, "turning regions", kTurnColor, 0.4});
  }
  return areas;
}

PlotPanel HistoryPanel(const std::string& title, const std::string& unit, PlotRange y) {
  PlotPanel panel;
  panel.title = title;
  panel.x_label = "frame";
  panel.y_label = unit;
  panel.x = PlotRange{0, 3500};
  panel.y = y;
  return panel;
}

struct Level {
  ScaleDrive drive;
  Map odometry;  // whose unit shrinks
  RecoveredScale recovered;
};

Level RunLevel(const LabSettings& settings, double pixel_noise) {
  const ScaleDriveOptions options;
  Level level{DriveOf(settings, pixel_noise), {}, {}};
  level.odometry = PointOdometry(level.drive);
  LoseScale(options.scale_loss, options.scale_loss_frames, level.odometry);
  level.recovered = RecoverScale({}, pixel_noise, level.odometry);
  return level;
}

}  // namespace

LabResult LabFigure8(const LabSettings& settings) {
  LabResult result;
  const Level level = RunLevel(settings, 1);
  if (!settings.progress(1, 1)) return {};
  const PlotPoints truth = FromAbove(KeyframePoses(level.drive.truth));
  PlotPanel map = PanelFromAbove("(a) trajectory and landmarks");
  PlotLine points{{}, "points", "#90a4ae", 1};
  points.marker = 'o';
  points.marker_size = 0.9;
  for (const Landmark& landmark : level.drive.truth.landmarks)
    points.points.emplace_back(landmark.position.x(), landmark.position.z());
  map.lines = {points, {truth, "true path", "#222", 1.6}};
  PlotPanel drift = PanelFromAbove("(b) odometry and detected turns");
  drift.lines = {{truth, "true path", "#222", 1.8},
                 {FromAbove(level.drive.odometry), "odometry", kOdometryColor, 1.8},
                 Squares(level.recovered.regions, truth)};
  result.figures.emplace_back("fig8", Figure{"Fig. 8: the synthetic drive", "", 2, 460, 460, {map, drift}});
  const ScaleDriveOptions options;
  double observations = 0;
  for (const Keyframe& keyframe : level.drive.truth.keyframes)
    observations += static_cast<double>(keyframe.observations.size());
  result.values = {
      {"length_m", options.drive.length},
      {"frames", options.drive.frames},
      {"turns", level.recovered.regions.size()},
      {"turn_radius_m", options.drive.turn_radius},
      {"lever_arm_m", options.drive.lever_arm},
      {"points", options.points},
      {"points_aside_m", options.points_aside},
      {"points_above_m", options.points_above},
      {"points_below_m", options.points_below},
      {"nearest_m", options.nearest},
      {"view_limit_m", options.view_limit},
      {"keyframes", level.drive.truth.keyframes.size()},
      {"steps", level.drive.stations.size() - 1},
      {"step_frames", options.step_frames},
      {"turning_keyframe_frames", options.turning_keyframe_frames},
      {"step_m", Rounded(options.drive.length / (options.drive.frames - 1) * options.step_frames)},
      {"sightings_per_keyframe", Rounded(observations / static_cast<double>(level.drive.truth.keyframes.size()))},
      {"rotation_noise_deg", Rounded(options.rotation_noise * kDegreesPerRadian)},
      {"turning_angle_deg", Rounded(kTurningAngle * kDegreesPerRadian)},
      {"loss_percent_a_step", 100 * options.scale_loss},
      {"loss_percent_in_all",
       Rounded(100 - 100 * std::pow(1 - options.scale_loss,
                                    static_cast<double>(options.drive.frames - 1) / options.scale_loss_frames))},
      {"loss_percent_in_all_every_frame",
       Rounded(100 - 100 * std::pow(1 - options.scale_loss, options.drive.frames - 1))}};
  return result;
}

LabResult LabFigure10(const LabSettings& settings) {
  LabResult result;
  std::vector<Level> levels(kPixelNoise.size());
  if (!ParallelRuns(
          static_cast<int>(levels.size()), settings.jobs,
          [&](int i) { levels[i] = RunLevel(settings, kPixelNoise[i]); }, settings.progress)) {
    return {};
  }
  const ScaleDrive& drive = levels[0].drive;
  const std::vector<RigidTransform> truth = KeyframePoses(drive.truth);
  PlotPanel psi = HistoryPanel("(a) turning angle from step to step", "psi [deg]", {-30, 30});
  PlotPanel observed = HistoryPanel("scale observed in each step (22)", "s [m]", {0, 6});
  PlotPanel recovered = HistoryPanel("scale after absolute scale recovery", "s [m]", {0, 6});
  PlotPanel paths = PanelFromAbove("(b) paths");
  for (PlotPanel* panel : {&psi, &observed, &recovered})
    panel->areas = TurnAreas(drive, levels[0].recovered.regions, *panel->y);
  PlotLine raw{OverSteps(drive, drive.odometry, StepLength), "odometry", kOdometryColor, 2};
  observed.lines.push_back(raw);
  recovered.lines.push_back(raw);
  paths.lines.push_back({FromAbove(truth), "truth", "#222", 4.5});
  paths.lines.push_back({FromAbove(drive.odometry), "odometry", kOdometryColor, 1.6});
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const std::string name = fmt::format("{} ({:g} px)", kLevelNames[i], kPixelNoise[i]);
    psi.lines.push_back({OverSteps(drive, KeyframePoses(levels[i].odometry), StepAngle), name, kLevelColors[i], 1.4});
    PlotLine dots{OverSteps(drive, KeyframePoses(levels[i].odometry), StepObserved), name, kLevelColors[i], 1};
    dots.marker = 'o';
    dots.marker_size = 1.8;
    observed.lines.push_back(dots);
    const std::vector<RigidTransform> poses = KeyframePoses(levels[i].recovered.map);
    recovered.lines.push_back({OverSteps(drive, poses, StepLength), name, kLevelColors[i], 1.4});
    paths.lines.push_back({FromAbove(poses), name, kLevelColors[i], 1.6});
    const ScaleErrors errors = MeasureScale(drive, poses, Eigen::Quaterniond::Identity(), kTurningAngle);
    result.values["levels"].push_back(
        {{"name", kLevelNames[i]},
         {"pixel_noise", kPixelNoise[i]},
         {"ratio_percent", Rounded(100 * errors.ratio)},
         {"end_error_m", Rounded((poses.back().translation - truth.back().translation).norm())}});
  }
  const PlotLine true_scale{OverSteps(drive, truth, StepLength), "truth", "#222", 1.4, "6 4"};
  observed.lines.push_back(true_scale);
  recovered.lines.push_back(true_scale);
  result.values["odometry_end_error_m"] =
      Rounded((drive.odometry.back().translation - truth.back().translation).norm());
  result.figures.emplace_back("fig10", Figure{"Fig. 10: absolute scale recovery on the synthetic drive",
                                              "",
                                              2,
                                              560,
                                              260,
                                              {psi, observed, recovered, paths}});
  return result;
}

}  // namespace turnscale
