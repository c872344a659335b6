// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "turnscale/laboratory/figure.h"

namespace turnscale {

using LabJson = nlohmann::ordered_json;

/// What one experiment of the laboratory gives.
struct LabResult {
  LabJson values = LabJson::object();                   ///< its numbers, as lab.json has them
  std::vector<std::pair<std::string, Figure>> figures;  ///< by the name of their file
  std::vector<std::string> lines;                       ///< what is printed
};

/// How the experiments are run.
struct LabSettings {
  int runs = 100;
  int jobs = 2;
  unsigned seed = 1;
  /// Told how many of how many runs are done; false stops the experiment.
  std::function<bool(int done, int all)> progress;
};

/// Six significant digits, which is more than any of the experiments knows.
double Rounded(double value);

/// The curves, boxes and areas of a figure as numbers.
LabJson FigureJson(const Figure& figure);

/// Writes the pictures and puts the numbers into `all` under the experiment's name. Throws as ReplaceFile does, after
/// trying all of them.
void KeepResult(const std::filesystem::path& folder, const std::string& name, const LabResult& result, LabJson& all);

}  // namespace turnscale
