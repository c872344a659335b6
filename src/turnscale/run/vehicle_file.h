// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turnscale/config/yaml_map.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/refined_scale.h"

namespace turnscale {

/// Keys of the files that describe a car and its camera: car.yaml of a run, calibration.yaml of a calibration,
/// vehicle.yaml of a simulated drive. Not all of them are read: a drive does not depend on lateral_offset, for example.
const std::vector<std::string>& VehicleFileKeys();

/// Throws InputError where a file that is to describe a car has keys in groups, as one of settings does.
void RefuseSettingsFile(const YamlMap& file);

/// Magnitude up to which files state the correlation of two errors: readers need two errors that are not the same one.
constexpr double kMostCorrelation = 0.98;

/// `car.yaml`: what was given and what the drive has told of the car and its camera, each with its standard deviation;
/// what is not known is left out.
std::string VehicleFileText(const VehicleOptions& vehicle, const Mount& mount, const RefinedScale& scale);

/// Takes what such a file knows as prior knowledge of the same car's next drive. Throws InputError where a value makes
/// no sense.
void ReadVehicleFile(const std::filesystem::path& path, VehicleOptions& vehicle);

}  // namespace turnscale
