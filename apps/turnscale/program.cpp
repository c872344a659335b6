// SPDX-License-Identifier: MIT
#include "program.h"

#include <algorithm>
#include <cctype>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "build_commit.h"
#include "turnscale/base/error.h"
#include "turnscale/commands/command_hooks.h"
#include "turnscale/commands/version.h"
#include "turnscale/config/yaml_map.h"
#include "turnscale/io/terminal.h"

namespace turnscale {
namespace {

// The libraries print errors themselves; turnscale's name the file and the remedy.
void SilenceLibraries() { cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT); }

constexpr size_t kTypos = 2;

// "; did you mean ...?" where a name is nearly one of those that are known.
std::string Suggestion(const std::string& name, const std::vector<std::string>& known) {
  const std::string nearest = NearestName(name, known);
  if (nearest.empty() || EditDistance(name, nearest) > kTypos) return {};
  return "; did you mean '" + nearest + "'?";
}

// An option that the command does not have, such as --lever_arm or --Lever-Arm. Empty where there is none.
std::string UnknownOption(const CLI::App& command) {
  const auto is_option = [](const std::string& word) { return word.size() > 1 && word.starts_with('-'); };
  const std::vector<std::string> rest = command.remaining();
  // What stands behind "--" is no option, and the separator itself is among the rest.
  const auto end = std::ranges::find(rest, "--");
  const auto unknown = std::find_if(rest.begin(), end, is_option);
  if (unknown == end) return {};
  const std::string name = unknown->substr(0, unknown->find('='));
  std::string usual;
  for (const char letter : name) usual += letter == '_' ? '-' : static_cast<char>(std::tolower(letter));
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& long_name : option->get_lnames()) known.push_back("--" + long_name);
  return name + ": unknown option" + Suggestion(usual, known);
}

bool IsNumber(const CLI::App* command, const std::string& name) {
  const CLI::Option* option = command != nullptr ? command->get_option_no_throw(name) : nullptr;
  return option != nullptr && option->get_type_name() == "FLOAT";
}

// CLI11's words for a value that is missing or of the wrong kind name types of C++. `command` may be null.
std::string Reason(const CLI::ParseError& error, const CLI::App* command) {
  constexpr std::string_view kMissing = ": its value is missing";
  constexpr std::string_view kConversion = "Could not convert: ";
  constexpr std::string_view kRepeated = ": At Most 1 required but received ";
  const std::string text = error.what();
  // What is missing may stand behind the unknown option, or be what it was meant for.
  if (command != nullptr && (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr ||
                             dynamic_cast<const CLI::RequiredError*>(&error) != nullptr)) {
    if (const std::string unknown = UnknownOption(*command); !unknown.empty()) return unknown;
  }
  if (const size_t at = text.find(kRepeated); at != std::string::npos)
    return text.substr(0, at) + ": is given more than once";
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr && text.ends_with(" missing"))
    return text.substr(0, text.find(':')).append(kMissing);
  if (!text.starts_with(kConversion)) return text;
  const size_t equals = text.find(" = ");
  const std::string option = text.substr(kConversion.size(), equals - kConversion.size());
  const std::string value = equals == std::string::npos ? "" : text.substr(equals + 3);
  // The next option was taken for the value.
  if (value.starts_with("--")) return option + std::string(kMissing);
  return option + ": '" + value + "' is not a valid value" +
         (IsNumber(command, option) ? "; give a number with a decimal point, without a unit" : "");
}

// A command that does not exist is to CLI11 one that is missing. Empty where none is named.
std::string UnknownCommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || std::string_view(argv[1]).starts_with('-') || !app.get_subcommands().empty()) return {};
  const std::string name = argv[1];
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(command->get_name());
  std::error_code none;
  if (std::filesystem::exists(name, none))
    return name + ": unknown command; did you mean 'turnscale run " + name + "'?";
  return name + ": unknown command" + Suggestion(name, commands);
}

int Main(int argc, char** argv, void (*add_commands)(CLI::App&)) {
  SilenceLibraries();
  CLI::App app{
      "Monocular visual odometry for cars. Metric scale comes from the distance between camera and rear axle (the "
      "lever arm)."};
  app.name("turnscale");
  app.set_version_flag("--version", "turnscale " + VersionWithCommit());
  app.require_subcommand(1);
  app.footer(
      "Example:\n  turnscale run drive.mp4 --lever-arm 1.45\n\n"
      "Exit codes: 0 success, 1 disk full, out of memory or internal error (batch: or a drive has failed), 2 unusable "
      "input, 130 interrupted.");
  add_commands(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& stop) {
    return stop.get_exit_code();
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    if (argc < 2) throw InputError("no command; give one, as in 'turnscale run drive.mp4'; see turnscale --help");
    const std::vector<CLI::App*> commands = app.get_subcommands();
    if (const std::string unknown = UnknownCommand(app, argc, argv); !unknown.empty())
      throw InputError(unknown + "; see turnscale --help");
    const std::string command = commands.empty() ? "" : commands.front()->get_name() + " ";
    throw InputError(Reason(error, commands.empty() ? nullptr : commands.front()) + "; see turnscale " + command +
                     "--help");
  }
  return 0;
}

}  // namespace

std::string VersionWithCommit() {
  const std::string commit = BuildCommit();
  return commit.empty() ? Version() : std::string(Version()) + " (" + commit + ")";
}

int RunProgram(int argc, char** argv, void (*add_commands)(CLI::App&)) {
  // A limit on the size of files is found out where something is written.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return Main(argc, argv, add_commands);
  } catch (const Interruption&) {
    return Report({kInterruptedExitCode, Interruption::kMessage});
  } catch (...) {
    return Report(FailureOf(std::current_exception()));
  }
}

}  // namespace turnscale
