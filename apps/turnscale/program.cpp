// SPDX-License-Identifier: MIT
#include "program.h"

#include <cstdlib>
#include <exception>
#include <string>

#include <CLI/CLI.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "build_commit.h"
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

int Main(int argc, char** argv, void (*add_commands)(CLI::App&)) {
  MeasureCost();
  SilenceLibraries();
  CLI::App app{
      "Monocular visual odometry for cars. Metric scale comes from the distance between camera and rear axle (the "
      "lever arm)."};
  app.name("turnscale");
  app.set_version_flag("--version", "turnscale " + VersionWithCommit());
  app.require_subcommand(1);
  app.footer(
      "Example:\n  turnscale run drive.mp4 --lever-arm 1.45\n\n"
      "Exit codes: 0 success, 1 disk full, out of memory or internal error, 2 unusable input, 130 interrupted.");
  add_commands(app);
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

std::string VersionWithCommit() {
  const std::string commit = BuildCommit();
  return commit.empty() ? Version() : std::string(Version()) + " (" + commit + ")";
}

int RunProgram(int argc, char** argv, void (*add_commands)(CLI::App&)) {
  try {
    return Main(argc, argv, add_commands);
  } catch (...) {
    return Report(FailureOf(std::current_exception()));
  }
}

}  // namespace turnscale
