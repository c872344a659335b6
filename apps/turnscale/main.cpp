// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <exception>
#include <string>

#include <CLI/CLI.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "commands.h"
#include "turnscale/base/error.h"
#include "turnscale/commands/version.h"
#include "turnscale/io/run_summary.h"
#include "turnscale/io/terminal.h"

namespace turnscale {
namespace {

// The libraries print errors themselves; turnscale's name the file and the remedy.
void SilenceLibraries() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  constexpr auto kQuiet = "-8";
  setenv("OPENCV_FFMPEG_LOGLEVEL", kQuiet, 0);
}

int Main(int argc, char** argv) {
  MeasureCost();
  SilenceLibraries();
  CLI::App app{
      "Monocular visual odometry for cars. Metric scale comes from the distance between camera and rear axle (the "
      "lever arm)."};
  app.name("turnscale");
  app.set_version_flag("--version", std::string("turnscale ") + Version());
  app.require_subcommand(1);
  app.footer(
      "Example:\n  turnscale run drive.mp4 --lever-arm 1.45\n\n"
      "Exit codes: 0 success, 1 disk full, out of memory or internal error, 2 unusable input, 130 interrupted.");
  AddRunCommand(app);
  AddBatchCommand(app);
  AddCalibrateCommand(app);
  AddEvaluateCommand(app);
  AddExportCommand(app);
  AddRescaleCommand(app);
  AddSimulateCommand(app);
  AddLabCommand(app);
  AddViewCommand(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& stop) {
    return stop.get_exit_code();
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    throw InputError(std::string(error.what()) + "; see turnscale --help");
  }
  return 0;
}

}  // namespace

void AddMissingCommand(CLI::App& app, const std::string& name, const std::string& what, const std::string& option) {
  CLI::App* command = app.add_subcommand(name)->group("")->prefix_command();
  command->set_help_flag();
  command->parse_complete_callback([name, what, option] {
    throw InputError(name + ": this build has no " + what + "; configure it with -D" + option + "=ON");
  });
}

}  // namespace turnscale

int main(int argc, char** argv) {
  try {
    return turnscale::Main(argc, argv);
  } catch (...) {
    return turnscale::Report(turnscale::FailureOf(std::current_exception()));
  }
}
