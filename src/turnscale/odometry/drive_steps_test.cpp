// SPDX-License-Identifier: MIT
#include "turnscale/odometry/drive_steps.h"

#include <cmath>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(DriveSteps, AnAspectThatIsUncertainMakesAMeasuredHeightSo) {
  VehicleOptions vehicle;
  EXPECT_EQ(PriorOf(vehicle, {}, 0.03).camera_height_sigma, 0) << "no height is given";
  vehicle.camera_height = 1.5;
  vehicle.height_correlation = 0.8;
  vehicle.height_slip_correlation = -0.4;
  const double before = vehicle.HeightSigma();
  EXPECT_EQ(PriorOf(vehicle, {}, 0).camera_height_sigma, before) << "the aspect is given";
  const CarPrior car = PriorOf(vehicle, {}, 0.03);
  const double after = car.camera_height_sigma;
  EXPECT_EQ(car.camera_height, 1.5);
  EXPECT_NEAR(after, std::hypot(before, 0.045), 1e-12);
  EXPECT_NEAR(car.height_correlation * after, 0.8 * before, 1e-12) << "the covariances stay";
  EXPECT_NEAR(car.height_slip_correlation * after, -0.4 * before, 1e-12);
  vehicle.height_from_images = true;
  EXPECT_EQ(PriorOf(vehicle, {}, 0.03).camera_height_sigma, before) << "it has the error of the aspect";
}

}  // namespace
}  // namespace turnscale
