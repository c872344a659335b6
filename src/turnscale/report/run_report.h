// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turnscale/report/report_data.h"
#include "turnscale/run/result_folder.h"

namespace turnscale {

/// What a report shows besides the results of the run.
struct RunReportExtras {
  PosePairs truth;         ///< the trajectory's poses with the true ones
  std::string evaluation;  ///< of them: the JSON that `turnscale evaluate` writes
  FloorPlan outlines;      ///< see ReportData
};

/// The page's data from the files of a run. Its warnings are those of the summary, the missing parts of the path, and
/// why there are no metres. The cost of the run is left out, so that the same run gives the same page.
ReportData DataOfRun(const ResultFolder& results, std::vector<Thumbnail> thumbnails,
                     const RunReportExtras& extras = {});

/// Makes report.html from the other files in the folder of a run, in one step. The truth of a page that is there
/// already is kept unless there is another one. Throws InputError where these are no results of a run, OutputError
/// where the page cannot be written.
void WriteRunReport(const std::filesystem::path& folder, const RunReportExtras& extras = {});

/// The facts of a comparison with the truth, from the JSON that `turnscale evaluate` writes; without metres, those of
/// the path scaled by the truth.
std::vector<ReportFact> ErrorFacts(const std::string& evaluation_json, bool metric = true);

}  // namespace turnscale
