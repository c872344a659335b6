// SPDX-License-Identifier: MIT
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "commands.h"
#include "interrupt.h"
#include "lab_experiments.h"
#include "program.h"
#include "turnscale/base/error.h"
#include "turnscale/commands/command_hooks.h"
#include "turnscale/commands/version.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/terminal.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxRuns = 100000;
constexpr int kMaxJobs = 1024;

struct Experiment {
  std::string name;
  std::string what;
  std::function<LabResult(const LabSettings&)> run;
};

std::vector<Experiment> Experiments() {
  return {
      {"fig4", "directions of travel", [](const LabSettings&) { return LabFigure4(); }},
      {"fig6", "sensitivity of the scale observer", [](const LabSettings&) { return LabFigure6(); }},
      {"fig7", "error of the scale", [](const LabSettings&) { return LabFigure7(); }},
      {"fig8", "the synthetic drive", LabFigure8},
      {"fig9", "calibration of the camera-to-vehicle rotation", LabFigure9},
      {"fig10", "absolute scale recovery, one run per noise level", LabFigure10},
      {"table1", "absolute scale recovery, errors over many runs", LabTable1},
      {"ablations", "absolute scale recovery with one change at a time", LabAblations},
      {"coverage", "coverage: how often ground truth is within the stated sigmas", LabCoverage},
  };
}

struct LabArguments {
  fs::path out;
  std::vector<std::string> only;
  int runs = 100;
  int jobs = 2;
  unsigned seed = 1;
  bool quiet = false;
};

void Check(const LabArguments& arguments) {
  if (arguments.runs < 2 || arguments.runs > kMaxRuns) {
    throw InputError(fmt::format("--runs {}: give 2 to {}", arguments.runs, kMaxRuns));
  }
  if (arguments.jobs < 1 || arguments.jobs > kMaxJobs) {
    throw InputError(fmt::format("--jobs {}: give 1 to {}", arguments.jobs, kMaxJobs));
  }
}

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder)) throw InputError(folder.string() + ": cannot be made; give another --out");
}

bool Wanted(const LabArguments& arguments, const std::string& name) {
  return arguments.only.empty() || std::ranges::find(arguments.only, name) != arguments.only.end();
}

// Returns the exit code.
int Lab(const LabArguments& arguments) {
  Check(arguments);
  MakeFolder(arguments.out);
  // Pictures are written before their numbers: older ones must not be taken for them.
  RemoveOldFile(arguments.out / "lab.json");
  CatchInterrupts();
  LabJson all = {{"version", Version()}, {"runs", arguments.runs}, {"seed", arguments.seed}};
  const auto start = std::chrono::steady_clock::now();
  bool any = false;  // experiment has been kept
  for (const Experiment& experiment : Experiments()) {
    if (!Wanted(arguments, experiment.name)) continue;
    if (!arguments.quiet) PrintMessage(std::string(experiment.name) + ": " + experiment.what);
    std::optional<Progress> progress;
    LabSettings settings{arguments.runs, arguments.jobs, arguments.seed, {}};
    settings.progress = [&](int done, int runs) {
      if (!progress) progress.emplace(runs, arguments.quiet, "run");
      progress->Update(done);
      return !Interrupted();
    };
    const LabResult result = experiment.run(settings);
    if (progress) progress->Finish();
    if (Interrupted()) {
      const std::string kept = any ? "the results before it are in " + arguments.out.string() : "no results before it";
      return Report({kInterruptedExitCode, fmt::format("interrupted in {}; {}", experiment.name, kept)});
    }
    KeepResult(arguments.out, experiment.name, result, all);
    any = true;
    if (!arguments.quiet) {
      for (const std::string& line : result.lines) PrintText(line + "\n");
    }
  }
  if (!arguments.quiet) {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    PrintText(fmt::format("files   {} ({:.0f} s)\n", arguments.out.string(), seconds));
  }
  return 0;
}

}  // namespace

void AddLabCommand(CLI::App& app) {
  CLI::App* lab = app.add_subcommand(kLabCommand.name, kLabCommand.what);
  auto arguments = std::make_shared<LabArguments>();
  std::vector<std::string> names;
  for (const Experiment& experiment : Experiments()) names.push_back(experiment.name);
  lab->add_option("--out", arguments->out, "Folder for lab.json (an older one is replaced) and the figures")
      ->required();
  lab->add_option("--only", arguments->only,
                  "Only these experiments, separated by commas: " + CLI::detail::join(names, ", "))
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  lab->add_option(
         "--runs", arguments->runs,
         "Monte Carlo runs per noise level (Table I, Fig. 9) and of the coverage test; other experiments use at most a "
         "tenth of them")
      ->capture_default_str();
  lab->add_option("--jobs", arguments->jobs, "Number of runs in parallel; does not affect the numbers")
      ->capture_default_str();
  lab->add_option("--seed", arguments->seed, "Seed of noise and landmarks")->capture_default_str();
  lab->add_flag("--quiet", arguments->quiet, "Print warnings and errors only");
  lab->footer("Example:\n  turnscale lab --out lab\n  turnscale lab --out lab --only table1 --runs 10");
  lab->callback([arguments] {
    if (const int exit_code = Lab(*arguments); exit_code != 0) throw CLI::RuntimeError(exit_code);
  });
}

}  // namespace turnscale
