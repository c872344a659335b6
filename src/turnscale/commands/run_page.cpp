// SPDX-License-Identifier: MIT
#include "turnscale/commands/run_page.h"

#include "turnscale/base/error.h"
#include "turnscale/commands/comparison.h"
#include "turnscale/io/floor_plan_file.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/report/run_report.h"

namespace turnscale {

void CheckTruthFiles(const TruthFiles& files) {
  if (files.truth.empty() && !files.floor_plan.empty())
    throw InputError("--floor-plan " + files.floor_plan.string() + ": needs --truth");
  if (!files.truth.empty()) ReadTrajectory(files.truth);
  if (!files.floor_plan.empty()) ReadFloorPlan(files.floor_plan);
}

std::vector<std::string> WriteRunPage(const std::filesystem::path& folder, const TruthFiles& files) {
  RunReportExtras extras;
  std::vector<std::string> warnings;
  if (!files.truth.empty()) {
    const Comparison comparison = Compare({folder / RunFiles::kTrajectoryTum, files.truth, {}, {}});
    extras.truth = comparison.pairs;
    warnings = comparison.sources.warnings;
    extras.evaluation = ComparisonJson(comparison);
    if (!files.floor_plan.empty()) extras.outlines = ReadFloorPlan(files.floor_plan);
  }
  WriteRunReport(folder, extras);
  return warnings;
}

}  // namespace turnscale
