// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/sensitivity.h"

#include <algorithm>
#include <cmath>

#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {

ScaleSensitivity SensitivityOfStep(double psi, double travel_ratio) {
  return SensitivityOfScale(psi, DirectionOfTravel({psi, travel_ratio}, 1.0));
}

ScaleSensitivity PrintedSensitivityOfStep(double psi, double travel_ratio) {
  const double theta = DirectionOfTravel({psi, travel_ratio}, 1.0);
  const double denominator = std::cos(psi - 2 * theta) - 1;
  return {-std::sin(theta) / denominator, 2 * (std::sin(psi - theta) + std::sin(theta)) / denominator};
}

double ScaleErrorRatio(double psi, double travel_ratio, double angle_error, const ScaleSensitivity& sensitivity) {
  const double error = (std::abs(sensitivity.by_psi) + std::abs(sensitivity.by_theta)) * angle_error;
  return error / CameraDistance({psi, travel_ratio}, 1.0);
}

RegionError ErrorOverRegion(double angle_error, bool printed) {
  constexpr int kSteps = 40;
  RegionError region;
  for (int i = 0; i <= kSteps; ++i) {
    for (int k = 0; k <= kSteps; ++k) {
      const double psi = std::lerp(kRegionPsi[0], kRegionPsi[1], static_cast<double>(i) / kSteps) / kDegreesPerRadian;
      const double ratio = std::lerp(kRegionRatio[0], kRegionRatio[1], static_cast<double>(k) / kSteps);
      const ScaleSensitivity sensitivity =
          printed ? PrintedSensitivityOfStep(psi, ratio) : SensitivityOfStep(psi, ratio);
      const double error = ScaleErrorRatio(psi, ratio, angle_error, sensitivity);
      region.mean += error / ((kSteps + 1) * (kSteps + 1));
      region.worst = std::max(region.worst, error);
    }
  }
  return region;
}

}  // namespace turnscale
