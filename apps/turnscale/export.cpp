// SPDX-License-Identifier: MIT
#include <filesystem>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "commands.h"
#include "turnscale/commands/export_command.h"
#include "turnscale/io/terminal.h"

namespace turnscale {
namespace {

void RunExport(const ExportArguments& arguments) {
  const ExportOutcome outcome = ExecuteExport(arguments);
  for (const std::string& warning : outcome.warnings) PrintMessage("warning: " + warning);
  std::string text = outcome.text;
  for (const std::filesystem::path& file : outcome.files) text += "wrote    " + file.string() + "\n";
  PrintText(text);
}

}  // namespace

void AddExportCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("export", "Write the path of a run for maps (GPX, KML, GeoJSON) and for Blender.");
  const auto arguments = std::make_shared<ExportArguments>();
  command->add_option("folder", arguments->folder, "Folder with the results of turnscale run")->required();
  command->add_flag("--gpx", arguments->gpx, "Write GPX 1.1");
  command->add_flag("--kml", arguments->kml, "Write KML 2.2");
  command->add_flag("--geojson", arguments->geojson, "Write GeoJSON");
  command->add_flag("--gltf", arguments->gltf, "Write glTF 2.0: animated camera, path and landmarks, for Blender");
  CLI::Option* origin =
      command->add_option("--origin", arguments->origin,
                          "Place of the first pose: LATITUDE,LONGITUDE[,HEIGHT], degrees (WGS 84) and metres above "
                          "the sea");
  CLI::Option* heading = command->add_option("--heading", arguments->heading,
                                             "Direction of the car at the first pose, degrees clockwise from north");
  command
      ->add_option(
          "--fixes", arguments->fixes,
          "Instead: CSV file with GPS fixes (columns time, latitude, longitude, and optionally height above the sea "
          "and sigma, both in metres [5]). The path is rotated and shifted, but not scaled")
      ->excludes(origin)
      ->excludes(heading);
  command->add_option("--start-time", arguments->start_time,
                      "Date and time of the drive's time 0, with its offset from UTC, such as "
                      "2026-03-22T07:14:05+01:00; without it the files have no times "
                      "of day, unless the drive's times are seconds since 1970");
  command
      ->add_option("--interval", arguments->interval,
                   fmt::format("Minimum time between two points but the last two, seconds; 0: every frame [{:g}]",
                               kUsualExportInterval))
      ->check(CLI::NonNegativeNumber);
  command
      ->add_option("--fov", arguments->fov,
                   "Horizontal field of view of the camera in --gltf, degrees [that of the intrinsics of the run]")
      ->check(CLI::Range(1.0, 179.0));
  command
      ->add_option("--aspect", arguments->aspect, "Width over height of the camera's image in --gltf [that of the run]")
      ->check(CLI::PositiveNumber);
  command->add_option("--out", arguments->out,
                      "Path of the files, without extension, or a folder for them [path, in the folder]");
  command->footer(
      "Examples:\n  turnscale export out/drive --gpx --kml --origin 49.0112,8.4225 --heading 87.5\n"
      "  turnscale export out/drive --gpx --fixes gps.csv --start-time 2026-03-22T07:14:05+01:00");
  command->callback([arguments] { RunExport(*arguments); });
}

}  // namespace turnscale
