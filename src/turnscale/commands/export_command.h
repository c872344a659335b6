// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace turnscale {

/// Default of ExportArguments::interval, seconds.
constexpr double kUsualExportInterval = 1;

/// Arguments of `export`, by the names of the program's options; empty texts and paths are not given.
struct ExportArguments {
  std::filesystem::path folder;  ///< with the results of a run, or of `rescale --report`
  bool gpx = false;
  bool kml = false;
  bool geojson = false;
  bool gltf = false;
  std::string origin;             ///< "LATITUDE,LONGITUDE[,HEIGHT]", degrees and metres
  std::optional<double> heading;  ///< degrees clockwise from north
  std::string start_time;
  std::filesystem::path fixes;
  std::optional<double> interval;  ///< seconds
  std::optional<double> fov;       ///< degrees
  std::optional<double> aspect;
  std::filesystem::path out;

  bool WantsMaps() const { return gpx || kml || geojson; }
};

/// What an export has written, and what there is to say of it.
struct ExportOutcome {
  std::vector<std::filesystem::path> files;
  std::vector<std::string> warnings;  ///< one line each
  std::string text;                   ///< of the placement and the camera, lines; may be empty
};

/// Writes the path of a run for maps and for Blender. Throws InputError and OutputError; nothing is written unless all
/// arguments are fine.
ExportOutcome ExecuteExport(const ExportArguments& arguments);

}  // namespace turnscale
