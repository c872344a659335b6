// SPDX-License-Identifier: MIT
// The calibration on recorded motion; prints one part as JSON, angles in degrees. benchmarks/calibration_report runs
// it.
//   calibration_recorded DATA_FOLDER fig3|rotations|travel|lever_arms|corners|moves [PICTURE]
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/lever_arm_fit.h"
#include "turnscale/calibration/online_calibration.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/laboratory/calibration_trials.h"
#include "turnscale/run/calibration_report.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 8> kDrives = {"00", "02", "05", "06", "07", "08", "09", "10"};
constexpr std::array<const char*, 2> kMotions = {"truth", "stereo"};
constexpr double kDeg = 1 / kDegreesPerRadian;

// KITTI's ground truth, or what ORB-SLAM2 made of the stereo images.
Trajectory ReadDrive(const fs::path& data, const std::string& motion, const std::string& name) {
  const auto times = ReadFrameTimes(data / "kitti_gt/sequences" / name / "times.txt").times;
  const fs::path folder = motion == "truth" ? data / "kitti_gt/poses" : data / "kitti_published/orb_stereo";
  return ReadTrajectory(folder / (name + ".txt"), times);
}

Trajectory Rotated(Trajectory path, const Eigen::Quaterniond& mount) {
  for (StampedPose& pose : path) pose.world_from_camera.rotation = pose.world_from_camera.rotation * mount;
  return path;
}

// The unit of length walks by this share a frame.
Trajectory Drifting(const Trajectory& path, double share) {
  Random random(3);
  Trajectory drifting{path.front()};
  double unit = 1;
  for (size_t i = 1; i < path.size(); ++i) {
    RigidTransform motion = path[i - 1].world_from_camera.inverse() * path[i].world_from_camera;
    unit *= std::exp(share * random.Gaussian());
    motion.translation *= unit;
    drifting.push_back({path[i].time, drifting.back().world_from_camera * motion});
  }
  return drifting;
}

Json AnglesOf(const YawPitchRoll& angles) {
  return {{"yaw", InDegrees(angles.yaw)}, {"pitch", InDegrees(angles.pitch)}, {"roll", InDegrees(angles.roll)}};
}

// Largest difference of an angle, degrees.
double WorstAngle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const YawPitchRoll x = YawPitchRollFromRotation(a);
  const YawPitchRoll y = YawPitchRollFromRotation(b);
  return InDegrees(std::max({std::abs(x.yaw - y.yaw), std::abs(x.pitch - y.pitch), std::abs(x.roll - y.roll)}));
}

Json Figure3(const fs::path& data, const fs::path& picture) {
  Trajectory path = ReadDrive(data, "truth", "00");
  path.resize(500);
  const Eigen::Quaterniond mount = RotationFromPaperAngles(12, 19, -1);
  const Calibration plain = Calibrate(StepsAlong(path));
  const auto steps = StepsAlong(Rotated(path, mount));
  const Calibration rotated = Calibrate(steps);
  const Eigen::Quaterniond truth = plain.vehicle_from_camera * mount;
  const auto history = CalibrationHistory(steps);
  ReplaceFile(picture, HistorySvg(history, "KITTI 00, first 500 frames, camera rotated by {12, 19, -1} deg",
                                  YawPitchRollFromRotation(truth)));
  Json singular = Json::array();
  for (const CalibrationMoment& moment : history) {
    singular.push_back({{"time", moment.time},
                        {"psi", InDegrees(moment.psi)},
                        {"smallest", moment.singular_values[0]},
                        {"next", moment.singular_values[1]}});
  }
  return {{"unrotated", AnglesOf(plain.angles)},
          {"rotated", AnglesOf(rotated.angles)},
          {"worst", WorstAngle(rotated.vehicle_from_camera, truth)},
          {"turns", plain.turns},
          {"singular", singular}};
}

Json Rotations(const fs::path& data) {
  Random random(1);
  Json rows = Json::array();
  for (const char* motion : kMotions) {
    for (const char* name : kDrives) {
      const Trajectory path = ReadDrive(data, motion, name);
      const Calibration plain = Calibrate(StepsAlong(path));
      CalibrationOptions rigid;
      rigid.body_lean = false;
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
      rows.push_back({{"motion", motion},
                      {"drive", name},
                      {"turns", plain.turns},
                      {"angles", AnglesOf(plain.angles)},
                      {"sigma", AnglesOf(plain.sigma)},
                      {"lean", InDegrees(plain.lean.per_acceleration)},
                      {"lean_sigma", InDegrees(plain.lean.sigma)},
                      {"roll_rigid", InDegrees(Calibrate(StepsAlong(path), rigid).angles.roll)},
                      {"worst", worst}});
    }
  }
  return rows;
}

// A lever arm that holds over a turn against the paper's free rho_j.
Json Travel(const fs::path& data) {
  Json rows = Json::array();
  CalibrationOptions steady;
  steady.motion_bias = 0;
  CalibrationOptions free = steady;
  free.refinement.travel = TravelModel::kFree;
  for (const std::string motion : {"truth", "stereo", "drifting"}) {
    for (const char* name : kDrives) {
      const Trajectory path = ReadDrive(data, motion == "truth" ? "truth" : "stereo", name);
      const auto steps = StepsAlong(motion == "drifting" ? Drifting(path, 0.01) : path);
      const Calibration a = Calibrate(steps, steady);
      const Calibration b = Calibrate(steps, free);
      rows.push_back({{"motion", motion},
                      {"drive", name},
                      {"steady", InDegrees(a.angles.yaw)},
                      {"steady_sigma", InDegrees(a.sigma.yaw)},
                      {"free", InDegrees(b.angles.yaw)},
                      {"free_sigma", InDegrees(b.sigma.yaw)}});
    }
  }
  return rows;
}

Json FitOf(const std::vector<MetricDrive>& drives, const LeverArmFitOptions& options) {
  try {
    const LeverArmFit fit = FitLeverArm(drives, options);
    return {{"length", fit.lever_arm.length},
            {"sigma", fit.sigma_length},
            {"slip", fit.lever_arm.side_slip},
            {"slip_sigma", fit.sigma_side_slip},
            {"spread", fit.speed_spread}};
  } catch (const InputError& error) {
    return {{"problem", error.what()}};
  }
}

Json LeverArms(const fs::path& data) {
  LeverArmFitOptions rigid;
  LeverArmFitOptions assumed;
  assumed.assumed_side_slip = 0.0045;
  LeverArmFitOptions fitted;
  fitted.side_slip = true;
  Json rows = Json::array();
  for (const char* motion : kMotions) {
    std::vector<MetricDrive> all;
    const auto add = [&](const std::string& name, const std::vector<MetricDrive>& drives) {
      rows.push_back({{"motion", motion},
                      {"drive", name},
                      {"rigid", FitOf(drives, rigid)},
                      {"assumed", FitOf(drives, assumed)},
                      {"fitted", FitOf(drives, fitted)}});
    };
    for (const char* name : kDrives) {
      const auto steps = StepsAlong(ReadDrive(data, motion, name));
      all.push_back({steps, Calibrate(steps).vehicle_from_camera});
      add(name, {all.back()});
    }
    add("all", all);
  }
  return rows;
}

// Steps of a drive with each of its corners, 60 deg and more, and up to 8 s before and after it.
std::vector<std::vector<CameraStep>> CornersOf(const Trajectory& path) {
  constexpr double kCorner = 60 * kDeg;
  constexpr double kAround = 8;
  constexpr double kTurningStep = 2 * kDeg;
  const auto steps = StepsAlong(path);
  const Eigen::Quaterniond rotation = Calibrate(steps).vehicle_from_camera;
  const auto turned = [&](const CameraStep& step) {
    return step.frames * TurningMotionOf(step.previous_from_current, rotation).psi;
  };
  std::vector<std::vector<CameraStep>> corners;
  for (auto begin = steps.begin(); begin != steps.end();) {
    double angle = turned(*begin);
    auto end = begin + 1;
    if (std::abs(angle) >= kTurningStep)
      for (; end != steps.end() && std::abs(turned(*end)) >= kTurningStep && turned(*end) * angle > 0; ++end)
        angle += turned(*end);
    if (std::abs(angle) >= kCorner) {
      std::vector<CameraStep>& corner = corners.emplace_back();
      for (const CameraStep& step : steps)
        if (step.begin >= begin->begin - kAround && step.end <= (end - 1)->end + kAround) corner.push_back(step);
    }
    begin = end;
  }
  return corners;
}

// Errors of the lever arm for an assumed c, against that of all drives.
class CornerErrors {
 public:
  explicit CornerErrors(double length) : length_(length) {}

  void Add(const std::vector<MetricDrive>& drives, const LeverArmFitOptions& options) {
    try {
      const LeverArmFit fit = FitLeverArm(drives, options);
      ++fits_;
      squares_ += std::pow(fit.lever_arm.length - length_, 2);
      normalized_ += std::pow((fit.lever_arm.length - length_) / fit.sigma_length, 2);
      sigmas_ += fit.sigma_length;
    } catch (const InputError&) {
      ++refused_;
    }
  }

  Json json() const {
    return {{"fits", fits_},
            {"refused", refused_},
            {"error", std::sqrt(squares_ / fits_)},
            {"sigma", sigmas_ / fits_},
            {"normalized", std::sqrt(normalized_ / fits_)}};
  }

 private:
  double length_;
  int fits_ = 0;
  int refused_ = 0;
  double squares_ = 0;
  double normalized_ = 0;
  double sigmas_ = 0;
};

// Whether sigma is that of the errors, from one corner to a whole drive.
Json Corners(const fs::path& data) {
  LeverArmFitOptions options;
  options.assumed_side_slip = 0.0045;
  Json rows = Json::array();
  for (const char* motion : kMotions) {
    std::vector<MetricDrive> all;
    std::vector<std::vector<MetricDrive>> corners;
    for (const char* name : kDrives) {
      const Trajectory path = ReadDrive(data, motion, name);
      const auto steps = StepsAlong(path);
      all.push_back({steps, Calibrate(steps).vehicle_from_camera});
      corners.emplace_back();
      for (const auto& corner : CornersOf(path))
        corners.back().push_back({corner, Calibrate(corner).vehicle_from_camera});
    }
    const double length = FitLeverArm(all, options).lever_arm.length;
    CornerErrors one(length);
    CornerErrors two(length);
    CornerErrors whole(length);
    for (size_t i = 0; i < all.size(); ++i) {
      whole.Add({all[i]}, options);
      for (size_t k = 0; k < corners[i].size(); ++k) {
        one.Add({corners[i][k]}, options);
        if (k % 2 == 1) two.Add({corners[i][k - 1], corners[i][k]}, options);
      }
    }
    rows.push_back({{"motion", motion}, {"one", one.json()}, {"two", two.json()}, {"whole", whole.json()}});
  }
  return rows;
}

// When the online calibration reports a camera that is moved at a moment, seconds.
std::vector<double> AlarmsOf(const Trajectory& path, const Eigen::Quaterniond& mount, double moment) {
  OnlineCalibration online;
  StepGatherer gatherer;
  std::vector<double> alarms;
  for (StampedPose pose : path) {
    if (pose.time > moment) pose.world_from_camera.rotation = pose.world_from_camera.rotation * mount;
    const auto step = gatherer.Add(pose);
    if (step && online.Add(*step).moved) alarms.push_back(step->end);
  }
  return alarms;
}

// Seconds from the move to its report; nothing if there is none. An alarm of the drive without a move is no report.
std::optional<double> Delay(const Trajectory& path, const std::vector<double>& untouched,
                            const Eigen::Quaterniond& mount, double moment) {
  for (const double time : AlarmsOf(path, mount, moment)) {
    if (time > moment && std::find(untouched.begin(), untouched.end(), time) == untouched.end()) return time - moment;
  }
  return std::nullopt;
}

// Delays where the camera is moved soon after the beginning: of parts of a drive, as drives of their own.
Json EarlyMoves(const Trajectory& path) {
  constexpr double kLength = 60;   // seconds
  constexpr double kSpacing = 13;  // seconds
  constexpr double kMove = 20;     // seconds
  const Eigen::Quaterniond pitch = RotationFromYawPitchRoll({0, -3 * kDeg, 0});
  Json delays = Json::array();
  int false_alarms = 0;
  for (double begin = path.front().time; begin + kLength < path.back().time; begin += kSpacing) {
    Trajectory part;
    for (const StampedPose& pose : path) {
      if (pose.time >= begin && pose.time < begin + kLength) part.push_back(pose);
    }
    const std::vector<double> untouched = AlarmsOf(part, Eigen::Quaterniond::Identity(), 1e9);
    false_alarms += static_cast<int>(untouched.size());
    const std::optional<double> delay = Delay(part, untouched, pitch, begin + kMove);
    delays.push_back(delay ? Json(*delay) : Json());
  }
  return {{"delays", delays}, {"false_alarms", false_alarms}};
}

Json Moves(const fs::path& data) {
  const Eigen::Quaterniond yaw = RotationFromYawPitchRoll({2 * kDeg, 0, 0});
  const double each = 2 / std::sqrt(3.0) * kDeg;
  const Eigen::Quaterniond all = RotationFromYawPitchRoll({each, -each, each});
  Json rows = Json::array();
  for (const char* motion : kMotions) {
    for (const char* name : kDrives) {
      const Trajectory path = ReadDrive(data, motion, name);
      const double moment = path[path.size() / 2].time;
      const std::vector<double> untouched = AlarmsOf(path, Eigen::Quaterniond::Identity(), 1e9);
      Json row = {{"motion", motion}, {"drive", name}, {"false_alarms", untouched.size()}};
      for (const auto& [key, mount] : {std::pair("yaw", yaw), std::pair("all", all)}) {
        const std::optional<double> delay = Delay(path, untouched, mount, moment);
        row[key] = delay ? Json(*delay) : Json();
      }
      row["early"] = EarlyMoves(path);
      rows.push_back(row);
    }
  }
  return rows;
}

Json Part(const std::string& part, const fs::path& data, const fs::path& picture) {
  if (part == "fig3") return Figure3(data, picture);
  if (part == "rotations") return Rotations(data);
  if (part == "travel") return Travel(data);
  if (part == "lever_arms") return LeverArms(data);
  if (part == "corners") return Corners(data);
  if (part == "moves") return Moves(data);
  throw InputError(part + ": no such part");
}

}  // namespace
}  // namespace turnscale

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    std::fputs("usage: calibration_recorded DATA_FOLDER PART [PICTURE]\n", stderr);
    return 2;
  }
  try {
    std::puts(turnscale::Part(argv[2], argv[1], argc == 4 ? argv[3] : "calibration_fig3.svg").dump(1).c_str());
  } catch (const turnscale::InputError& error) {
    std::fprintf(stderr, "calibration_recorded: %s\n", error.what());
    return 2;
  }
}
