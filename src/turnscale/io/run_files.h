// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <initializer_list>

namespace turnscale {

/// Name of the page in the folder of the results, which the module report makes from the other files.
constexpr auto kReportFile = "report.html";

/// Names of the files in a folder with the results of a run.
struct RunFiles {
  static constexpr auto kTrajectoryTum = "trajectory.tum";
  static constexpr auto kTrajectoryKitti = "trajectory.kitti.txt";
  static constexpr auto kTrajectoryTable = "trajectory.csv";
  static constexpr auto kLiveTum = "live.tum";
  /// The first file that a run makes and the last of an earlier one that it takes away: a folder that has it is of a
  /// run, whenever that was killed.
  static constexpr auto kLiveTumPart = "live.tum.part";
  static constexpr auto kTurns = "turns.csv";
  static constexpr auto kSpeed = "speed.csv";
  static constexpr auto kScale = "scale.csv";
  static constexpr auto kRotation = "camera_rotation.csv";
  static constexpr auto kCar = "car.yaml";
  static constexpr auto kMap = "map.ply";
  static constexpr auto kMask = "mask.png";
  static constexpr auto kCamera = "camera.yaml";
  static constexpr auto kSummary = "summary.json";
  static constexpr auto kSettings = "settings.yaml";

  /// All that a run replaces or takes away, in this order: the summary first, as it says that the others are of one
  /// run, and live.tum last, as its part marks the folder. What is left of a file that was being written (PartOf) goes
  /// with the file.
  static constexpr std::array kAll = {
      kReportFile, kSummary, kSettings, kTurns,         kSpeed,           kScale,           kRotation, kCar,
      kCamera,     kMap,     kMask,     kTrajectoryTum, kTrajectoryKitti, kTrajectoryTable, kLiveTum};
};

/// Whether a folder has poses of a run, also if only the live ones, as after a killed run.
bool HasPosesOfRun(const std::filesystem::path& folder);

/// Whether a folder has a summary.json with all of these keys.
bool SummaryHas(const std::filesystem::path& folder, std::initializer_list<const char*> keys);

/// Whether a folder has files of a run, complete, stopped or killed.
bool IsFolderOfRun(const std::filesystem::path& folder);

/// A file that a run would replace or take away though its folder is none of a run; empty if there is none.
std::filesystem::path ForeignFile(const std::filesystem::path& folder);

/// Whether a folder has the trajectory table and the summary of a run, complete or interrupted.
bool HasResultsOfRun(const std::filesystem::path& folder);

}  // namespace turnscale
