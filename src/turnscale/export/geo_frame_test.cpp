// SPDX-License-Identifier: MIT
#include "turnscale/export/geo_frame.h"

#include <gtest/gtest.h>

#include "turnscale/base/random.h"
#include "turnscale/geometry/random_vector.h"

namespace turnscale {
namespace {

TEST(GeoFrame, GoesThereAndBack) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const GeoPoint origin{random.Uniform(-89, 89), random.Uniform(-180, 180), random.Uniform(-100, 3000)};
    const GeoFrame frame(origin);
    const Eigen::Vector3d local =
        DrawVector<3>([&] { return random.Uniform(-1, 1); }).cwiseProduct(Eigen::Vector3d(2e4, 2e4, 500));
    EXPECT_LT((frame.ToLocal(frame.FromLocal(local)) - local).norm(), 1e-6);
    EXPECT_LT(frame.ToLocal(origin).norm(), 1e-8);
  }
}

// Lengths of a degree on the ellipsoid (published values of WGS 84, metres).
TEST(GeoFrame, KnowsTheSizeOfTheEarth) {
  const auto north = [](double latitude) {
    return GeoFrame({latitude, 10, 0}).ToLocal({latitude + 0.001, 10, 0}).y() * 1000;
  };
  const auto east = [](double latitude) {
    return GeoFrame({latitude, 10, 0}).ToLocal({latitude, 10.001, 0}).x() * 1000;
  };
  EXPECT_NEAR(north(-0.0005), 110574.3, 0.5);
  EXPECT_NEAR(east(0), 111319.5, 0.5);
  EXPECT_NEAR(north(44.9995), 111131.7, 0.5);
  EXPECT_NEAR(east(45), 78846.8, 0.5);
}

TEST(GeoFrame, LongitudesStayInTheirRange) {
  const GeoPoint beyond = GeoFrame({0, 179.999, 0}).FromLocal({1000, 0, 0});
  EXPECT_LT(beyond.longitude, -179.9);
}

}  // namespace
}  // namespace turnscale
