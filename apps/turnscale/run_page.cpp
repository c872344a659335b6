// SPDX-License-Identifier: MIT
#include "run_page.h"

#include <CLI/CLI.hpp>

#include "comparison.h"
#include "turnscale/io/floor_plan_file.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/report/run_report.h"

namespace turnscale {

void AddTruthOptions(CLI::App& command, TruthFiles& files) {
  CLI::Option* truth = command.add_option("--truth", files.truth,
                                          "Ground truth (TUM, EuRoC or KITTI file), shown with the errors in the page");
  command
      .add_option("--floor-plan", files.floor_plan,
                  "floor_plan.csv of a simulated drive, drawn under the path in the page")
      ->needs(truth);
}

void CheckTruthFiles(const TruthFiles& files) {
  if (!files.truth.empty()) ReadTrajectory(files.truth);
  if (!files.floor_plan.empty()) ReadFloorPlan(files.floor_plan);
}

void WriteRunPage(const std::filesystem::path& folder, const TruthFiles& files) {
  RunReportExtras extras;
  if (!files.truth.empty()) {
    const Comparison comparison = Compare({folder / "trajectory.tum", files.truth, {}, {}});
    extras.truth = comparison.pairs;
    extras.evaluation = ComparisonJson(comparison);
    if (!files.floor_plan.empty()) extras.outlines = ReadFloorPlan(files.floor_plan);
  }
  WriteRunReport(folder, extras);
}

}  // namespace turnscale
