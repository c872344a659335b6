// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/sensitivity.h"

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {
namespace {

TEST(Sensitivity, PrintedDerivativeByPsiIsHalfOfFiniteDifferences) {
  for (const double ratio : {0.1, 0.4, 1.0, 5.0}) {
    for (const double psi : {-8.0, 1.0, 3.0, 10.0}) {
      const double theta = DirectionOfTravel({psi / kDegreesPerRadian, ratio}, 1);
      const double h = 1e-6;
      const auto observed = [&](double dpsi, double dtheta) {
        return ObservedDistance(psi / kDegreesPerRadian + dpsi, theta + dtheta, 1);
      };
      const double by_psi = (observed(h, 0) - observed(-h, 0)) / (2 * h);
      const double by_theta = (observed(0, h) - observed(0, -h)) / (2 * h);
      const ScaleSensitivity right = SensitivityOfStep(psi / kDegreesPerRadian, ratio);
      const ScaleSensitivity printed = PrintedSensitivityOfStep(psi / kDegreesPerRadian, ratio);
      EXPECT_NEAR(right.by_psi / by_psi, 1, 1e-5) << ratio << ' ' << psi;
      EXPECT_NEAR(printed.by_psi / by_psi, 0.5, 1e-5) << ratio << ' ' << psi;
      EXPECT_NEAR(right.by_theta / by_theta, 1, 1e-5) << ratio << ' ' << psi;
      EXPECT_NEAR(printed.by_theta / by_theta, 1, 1e-5) << ratio << ' ' << psi;
    }
  }
}

TEST(Sensitivity, ErrorOverRegionIsWorstWhereTheCarTurnsLeastAndGoesFarthest) {
  for (const bool printed : {false, true}) {
    const RegionError region = ErrorOverRegion(0.1 / kDegreesPerRadian, printed);
    const ScaleSensitivity corner =
        printed ? PrintedSensitivityOfStep(3 / kDegreesPerRadian, 0.4) : SensitivityOfStep(3 / kDegreesPerRadian, 0.4);
    EXPECT_DOUBLE_EQ(region.worst, ScaleErrorRatio(3 / kDegreesPerRadian, 0.4, 0.1 / kDegreesPerRadian, corner));
    EXPECT_GT(region.mean, 0.3 * region.worst);
    EXPECT_LT(region.mean, 0.8 * region.worst);
    EXPECT_NEAR(ErrorOverRegion(0.05 / kDegreesPerRadian, printed).mean / region.mean, 0.5, 1e-12);
  }
}

}  // namespace
}  // namespace turnscale
