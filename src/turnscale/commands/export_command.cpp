// SPDX-License-Identifier: MIT
#include "turnscale/commands/export_command.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/file_extension.h"
#include "turnscale/base/number_text.h"
#include "turnscale/commands/argument_checks.h"
#include "turnscale/commands/rescaled_folder.h"
#include "turnscale/export/blender_scene.h"
#include "turnscale/export/geo_files.h"
#include "turnscale/export/gps_fixes.h"
#include "turnscale/export/utc_time.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/output_file.h"
#include "turnscale/run/result_folder.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

// The path on Earth, and what there is to say of it.
struct PlacedPath {
  Placement placement;
  bool has_height = false;
  std::string text = {};     // lines
  std::string warning = {};  // one line
};

// By how much the path is too long or too short by the fixes.
double PathErrorPercent(const FixPlacement& placed) { return 100 * std::abs(1 / placed.scale - 1); }

std::string FixText(const FixPlacement& placed) {
  std::string text = fmt::format(
      "fixes    {} in the drive, {} of them outliers; {:.1f} m RMS from the path\n"
      "heading  {:.2f} +-{:.2f} deg at the start\n"
      "scale    by the fixes, the path is {:.1f} +-{:.1f} % too {} (it is not changed)\n",
      placed.fixes, placed.outliers, placed.rms, placed.placement.heading * kDegreesPerRadian,
      placed.heading_sigma * kDegreesPerRadian, PathErrorPercent(placed), 100 * placed.scale_sigma / placed.scale,
      placed.scale < 1 ? "long" : "short");
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
      "{}: the path is {:.1f} % too {} by the fixes, more than the sigmas of both explain: check that the fixes are of "
      "this drive, the order of latitude and longitude, --start-time, and the lever arm of the run",
      arguments.fixes.string(), PathErrorPercent(placed), placed.scale < 1 ? "long" : "short");
}

PlacedPath PlaceByFile(const ExportArguments& arguments, const ResultFolder& results,
                       const std::vector<LevelPlace>& path, std::optional<double> start_time) {
  const FixPlacement placed = PlaceByFixes(path, ReadGpsFixes(arguments.fixes, start_time));
  return {placed.placement, placed.has_height, FixText(placed), FixWarning(arguments, results, placed)};
}

// "latitude,longitude" or "latitude,longitude,height".
PlacedPath PlaceByOrigin(const std::string& origin, double heading) {
  const std::vector<double> numbers = ParseNumbers(origin).value_or(std::vector<double>());
  if (numbers.size() >= 2 && std::abs(numbers[0]) > 90 && std::abs(numbers[0]) <= 180)
    throw InputError(
        fmt::format("--origin {}: a latitude of {} is beyond 90 degrees; give the latitude first, then the longitude",
                    origin, numbers[0]));
  const bool sane = (numbers.size() == 2 || numbers.size() == 3) && std::abs(numbers[0]) < 90 &&
                    std::abs(numbers[1]) <= 180 && std::isfinite(numbers.back());
  if (!sane)
    throw InputError("--origin " + origin + ": give LATITUDE,LONGITUDE in degrees, or with the height in metres");
  const bool has_height = numbers.size() == 3;
  const GeoPoint place = {numbers[0], numbers[1], has_height ? numbers[2] : 0};
  return {{place, heading / kDegreesPerRadian}, has_height};
}

PlacedPath Place(const ExportArguments& arguments, const ResultFolder& results, const std::vector<LevelPlace>& path,
                 std::optional<double> start_time) {
  if (!arguments.fixes.empty()) return PlaceByFile(arguments, results, path, start_time);
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
  return PlaceByOrigin(arguments.origin, *arguments.heading);
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

// The line that says so. `recorded_from`: ResultFolder's.
std::string WhyWithoutTimes(const std::string& recorded_from) {
  if (recorded_from.empty())
    return "times    GPX has none, as the date and time of the drive are unknown; give --start-time\n";
  return fmt::format(
      "times    GPX has none, as the time zone of the recorder is unknown: by the names of the clips, the drive begins "
      "at {0}; give --start-time {0} with the offset from UTC, such as {0}+01:00\n",
      recorded_from);
}

// The middles of the turns.
std::vector<LevelPlace> TurnsAlong(const std::vector<LevelPlace>& path, const std::vector<TurnResult>& turns) {
  std::vector<LevelPlace> middles;
  for (const TurnResult& turn : turns) {
    const int middle = (turn.first_frame + turn.last_frame) / 2;
    const auto at = std::ranges::find_if(path, [&](const LevelPlace& place) { return place.frame >= middle; });
    if (at != path.end()) middles.push_back(*at);
  }
  return middles;
}

// Without the path to it, which tells those who get the file only about this machine.
std::string FolderName(const fs::path& folder) {
  std::error_code none;
  const fs::path whole = fs::absolute(folder, none).lexically_normal();
  const fs::path name = whole.has_filename() ? whole.filename() : whole.parent_path().filename();
  return (name.empty() ? folder : name).string();
}

// A file and its text.
struct FileToWrite {
  const char* extension;
  std::string text;
};

std::vector<FileToWrite> MapFiles(const ExportArguments& arguments, const ResultFolder& results,
                                  ExportOutcome& outcome) {
  GeoTrack track;
  track.name = FolderName(arguments.folder);
  const std::vector<LevelPlace> path = LevelPath(results, arguments.folder.string());
  track.start_time = StartTime(arguments.start_time, path.front().time);
  const PlacedPath placed = Place(arguments, results, path, track.start_time);
  track.has_height = placed.has_height;
  track.places = PlaceOnEarth(path, placed.placement, arguments.interval.value_or(kUsualExportInterval));
  track.turns = PlaceOnEarth(TurnsAlong(path, results.turns), placed.placement);
  outcome.text += placed.text;
  if (!placed.warning.empty()) outcome.warnings.push_back(placed.warning);
  // The other formats have seconds of the drive instead.
  if (arguments.gpx && !track.start_time) outcome.text += WhyWithoutTimes(results.recorded_from);
  std::vector<FileToWrite> files;
  if (arguments.gpx) files.push_back({".gpx", GpxText(track)});
  if (arguments.kml) files.push_back({".kml", KmlText(track)});
  if (arguments.geojson) files.push_back({".geojson", GeoJsonText(track)});
  return files;
}

// The camera is as given, else as the run knew it.
FileToWrite SceneFile(const ExportArguments& arguments, const ResultFolder& results, ExportOutcome& outcome) {
  constexpr double kUsualFov = 70;  // degrees
  constexpr double kUsualAspect = 16.0 / 9;
  double fov = arguments.fov ? *arguments.fov / kDegreesPerRadian : results.horizontal_fov;
  if (!(fov > 0)) {
    fov = kUsualFov / kDegreesPerRadian;
    outcome.text += fmt::format(
        "camera   {:g} deg wide is assumed, since the results do not give a pinhole camera's; give --fov and "
        "--aspect\n",
        kUsualFov);
  }
  const double aspect = arguments.aspect.value_or(results.aspect > 0 ? results.aspect : kUsualAspect);
  return {".gltf", BlenderScene(results, arguments.folder.string(), fov, aspect)};
}

// Empty where the scale is known, or an earlier version did not say.
std::string ScaleWarning(const ExportArguments& arguments, const ResultFolder& results) {
  if (results.scale_known.value_or(true)) return "";
  return arguments.folder.string() +
         (results.metric ? ": the scale is uncertain: lengths and speeds are rough estimates; summary.json has the "
                           "warnings of the run"
                         : ": the trajectory is up to scale: lengths are not in metres");
}

// The files without their extensions: --out may name a folder, or one of the files.
fs::path StemOf(const ExportArguments& arguments) {
  constexpr auto kName = "path";
  std::error_code none;
  if (arguments.out.empty()) return arguments.folder / kName;
  if (!arguments.out.has_filename() || fs::is_directory(arguments.out, none)) return arguments.out / kName;
  const std::string extension = LowerExtension(arguments.out);
  for (const char* ours : {".gpx", ".kml", ".geojson", ".gltf"})
    if (extension == ours) return fs::path(arguments.out).replace_extension();
  return arguments.out;
}

void CheckFinite(const char* option, double value) {
  if (!std::isfinite(value)) throw InputError(fmt::format("{} {}: give a number", option, value));
}

void Check(const ExportArguments& arguments) {
  if (!arguments.WantsMaps() && !arguments.gltf)
    throw InputError("export: nothing to write; give --gpx, --kml, --geojson or --gltf");
  for (const GivenOption& option : {GivenOption{"--origin", !arguments.origin.empty()},
                                    {"--heading", arguments.heading.has_value()},
                                    {"--fixes", !arguments.fixes.empty()},
                                    {"--start-time", !arguments.start_time.empty()},
                                    {"--interval", arguments.interval.has_value()}})
    RequireFor(option, arguments.WantsMaps(), "--gpx, --kml or --geojson");
  for (const GivenOption& option :
       {GivenOption{"--fov", arguments.fov.has_value()}, {"--aspect", arguments.aspect.has_value()}})
    RequireFor(option, arguments.gltf, "--gltf");
  if (arguments.interval) CheckFinite("--interval", *arguments.interval);
  if (arguments.fov) CheckFinite("--fov", *arguments.fov);
  if (arguments.aspect) CheckFinite("--aspect", *arguments.aspect);
}

}  // namespace

ExportOutcome ExecuteExport(const ExportArguments& arguments) {
  Check(arguments);
  const ResultFolder results =
      IsRescaleFolder(arguments.folder) ? ReadRescaleFolder(arguments.folder) : ReadResultFolder(arguments.folder);
  const std::string stem = StemOf(arguments).string();
  ExportOutcome outcome;
  std::optional<FileToWrite> scene;
  if (arguments.gltf) scene = SceneFile(arguments, results, outcome);
  std::vector<FileToWrite> files;
  if (arguments.WantsMaps()) files = MapFiles(arguments, results, outcome);
  if (scene) files.push_back(*std::move(scene));
  if (std::error_code none; !arguments.out.empty() && !arguments.out.has_filename())
    fs::create_directories(arguments.out, none);
  for (const FileToWrite& file : files) {
    outcome.files.emplace_back(stem + file.extension);
    ReplaceFile(outcome.files.back(), file.text);
  }
  if (std::string warning = ScaleWarning(arguments, results); !warning.empty())
    outcome.warnings.push_back(std::move(warning));
  return outcome;
}

}  // namespace turnscale
