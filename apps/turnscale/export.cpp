// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "commands.h"
#include "turnscale/base/error.h"
#include "turnscale/base/file_extension.h"
#include "turnscale/base/number_text.h"
#include "turnscale/commands/argument_checks.h"
#include "turnscale/export/blender_scene.h"
#include "turnscale/export/geo_files.h"
#include "turnscale/export/gps_fixes.h"
#include "turnscale/export/utc_time.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/terminal.h"
#include "turnscale/run/result_folder.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr double kUsualInterval = 1;  // s

struct ExportArguments {
  fs::path folder;
  bool gpx = false;
  bool kml = false;
  bool geojson = false;
  bool gltf = false;
  std::string origin;
  std::optional<double> heading;
  std::string start_time;
  fs::path fixes;
  std::optional<double> interval;
  std::optional<double> fov;
  std::optional<double> aspect;
  fs::path out;
};

// "latitude,longitude" or "latitude,longitude,height".
GeoPoint ParseOrigin(const std::string& text, bool& has_height) {
  const std::vector<double> numbers = ParseNumbers(text).value_or(std::vector<double>());
  const bool sane = (numbers.size() == 2 || numbers.size() == 3) && std::abs(numbers[0]) < 90 &&
                    std::abs(numbers[1]) <= 180 && std::isfinite(numbers.back());
  if (!sane)
    throw InputError("--origin " + text + ": give LATITUDE,LONGITUDE in degrees, or with the height in metres");
  has_height = numbers.size() == 3;
  return {numbers[0], numbers[1], has_height ? numbers[2] : 0};
}

std::string FixText(const FixPlacement& placed) {
  std::string text = fmt::format(
      "fixes    {} in the drive, {} of them outliers; {:.1f} m RMS from the path\n"
      "heading  {:.2f} +-{:.2f} deg at the start\n"
      "scale    by the fixes, the path is {:.1f} +-{:.1f} % too {} (it is not changed)\n",
      placed.fixes, placed.outliers, placed.rms, placed.placement.heading * kDegreesPerRadian,
      placed.heading_sigma * kDegreesPerRadian, 100 * std::abs(1 / placed.scale - 1),
      100 * placed.scale_sigma / placed.scale, placed.scale < 1 ? "long" : "short");
  if (placed.has_height)
    text += fmt::format("slope    path tilted by {:.1f} deg to the heights of the fixes\n",
                        RotationAngle(placed.placement.tilt) * kDegreesPerRadian);
  return text;
}

// The fixes do not fit the path, or have another length; empty where the sigmas of both explain it.
std::string FixWarning(const ExportArguments& arguments, const ResultFolder& results, const FixPlacement& placed) {
  if (!placed.fits) {
    return fmt::format(
        "--fixes {}: they do not fit the path (RMS {:.0f} m, {} of {} outliers): check --start-time, the order of "
        "latitude and longitude, and that they are of this drive",
        arguments.fixes.string(), placed.rms, placed.outliers, placed.fixes);
  }
  constexpr double kMostSigmas = 3;
  double path_sigma = 0;
  for (const FrameResult& frame : results.frames) path_sigma = std::max(path_sigma, frame.scale_sigma);
  if (std::abs(placed.scale - 1) <= kMostSigmas * std::hypot(placed.scale_sigma, path_sigma)) return "";
  return fmt::format(
      "{}: the path would have to be {:.0f} % {} to fit the fixes, more than the sigmas of both explain: check that "
      "the fixes are of this drive, the order of latitude and longitude, --start-time, and the lever arm of the run",
      arguments.fixes.string(), 100 * std::abs(placed.scale - 1), placed.scale > 1 ? "longer" : "shorter");
}

Placement PlacementFrom(const ExportArguments& arguments, const ResultFolder& results,
                        const std::vector<LevelPlace>& path, std::optional<double> start_time, bool& has_height,
                        std::string& messages) {
  if (!arguments.fixes.empty()) {
    const FixPlacement placed = PlaceByFixes(path, ReadGpsFixes(arguments.fixes, start_time));
    if (const std::string warning = FixWarning(arguments, results, placed); !warning.empty())
      PrintMessage("warning: " + warning);
    messages += FixText(placed);
    has_height = placed.has_height;
    return placed.placement;
  }
  if (arguments.origin.empty()) {
    throw InputError(
        "export: the place on Earth is needed; give --origin LATITUDE,LONGITUDE and --heading DEGREES, or --fixes "
        "FILE");
  }
  if (!arguments.heading) {
    throw InputError("--origin " + arguments.origin +
                     ": needs the direction of the car there; give --heading DEGREES, clockwise from north, or --fixes "
                     "FILE instead");
  }
  if (!(std::abs(*arguments.heading) <= 360))
    throw InputError(
        fmt::format("--heading {}: give degrees clockwise from north, from -360 to 360", *arguments.heading));
  return {ParseOrigin(arguments.origin, has_height), *arguments.heading / kDegreesPerRadian};
}

// UTC time of the drive's time 0, if it is known.
std::optional<double> StartTime(const std::string& given, double first_time) {
  if (AreSince1970(first_time)) {
    if (given.empty()) return 0;
    throw InputError("--start-time " + given + ": the drive's times are seconds since 1970 already, from " +
                     UtcTimeText(first_time) + "; leave it out");
  }
  if (given.empty()) return std::nullopt;
  const std::optional<double> time = ParseUtcTime(given);
  if (!time)
    throw InputError("--start-time " + given + ": give date, time and offset, such as 2026-03-22T07:14:05+01:00");
  return time;
}

// Of the camera: as given, else as the run knew it.
std::string Scene(const ExportArguments& arguments, const ResultFolder& results, std::string& messages) {
  constexpr double kUsualFov = 70;  // degrees
  constexpr double kUsualAspect = 16.0 / 9;
  double fov = arguments.fov ? *arguments.fov / kDegreesPerRadian : results.horizontal_fov;
  if (!(fov > 0)) {
    fov = kUsualFov / kDegreesPerRadian;
    messages += fmt::format(
        "camera   {:g} deg wide is assumed, since the results do not give a pinhole camera's; give --fov and "
        "--aspect\n",
        kUsualFov);
  }
  const double aspect = arguments.aspect.value_or(results.aspect > 0 ? results.aspect : kUsualAspect);
  return BlenderScene(results, arguments.folder.string(), fov, aspect);
}

// Empty where the scale is known, or an earlier version did not say.
std::string ScaleWarning(const ExportArguments& arguments, const ResultFolder& results) {
  if (results.scale_known.value_or(true)) return "";
  return arguments.folder.string() +
         (results.metric ? ": the scale is uncertain: lengths and speeds are rough estimates; summary.json has the "
                           "warnings of the run"
                         : ": the trajectory is up to scale: lengths are not in metres");
}

void ExportEarth(const ExportArguments& arguments, const ResultFolder& results, const std::string& stem,
                 std::string& messages) {
  GeoTrack track;
  track.name = arguments.folder.string();
  const std::vector<LevelPlace> path = LevelPath(results, arguments.folder.string());
  track.start_time = StartTime(arguments.start_time, path.front().time);
  const Placement placement = PlacementFrom(arguments, results, path, track.start_time, track.has_height, messages);
  track.places = PlaceOnEarth(path, placement, arguments.interval.value_or(kUsualInterval));
  std::vector<LevelPlace> turns;
  for (const TurnResult& turn : results.turns) {
    const int middle = (turn.first_frame + turn.last_frame) / 2;
    const auto at =
        std::find_if(path.begin(), path.end(), [&](const LevelPlace& place) { return place.frame >= middle; });
    if (at != path.end()) turns.push_back(*at);
  }
  track.turns = PlaceOnEarth(turns, placement);
  const auto write = [&](bool wanted, const char* extension, std::string (*text)(const GeoTrack&)) {
    if (!wanted) return;
    ReplaceFile(stem + extension, text(track));
    messages += "wrote    " + stem + extension + "\n";
  };
  write(arguments.gpx, ".gpx", GpxText);
  write(arguments.kml, ".kml", KmlText);
  write(arguments.geojson, ".geojson", GeoJsonText);
}

// The files without their extensions: --out may name a folder, or one of the files.
fs::path StemOf(const ExportArguments& arguments) {
  constexpr auto kName = "path";
  std::error_code none;
  if (arguments.out.empty()) return arguments.folder / kName;
  if (!arguments.out.has_filename()) fs::create_directories(arguments.out, none);
  if (!arguments.out.has_filename() || fs::is_directory(arguments.out, none)) return arguments.out / kName;
  const std::string extension = LowerExtension(arguments.out);
  for (const char* ours : {".gpx", ".kml", ".geojson", ".gltf"})
    if (extension == ours) return fs::path(arguments.out).replace_extension();
  return arguments.out;
}

void CheckFinite(const char* option, double value) {
  if (!std::isfinite(value)) throw InputError(fmt::format("{} {}: give a number", option, value));
}

void RunExport(const ExportArguments& arguments) {
  if (!arguments.gpx && !arguments.kml && !arguments.geojson && !arguments.gltf)
    throw InputError("export: nothing to write; give --gpx, --kml, --geojson or --gltf");
  const bool maps = arguments.gpx || arguments.kml || arguments.geojson;
  for (const GivenOption& option : {GivenOption{"--origin", !arguments.origin.empty()},
                                    {"--heading", arguments.heading.has_value()},
                                    {"--fixes", !arguments.fixes.empty()},
                                    {"--start-time", !arguments.start_time.empty()},
                                    {"--interval", arguments.interval.has_value()}})
    RequireFor(option, maps, "--gpx, --kml or --geojson");
  for (const GivenOption& option :
       {GivenOption{"--fov", arguments.fov.has_value()}, {"--aspect", arguments.aspect.has_value()}})
    RequireFor(option, arguments.gltf, "--gltf");
  if (arguments.interval) CheckFinite("--interval", *arguments.interval);
  if (arguments.fov) CheckFinite("--fov", *arguments.fov);
  if (arguments.aspect) CheckFinite("--aspect", *arguments.aspect);
  const ResultFolder results = ReadResultFolder(arguments.folder);
  const std::string stem = StemOf(arguments).string();
  std::string messages;
  const std::string scene = arguments.gltf ? Scene(arguments, results, messages) : "";
  if (maps) ExportEarth(arguments, results, stem, messages);
  if (arguments.gltf) {
    ReplaceFile(stem + ".gltf", scene);
    messages += "wrote    " + stem + ".gltf\n";
  }
  if (const std::string warning = ScaleWarning(arguments, results); !warning.empty())
    PrintMessage("warning: " + warning);
  PrintText(messages);
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
                               kUsualInterval))
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
