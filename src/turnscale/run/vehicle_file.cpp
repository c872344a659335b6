// SPDX-License-Identifier: MIT
#include "turnscale/run/vehicle_file.h"

#include <algorithm>
#include <cmath>

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

std::string Line(const char* key, double value, const char* comment = "") {
  return fmt::format("{}: {:.6g}{}{}\n", key, value, *comment != 0 ? "  # " : "", comment);
}

// Of the errors of a car's constants.
struct Correlations {
  double lever_arm_slip = 0;
  double height_lever_arm = 0;
  double height_slip = 0;
};

// All smaller by the same factor where a reader could not tell the three errors apart.
Correlations Distinct(const Correlations& found) {
  Eigen::Matrix3d matrix;
  matrix << 0, found.lever_arm_slip, found.height_lever_arm,  //
      found.lever_arm_slip, 0, found.height_slip,             //
      found.height_lever_arm, found.height_slip, 0;
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix).eigenvalues()[0];
  const double shrink = kMostCorrelation / std::max(-least, kMostCorrelation);
  return {shrink * found.lever_arm_slip, shrink * found.height_lever_arm, shrink * found.height_slip};
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
                                                "vehicle_from_camera_wxyz",
                                                "confidence",
                                                "frames",
                                                "steps",
                                                "turns",
                                                "turning_deg",
                                                "input"};
  return keys;
}

std::string VehicleFileText(const VehicleOptions& vehicle, const Mount& mount, const RefinedScale& scale) {
  std::string text =
      "# A car and its camera, with standard deviations, for run --vehicle. Axes x right, y down, z forward.\n";
  // Where the measures contradict each other, or the trajectory does not use what was refined, all is as given.
  const bool refined = scale.estimate && scale.estimate->has_reliable_car();
  const CarRefinement* car = refined ? &scale.estimate->car : nullptr;
  // One of the two lengths is wrong, by as much as they disagree.
  const double conflict =
      scale.estimate && scale.estimate->height_conflict
          ? std::log(scale.estimate->height_conflict->found / scale.estimate->height_conflict->given)
          : 0.0;
  // A camera that was moved since is not as the file of the car has it.
  const bool as_known = vehicle.camera_known && mount.first_keyframe == 0;
  if (!vehicle.calibrate_camera || as_known || mount.found) {
    YawPitchRoll angles = YawPitchRollFromRotation(mount.vehicle_from_camera);
    double yaw_sigma = mount.found ? std::max(mount.sigma.yaw, vehicle.yaw_sigma) : vehicle.yaw_sigma;
    // What the straights have told.
    if (car) {
      angles.yaw += car->yaw_error;
      yaw_sigma = car->yaw_error_sigma;
    }
    text += Line("yaw_deg", InDegrees(angles.yaw), "to the right");
    text += Line("pitch_deg", InDegrees(angles.pitch), "up");
    text += Line("roll_deg", InDegrees(angles.roll), "leaning right");
    text += Line("yaw_sigma_deg", InDegrees(yaw_sigma));
    if (mount.found || as_known) {
      text += Line("pitch_sigma_deg", InDegrees(mount.found ? mount.sigma.pitch : vehicle.known_pitch_sigma));
      text += Line("roll_sigma_deg", InDegrees(mount.found ? mount.sigma.roll : vehicle.known_roll_sigma));
    }
  }
  // However uncertain a length is, and however much the two disagree, the file is one that can be read again.
  const auto sigma_of = [&](double length, double sigma) {
    return std::min(std::hypot(sigma, conflict * length), std::max(kMostLengthSigma * length, sigma));
  };
  Correlations correlations;
  if (vehicle.lever_arm) {
    const bool known = car && car->lever_arm > 0;
    const double sigma = known ? std::min(car->lever_arm_sigma, kMostLengthSigma * car->lever_arm)
                               : sigma_of(*vehicle.lever_arm, vehicle.LeverArmSigma());
    text += Line("lever_arm", known ? car->lever_arm : *vehicle.lever_arm,
                 "metres from the rear axle forward to the camera");
    text += Line("lever_arm_sigma", sigma);
    correlations.lever_arm_slip = known       ? car->lever_arm_slip_correlation
                                  : sigma > 0 ? vehicle.lever_arm_slip_correlation * vehicle.LeverArmSigma() / sigma
                                              : 0.0;
  }
  if (car && car->camera_height > 0) {
    if (car->lever_arm > 0) correlations.height_lever_arm = car->height_correlation;
    if (car->side_slip_sigma > 0) correlations.height_slip = car->height_slip_correlation;
  }
  correlations = Distinct(correlations);
  text += Line("side_slip", car ? car->side_slip : vehicle.side_slip, "c in L_eff = L - c v^2, s^2/m");
  text += Line("side_slip_sigma", car ? car->side_slip_sigma : vehicle.side_slip_sigma);
  if (correlations.lever_arm_slip != 0)
    text += Line("lever_arm_slip_correlation", correlations.lever_arm_slip,
                 "of the errors of the lever arm and of the side slip");
  if (car && car->camera_height > 0) {
    text += Line("height", car->camera_height, "of the camera above the road, metres");
    text += Line("height_sigma", car->camera_height_sigma);
    if (car->lever_arm > 0)
      text +=
          Line("height_correlation", correlations.height_lever_arm, "of the errors of the height and of the lever arm");
    if (car->side_slip_sigma > 0)
      text +=
          Line("height_slip_correlation", correlations.height_slip, "of the errors of the height and of the side slip");
  } else if (vehicle.camera_height) {
    text += Line("height", *vehicle.camera_height, "of the camera above the road, metres");
    text += Line("height_sigma", sigma_of(*vehicle.camera_height, vehicle.HeightSigma()));
  }
  return text;
}

void ReadVehicleFile(const std::filesystem::path& path, VehicleOptions& vehicle) {
  const YamlMap map(path);
  RefuseCameraFile(map);
  if (map.Has("vehicle"))
    throw InputError(path.string() + ": is a file of settings, not of a car; give it as --settings");
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
  map.CheckRead(vehicle);
}

}  // namespace turnscale
