// SPDX-License-Identifier: MIT
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "commands.h"
#include "common_options.h"
#include "turnscale/base/error.h"
#include "turnscale/base/file_text.h"
#include "turnscale/commands/run_page.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/terminal.h"
#include "turnscale/report/report_page.h"
#include "turnscale/report/run_report.h"
#include "turnscale/run/run_writer.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

struct ViewArguments {
  fs::path results;
  TruthFiles truth;
  bool open = false;
};

// The page of results that are not of `run`, with the data that it has.
void Renew(const fs::path& page) {
  const std::optional<std::string> text = FileText(page);
  if (!text) throw InputError(page.string() + ": cannot be read");
  const std::string data = DataOfPage(*text, page.string());
  if (data.empty()) throw InputError(page.string() + ": holds no results");
  ReplaceFile(page, ReportPage(page.parent_path().filename().string(), data));
}

void OpenInBrowser(const fs::path& page) {
  const std::string path = fs::absolute(page).string();
  std::array<char*, 3> arguments = {const_cast<char*>("xdg-open"), const_cast<char*>(path.c_str()), nullptr};
  pid_t child = 0;
  int status = 0;
  const bool opened = posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), environ) == 0 &&
                      waitpid(child, &status, 0) == child && status == 0;
  if (!opened) PrintMessage("warning: xdg-open cannot open the page; open it with a browser");
}

void RunView(const ViewArguments& arguments) {
  std::error_code none;
  if (fs::status(arguments.results, none).type() == fs::file_type::not_found)
    throw InputError(arguments.results.string() + ": no such file or folder");
  fs::path page = fs::absolute(arguments.results);
  if (fs::is_directory(page, none)) page /= kReportFile;
  if (fs::exists(page.parent_path() / RunFiles::kTrajectoryTable, none) && page.filename() == kReportFile) {
    // Where `run` cannot write its page any more, its folder has failed; here the user has chosen it.
    CheckOutputFile(page);
    for (const std::string& warning : WriteRunPage(page.parent_path(), arguments.truth))
      PrintMessage("warning: " + warning);
  } else if (fs::exists(page, none)) {
    if (!arguments.truth.truth.empty()) {
      throw InputError("--truth " + arguments.truth.truth.string() +
                       ": needs the results of a run beside the page; give the --out folder of turnscale run, or "
                       "compare with turnscale evaluate --report");
    }
    Renew(page);
  } else {
    throw InputError(arguments.results.string() +
                     ": holds no results; give the --out folder of turnscale run, the --report folder of rescale, or a "
                     "report");
  }
  PrintText("page     " + page.string() + "\n");
  if (arguments.open) OpenInBrowser(page);
}

}  // namespace

void AddViewCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("view", "Make report.html of an earlier run again, with this version.");
  const auto arguments = std::make_shared<ViewArguments>();
  command
      ->add_option("results", arguments->results,
                   "Folder with the results of run or rescale, or a page that one of them or evaluate has written")
      ->required();
  AddTruthOptions(*command, arguments->truth);
  command->add_flag("--open", arguments->open, "Open the page in the browser (xdg-open)");
  command->footer("Example:\n  turnscale view out/drive --open");
  command->callback([arguments] { RunView(*arguments); });
}

}  // namespace turnscale
