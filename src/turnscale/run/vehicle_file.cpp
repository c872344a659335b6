// SPDX-License-Identifier: MIT
#include "turnscale/run/vehicle_file.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "turnscale/camera/camera_file.h"
#include "turnscale/config/yaml_map.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {
namespace {

// Standard deviations of what changes from drive to drive: load and tyres lift the camera, and turn it.
constexpr double kHeightBetweenDrives = 0.01;                  // relative
constexpr double kYawBetweenDrives = 0.1 / kDegreesPerRadian;  // rad
constexpr double kPitchBetweenDrives = 0.4 / kDegreesPerRadian;
constexpr double kRollBetweenDrives = 0.5 / kDegreesPerRadian;
// A stabiliser adapts to the motion.
constexpr double kLagBetweenDrives = 0.02;  // s

std::string Line(const char* key, double value, const char* comment = "") {
  return fmt::format("{}: {:.6g}{}{}\n", key, value, *comment != 0 ? "  # " : "", comment);
}

// Of the errors of a car's constants; nothing where one of the two is not known.
struct Correlations {
  double lever_arm_slip = 0;
  std::optional<double> height_lever_arm = {};
  std::optional<double> height_slip = {};
};

// All smaller by the same factor where a reader could not tell the three errors apart.
Correlations Distinct(Correlations correlations) {
  const double height_lever_arm = correlations.height_lever_arm.value_or(0);
  const double height_slip = correlations.height_slip.value_or(0);
  Eigen::Matrix3d matrix;
  matrix << 0, correlations.lever_arm_slip, height_lever_arm,  //
      correlations.lever_arm_slip, 0, height_slip,             //
      height_lever_arm, height_slip, 0;
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix).eigenvalues()[0];
  const double shrink = kMostCorrelation / std::max(-least, kMostCorrelation);
  correlations.lever_arm_slip *= shrink;
  for (std::optional<double>* one : {&correlations.height_lever_arm, &correlations.height_slip})
    if (*one) **one *= shrink;
  return correlations;
}

struct Measure {
  double value = 0;
  double sigma = 0;
};

struct KnownRotation {
  YawPitchRoll angles;
  double yaw_sigma = 0;
  std::optional<YawPitchRoll> sigma = {};  // of pitch and roll
};

// What a drive leaves known of the car: lengths in metres, angles in rad.
struct KnownCar {
  std::optional<KnownRotation> rotation = {};
  std::optional<Measure> lever_arm = {};
  Measure side_slip;  // s^2/m
  std::optional<Measure> height = {};
  Correlations correlations;
  std::optional<Measure> lag = {};  // of stabilised images, s
};

// Where the measures contradict each other, or the trajectory does not use what was refined, all is as given.
const CarRefinement* RefinedCar(const RefinedScale& scale) {
  const bool refined = scale.estimate && scale.estimate->has_reliable_car();
  return refined ? &scale.estimate->car : nullptr;
}

std::optional<KnownRotation> RotationOf(const VehicleOptions& vehicle, const Mount& mount, const CarRefinement* car) {
  // A camera that was moved since is not as the file of the car has it.
  const bool as_known = vehicle.camera_known && mount.first_keyframe == 0;
  if (vehicle.calibrate_camera && !as_known && !mount.found) return std::nullopt;
  KnownRotation rotation = {YawPitchRollFromRotation(mount.vehicle_from_camera), vehicle.yaw_sigma};
  if (mount.found) {
    rotation.yaw_sigma = std::max(mount.sigma.yaw, vehicle.yaw_sigma);
    rotation.sigma = mount.sigma;
  } else if (as_known) {
    rotation.sigma = {0, vehicle.known_pitch_sigma, vehicle.known_roll_sigma};
  }
  if (!car) return rotation;
  // What the straights have told.
  rotation.angles.yaw += car->yaw_error;
  rotation.yaw_sigma = car->yaw_error_sigma;
  return rotation;
}

// Of a given length. If it disagrees with another one, one of the two is wrong, by as much as they disagree; however
// much that is, the file is one that can be read again.
double SigmaOfGiven(double length, double sigma, const RefinedScale& scale) {
  const HeightConflict* conflict =
      scale.estimate && scale.estimate->height_conflict ? &*scale.estimate->height_conflict : nullptr;
  const double disagreement = conflict ? std::log(conflict->found / conflict->given) : 0.0;
  return std::min(std::hypot(sigma, disagreement * length), std::max(kMostLengthSigma * length, sigma));
}

KnownCar WhatIsKnown(const VehicleOptions& vehicle, const Mount& mount, const RefinedScale& scale) {
  const CarRefinement* car = RefinedCar(scale);
  KnownCar known;
  known.rotation = RotationOf(vehicle, mount, car);
  known.side_slip =
      car ? Measure{car->side_slip, car->side_slip_sigma} : Measure{vehicle.side_slip, vehicle.side_slip_sigma};
  if (vehicle.lever_arm && car && car->lever_arm > 0) {
    known.lever_arm = {car->lever_arm, std::min(car->lever_arm_sigma, kMostLengthSigma * car->lever_arm)};
    known.correlations.lever_arm_slip = car->lever_arm_slip_correlation;
  } else if (vehicle.lever_arm) {
    const double sigma = SigmaOfGiven(*vehicle.lever_arm, vehicle.LeverArmSigma(), scale);
    known.lever_arm = {*vehicle.lever_arm, sigma};
    if (sigma > 0)
      known.correlations.lever_arm_slip = vehicle.lever_arm_slip_correlation * vehicle.LeverArmSigma() / sigma;
  }
  if (car && car->camera_height > 0) {
    known.height = {car->camera_height, car->camera_height_sigma};
    if (car->lever_arm > 0) known.correlations.height_lever_arm = car->height_correlation;
    if (car->side_slip_sigma > 0) known.correlations.height_slip = car->height_slip_correlation;
  } else if (vehicle.camera_height) {
    known.height = {*vehicle.camera_height, SigmaOfGiven(*vehicle.camera_height, vehicle.HeightSigma(), scale)};
  }
  known.correlations = Distinct(known.correlations);
  if (vehicle.image_lag_sigma > 0) known.lag = {vehicle.image_lag, vehicle.image_lag_sigma};
  const std::optional<ImageLag> lag = scale.estimate ? scale.estimate->image_lag : std::nullopt;
  if (lag && lag->is_confirmed() && scale.estimate->agrees()) known.lag = {lag->found, lag->found_sigma};
  return known;
}

std::string RotationText(const KnownRotation& rotation) {
  std::string text = Line("yaw_deg", InDegrees(rotation.angles.yaw), "to the right") +
                     Line("pitch_deg", InDegrees(rotation.angles.pitch), "up") +
                     Line("roll_deg", InDegrees(rotation.angles.roll), "leaning right") +
                     Line("yaw_sigma_deg", InDegrees(rotation.yaw_sigma));
  if (rotation.sigma)
    text += Line("pitch_sigma_deg", InDegrees(rotation.sigma->pitch)) +
            Line("roll_sigma_deg", InDegrees(rotation.sigma->roll));
  return text;
}

}  // namespace

const std::vector<std::string>& VehicleFileKeys() {
  static const std::vector<std::string> keys = {"yaw_deg",
                                                "pitch_deg",
                                                "roll_deg",
                                                "yaw_sigma_deg",
                                                "pitch_sigma_deg",
                                                "roll_sigma_deg",
                                                "lever_arm",
                                                "side_slip",
                                                "lateral_offset",
                                                "height",
                                                "lever_arm_sigma",
                                                "side_slip_sigma",
                                                "height_sigma",
                                                "height_correlation",
                                                "height_slip_correlation",
                                                "lever_arm_slip_correlation",
                                                "image_lag",
                                                "image_lag_sigma",
                                                "vehicle_from_camera_wxyz",
                                                "confidence",
                                                "frames",
                                                "steps",
                                                "turns",
                                                "turning_deg",
                                                "input"};
  return keys;
}

void RefuseSettingsFile(const YamlMap& file) {
  for (const std::string& key : file.Keys())
    if (file.IsMap(key))
      file.Reject(key, "is of a file of settings, which --settings takes; give a car's file here, such as car.yaml");
}

std::string VehicleFileText(const VehicleOptions& vehicle, const Mount& mount, const RefinedScale& scale) {
  const KnownCar known = WhatIsKnown(vehicle, mount, scale);
  const Correlations& correlations = known.correlations;
  std::string text =
      "# A car and its camera, with standard deviations, for run --vehicle. Axes x right, y down, z forward.\n";
  if (known.rotation) text += RotationText(*known.rotation);
  if (known.lever_arm)
    text += Line("lever_arm", known.lever_arm->value, "metres from the rear axle forward to the camera") +
            Line("lever_arm_sigma", known.lever_arm->sigma);
  text += Line("side_slip", known.side_slip.value, "c in L_eff = L - c v^2, s^2/m") +
          Line("side_slip_sigma", known.side_slip.sigma);
  if (correlations.lever_arm_slip != 0)
    text += Line("lever_arm_slip_correlation", correlations.lever_arm_slip,
                 "of the errors of the lever arm and of the side slip");
  if (known.height)
    text += Line("height", known.height->value, "of the camera above the road, metres") +
            Line("height_sigma", known.height->sigma);
  if (correlations.height_lever_arm)
    text +=
        Line("height_correlation", *correlations.height_lever_arm, "of the errors of the height and of the lever arm");
  if (correlations.height_slip)
    text +=
        Line("height_slip_correlation", *correlations.height_slip, "of the errors of the height and of the side slip");
  if (known.lag)
    text += Line("image_lag", known.lag->value, "of the orientation of the images, which are stabilised, seconds") +
            Line("image_lag_sigma", known.lag->sigma);
  return text;
}

void ReadVehicleFile(const std::filesystem::path& path, VehicleOptions& vehicle) {
  const YamlMap map(path);
  RefuseCameraFile(map);
  RefuseSettingsFile(map);
  map.AllowOnly(VehicleFileKeys());
  const auto not_negative = [&](const char* key, double otherwise) {
    if (!map.Has(key)) return otherwise;
    const double value = map.Number(key);
    if (value < 0) map.Reject(key, "must not be negative");
    return value;
  };
  if (map.Has("yaw_deg")) {
    const auto angle = [&](const char* key) { return map.Angle(key) / kDegreesPerRadian; };
    vehicle.vehicle_from_camera = RotationFromYawPitchRoll({angle("yaw_deg"), angle("pitch_deg"), angle("roll_deg")});
    vehicle.camera_known = true;
    const auto sigma = [&](const char* key, double between_drives, double& value) {
      if (map.Has(key)) value = std::hypot(not_negative(key, 0) / kDegreesPerRadian, between_drives);
    };
    sigma("yaw_sigma_deg", kYawBetweenDrives, vehicle.yaw_sigma);
    sigma("pitch_sigma_deg", kPitchBetweenDrives, vehicle.known_pitch_sigma);
    sigma("roll_sigma_deg", kRollBetweenDrives, vehicle.known_roll_sigma);
  }
  const auto correlation = [&](const char* key) {
    if (!map.Has(key)) return 0.0;
    const double value = map.Number(key);
    if (!(std::abs(value) <= 1)) map.Reject(key, "has to be between -1 and 1");
    return value;
  };
  if (map.Has("lever_arm")) {
    vehicle.lever_arm = map.Positive("lever_arm");
    vehicle.lever_arm_sigma.reset();
    if (map.Has("lever_arm_sigma")) vehicle.lever_arm_sigma = not_negative("lever_arm_sigma", 0);
  }
  if (map.Has("side_slip")) {
    vehicle.side_slip = not_negative("side_slip", 0);
    vehicle.side_slip_sigma = not_negative("side_slip_sigma", kUsualSideSlipSigma);
  }
  // With one of the two from elsewhere, or one of their sigmas, their errors are independent.
  if (map.Has("lever_arm") || map.Has("side_slip")) {
    const bool both = map.Has("lever_arm") && map.Has("side_slip");
    const bool with_sigmas = map.Has("lever_arm_sigma") && map.Has("side_slip_sigma");
    const double stated = correlation("lever_arm_slip_correlation");
    vehicle.lever_arm_slip_correlation = both && with_sigmas ? stated : 0.0;
  }
  if (map.Has("height")) {
    vehicle.camera_height = map.Positive("height");
    if (*vehicle.camera_height > kHighestCamera)
      map.Reject("height", fmt::format("has to be the height of the camera in metres, up to {}", kHighestCamera));
    vehicle.camera_height_sigma =
        std::hypot(not_negative("height_sigma", 0), kHeightBetweenDrives * *vehicle.camera_height);
    if (*vehicle.camera_height_sigma >= *vehicle.camera_height)
      map.Reject("height_sigma", "has to be below the height");
    // What changes between drives has nothing to do with the other constants.
    const double share = not_negative("height_sigma", 0) / *vehicle.camera_height_sigma;
    vehicle.height_correlation = share * correlation("height_correlation");
    vehicle.height_slip_correlation = share * correlation("height_slip_correlation");
  }
  if (map.Has("image_lag") && !map.Has("image_lag_sigma")) map.Reject("image_lag", "needs image_lag_sigma");
  if (map.Has("image_lag_sigma")) {
    vehicle.image_lag = map.Has("image_lag") ? map.Number("image_lag") : 0.0;
    vehicle.image_lag_sigma = std::hypot(not_negative("image_lag_sigma", 0), kLagBetweenDrives);
  }
  map.CheckRead(vehicle);
}

}  // namespace turnscale
