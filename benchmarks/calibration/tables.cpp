// SPDX-License-Identifier: MIT
// Measures the calibration and prints docs/calibration.md's tables; pictures go beside it.
//   calibration_tables KITTI_GT_FOLDER DOCS_FOLDER > tables.md
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/calibration/lever_arm_fit.h"
#include "turnscale/calibration/online_calibration.h"
#include "turnscale/calibration/step_gatherer.h"
#include "turnscale/io/calibration_history.h"
#include "turnscale/io/frame_times.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/laboratory/calibration_trials.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 8> kDrives = {"00", "02", "05", "06", "07", "08", "09", "10"};
constexpr double kDeg = 1 / kDegreesPerRadian;

double Degrees(double radians) { return radians * kDegreesPerRadian; }

Trajectory ReadDrive(const fs::path& kitti, const std::string& name) {
  const auto times = ReadFrameTimes(kitti / "sequences" / name / "times.txt").times;
  return ReadTrajectory(kitti / "poses" / (name + ".txt"), times);
}

Trajectory Rotated(Trajectory path, const Eigen::Quaterniond& mount) {
  for (StampedPose& pose : path) pose.world_from_camera.rotation = pose.world_from_camera.rotation * mount;
  return path;
}

// Largest difference of an angle, degrees.
double WorstAngle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const YawPitchRoll x = YawPitchRollFromRotation(a);
  const YawPitchRoll y = YawPitchRollFromRotation(b);
  return Degrees(std::max({std::abs(x.yaw - y.yaw), std::abs(x.pitch - y.pitch), std::abs(x.roll - y.roll)}));
}

void Figure3(const fs::path& kitti, const fs::path& docs) {
  Trajectory path = ReadDrive(kitti, "00");
  path.resize(500);
  const Eigen::Quaterniond mount = RotationFromPaperAngles(12, 19, -1);
  const Calibration plain = Calibrate(StepsAlong(path));
  const auto steps = StepsAlong(Rotated(path, mount));
  const Calibration rotated = Calibrate(steps);
  const Eigen::Quaterniond truth = plain.vehicle_from_camera * mount;
  fmt::print(
      "Fig. 3: un-rotated {:.3f}, {:.3f}, {:.3f} deg; rotated {:.3f}, {:.3f}, {:.3f} deg; worst difference {:.1e} "
      "deg\n\n",
      Degrees(plain.angles.yaw), Degrees(plain.angles.pitch), Degrees(plain.angles.roll), Degrees(rotated.angles.yaw),
      Degrees(rotated.angles.pitch), Degrees(rotated.angles.roll), WorstAngle(rotated.vehicle_from_camera, truth));
  ReplaceFile(docs / "calibration_fig3.svg",
              HistorySvg(CalibrationHistory(steps), "KITTI 00, first 500 frames, camera rotated by 12, 19, -1 deg",
                         YawPitchRollFromRotation(truth)));
}

void Equivariance(const fs::path& kitti) {
  Random random(1);
  fmt::print("| drive | turns | yaw | pitch | roll | worst of ten rotations |\n|---|---|---|---|---|---|\n");
  for (const char* name : kDrives) {
    const Trajectory path = ReadDrive(kitti, name);
    const Calibration plain = Calibrate(StepsAlong(path));
    double worst = 0;
    for (int i = 0; i < 10; ++i) {
      const double x = random.Gaussian();
      const double y = random.Gaussian();
      const double z = random.Gaussian();
      const Eigen::Quaterniond mount =
          RotationFromVector(Eigen::Vector3d(x, y, z).normalized() * random.Uniform(0, 40 * kDeg));
      worst = std::max(worst, WorstAngle(Calibrate(StepsAlong(Rotated(path, mount))).vehicle_from_camera,
                                         plain.vehicle_from_camera * mount));
    }
    fmt::print("| {} | {} | {:.2f} +- {:.2f} | {:.2f} +- {:.2f} | {:.2f} +- {:.2f} | {:.1e} |\n", name, plain.turns,
               Degrees(plain.angles.yaw), Degrees(plain.sigma.yaw), Degrees(plain.angles.pitch),
               Degrees(plain.sigma.pitch), Degrees(plain.angles.roll), Degrees(plain.sigma.roll), worst);
  }
  fmt::print("\n");
}

void LeverArms(const fs::path& kitti) {
  std::vector<MetricDrive> drives;
  LeverArmFitOptions rigid;
  LeverArmFitOptions assumed;
  assumed.assumed_side_slip = 0.0045;
  LeverArmFitOptions free;
  free.side_slip = true;
  fmt::print("| drive | L, c = 0 | L, c = 0.0045 | L, c fitted | c |\n|---|---|---|---|---|\n");
  const auto row = [&](const std::string& name, const std::vector<MetricDrive>& of) {
    const LeverArmFit a = FitLeverArm(of, rigid);
    const LeverArmFit b = FitLeverArm(of, assumed);
    const LeverArmFit c = FitLeverArm(of, free);
    fmt::print("| {} | {:.3f} +- {:.3f} | {:.3f} +- {:.3f} | {:.3f} +- {:.3f} | {:.4f} +- {:.4f} |\n", name,
               a.lever_arm.length, a.sigma_length, b.lever_arm.length, b.sigma_length, c.lever_arm.length,
               c.sigma_length, c.lever_arm.side_slip, c.sigma_side_slip);
  };
  for (const char* name : kDrives) {
    const auto steps = StepsAlong(ReadDrive(kitti, name));
    drives.push_back({steps, Calibrate(steps).vehicle_from_camera});
    row(name, {drives.back()});
  }
  row("all", drives);
  fmt::print("\n");
}

// Moves the camera half-way; says how long it took to be noticed, and how many false alarms there were.
void Moves(const fs::path& kitti) {
  fmt::print(
      "| drive | yaw by 2 deg, noticed after | yaw, pitch and roll by 1.15 deg each | alarms without a move |\n"
      "|---|---|---|---|\n");
  const std::array<YawPitchRoll, 3> moves = {
      {{2 * kDeg, 0, 0}, {1.155 * kDeg, -1.155 * kDeg, 1.155 * kDeg}, {0, 0, 0}}};
  for (const char* name : kDrives) {
    const Trajectory path = ReadDrive(kitti, name);
    const double moment = path[path.size() / 2].time;
    std::array<std::string, 2> after = {"never", "never"};
    int alarms = 0;
    for (size_t i = 0; i < moves.size(); ++i) {
      Trajectory moved = path;
      const Eigen::Quaterniond mount = RotationFromYawPitchRoll(moves[i]);
      OnlineCalibration online;
      StepGatherer gatherer;
      for (StampedPose& pose : moved) {
        if (pose.time > moment) pose.world_from_camera.rotation = pose.world_from_camera.rotation * mount;
        const auto step = gatherer.Add(pose);
        if (!step || !online.Add(*step).moved) continue;
        if (i == 2) ++alarms;
        if (i < 2 && step->end > moment && after[i] == "never") after[i] = fmt::format("{:.0f} s", step->end - moment);
      }
    }
    fmt::print("| {} | {} | {} | {} |\n", name, after[0], after[1], alarms);
  }
  fmt::print("\n");
}

struct Spread {
  double mean = 0;
  double sigma = 0;
  double least = 0;
  double most = 0;
};

using Angle = double YawPitchRoll::*;
constexpr std::array<Angle, 3> kAngles = {&YawPitchRoll::yaw, &YawPitchRoll::pitch, &YawPitchRoll::roll};
constexpr std::array<const char*, 3> kNames = {"yaw", "pitch", "roll"};

Spread SpreadOf(const std::vector<CalibrationTrial>& trials, YawPitchRoll CalibrationTrial::*which, Angle angle) {
  Spread spread;
  for (const CalibrationTrial& trial : trials) {
    const double value = Degrees(trial.*which.*angle);
    spread.mean += value / static_cast<double>(trials.size());
    spread.least = std::min(spread.least, value);
    spread.most = std::max(spread.most, value);
  }
  for (const CalibrationTrial& trial : trials) spread.sigma += std::pow(Degrees(trial.*which.*angle) - spread.mean, 2);
  spread.sigma = std::sqrt(spread.sigma / static_cast<double>(trials.size() - 1));
  return spread;
}

// A box of Fig. 9: one sigma, the mean, and the range.
std::string Box(double x, double middle, double scale, const Spread& spread, const char* color) {
  const auto y = [&](double value) { return middle - scale * value; };
  return fmt::format(
      "<path d=\"M{0:.1f},{1:.1f}V{2:.1f}\" stroke=\"#333\"/><rect x=\"{3:.1f}\" y=\"{4:.1f}\" width=\"22\" "
      "height=\"{5:.1f}\" "
      "fill=\"{6}\" fill-opacity=\"0.6\"/><path d=\"M{3:.1f},{7:.1f}h22\" stroke=\"#000\"/>\n",
      x, y(spread.least), y(spread.most), x - 11, y(spread.mean + spread.sigma), 2 * scale * spread.sigma, color,
      y(spread.mean));
}

void Figure9(const fs::path& docs, double direction_share, bool picture) {
  constexpr std::array<double, 4> kNoise = {0.05, 0.2, 0.5, 1.0};
  constexpr std::array<const char*, 4> kColors = {"#90caf9", "#42a5f5", "#1565c0", "#0d2f5c"};
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 560\" width=\"760\" height=\"560\">\n"
      "<style>text{font-family:sans-serif;font-size:13px;fill:#333}</style><rect width=\"100%\" height=\"100%\" "
      "fill=\"#fff\"/>\n";
  fmt::print(
      "| noise | angle | linear: mean, spread | refined: mean (in standard errors) | spread | over the bound | "
      "stated sigma over spread | paper's (15): mean, spread |\n|---|---|---|---|---|---|---|---|\n");
  for (size_t level = 0; level < kNoise.size(); ++level) {
    CalibrationTrials trials;
    trials.drive = PaperCalibrationDrive();
    trials.rotation_noise = kNoise[level] * kDeg;
    trials.direction_share = direction_share;
    trials.calibration.refinement.road_bank = 0;
    const auto results = RunCalibrationTrials(trials);
    CalibrationTrials of_paper = trials;
    of_paper.calibration.refinement.travel = TravelModel::kFree;
    of_paper.calibration.refinement.weigh_by_spread = false;
    of_paper.steps.duration = 0.1;
    const auto paper = RunCalibrationTrials(of_paper);
    const YawPitchRoll bound = CramerRaoBound(trials);
    for (size_t i = 0; i < kAngles.size(); ++i) {
      const Spread linear = SpreadOf(paper, &CalibrationTrial::linear, kAngles[i]);
      const Spread refined = SpreadOf(results, &CalibrationTrial::refined, kAngles[i]);
      const Spread free = SpreadOf(paper, &CalibrationTrial::refined, kAngles[i]);
      double stated = 0;
      for (const CalibrationTrial& trial : results) {
        stated += std::pow(Degrees(trial.sigma.*kAngles[i]), 2) / static_cast<double>(results.size());
      }
      fmt::print("| {:.2f} | {} | {:+.3f}, {:.3f} | {:+.4f} ({:+.1f}) | {:.4f} | {:.2f} | {:.2f} | {:+.4f}, {:.4f} |\n",
                 kNoise[level], kNames[i], linear.mean, linear.sigma, refined.mean,
                 refined.mean / (refined.sigma / std::sqrt(static_cast<double>(results.size()))), refined.sigma,
                 refined.sigma / Degrees(bound.*kAngles[i]), std::sqrt(stated) / refined.sigma, free.mean, free.sigma);
      const double x = 90 + 220 * static_cast<double>(i) + 40 * static_cast<double>(level);
      svg += Box(x, 150, 40, linear, kColors[level]) + Box(x, 420, 40, refined, kColors[level]);
    }
  }
  for (size_t i = 0; i < kNames.size(); ++i) {
    for (const int middle : {150, 420}) {
      svg += fmt::format(
          "<path d=\"M{0},{1}h190\" stroke=\"#888\" stroke-dasharray=\"5 4\"/><text x=\"{0}\" y=\"{2}\">{3}</text>\n",
          65 + 220 * i, middle, middle - 118, kNames[i]);
    }
  }
  svg +=
      "<text x=\"24\" y=\"18\">(a) linear only: error, deg (a degree is 40 units); rotation noise 0.05, 0.2, 0.5, 1 "
      "deg from left to right</text>"
      "<text x=\"24\" y=\"290\">(b) after the refinement; box: one sigma, line: mean, whisker: range of 100 "
      "runs</text></svg>\n";
  if (picture) ReplaceFile(docs / "calibration_fig9.svg", svg);
  fmt::print("\n");
}

}  // namespace
}  // namespace turnscale

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: calibration_tables KITTI_GT_FOLDER DOCS_FOLDER\n", stderr);
    return 2;
  }
  try {
    turnscale::Figure3(argv[1], argv[2]);
    turnscale::Equivariance(argv[1]);
    std::puts("Directions with the rotations' noise:\n");
    turnscale::Figure9(argv[2], 1, true);
    std::puts("Directions with a third of it:\n");
    turnscale::Figure9(argv[2], 0.33, false);
    turnscale::LeverArms(argv[1]);
    turnscale::Moves(argv[1]);
  } catch (const turnscale::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
