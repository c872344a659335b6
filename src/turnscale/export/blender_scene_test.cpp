// SPDX-License-Identifier: MIT
#include "turnscale/export/blender_scene.h"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/error.h"
#include "turnscale/export/test_results.h"

namespace turnscale {
namespace {

TEST(BlenderScene, HasAnAnimatedCamera) {
  ResultFolder results = TestResults(50);
  results.landmarks = {{1, 0, 5}, {2, -1, 8}};
  const auto gltf = nlohmann::json::parse(BlenderScene(results, "out", 1.2, 1.5));
  EXPECT_EQ(gltf["asset"]["version"], "2.0");
  EXPECT_EQ(gltf["nodes"].size(), 3u);
  ASSERT_EQ(gltf["accessors"].size(), 4u);
  size_t end = 0;
  for (const auto& view : gltf["bufferViews"]) {
    EXPECT_EQ(view["byteOffset"], end);
    end += view["byteLength"].get<size_t>();
  }
  EXPECT_EQ(gltf["buffers"][0]["byteLength"], end);
  const auto& positions = gltf["accessors"][1];
  EXPECT_EQ(positions["count"], 50);
  // The drive leads ahead (-z), and to the right (+x), on level ground.
  EXPECT_NEAR(positions["min"][2].get<double>(), -200 * std::sin(49 / 200.0), 1e-3);
  EXPECT_NEAR(positions["max"][0].get<double>(), 200 * (1 - std::cos(49 / 200.0)), 1e-3);
  EXPECT_NEAR(positions["max"][1].get<double>(), 0, 1e-3);
  // A camera that looks ahead needs no rotation: glTF's look along -z.
  EXPECT_NEAR(gltf["accessors"][2]["max"][3].get<double>(), 1, 1e-6);
  EXPECT_NEAR(gltf["accessors"][2]["max"][0].get<double>(), 0, 1e-6);
  EXPECT_THROW(BlenderScene({}, "out", 1.2, 1.5), InputError);
  results.poses_of_vehicle = true;
  EXPECT_THROW(BlenderScene(results, "out", 1.2, 1.5), InputError) << "the camera is not where they are";
}

}  // namespace
}  // namespace turnscale
