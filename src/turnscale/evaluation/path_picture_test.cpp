// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/path_picture.h"

#include <limits>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

bool Holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(PathPicture, AheadIsUpAndTheLongerSideFillsThePage) {
  PathPicture picture;
  picture.outlines = {{{0, 0}, {0, 100}, {50, 100}, {50, 0}}};
  picture.truth = {{10, 0}, {10, 50}};
  picture.estimate = {{10, 0}, {11, 50}};
  const std::string svg = PathSvg(picture);
  // 8 units a metre, below a heading of 60 and within a margin of 24.
  EXPECT_TRUE(Holds(svg, "class=\"plan\" d=\"M24.0,884.0 24.0,84.0 424.0,84.0 424.0,884.0Z\"")) << svg;
  EXPECT_TRUE(Holds(svg, "class=\"truth\" d=\"M104.0,884.0 104.0,484.0\"")) << svg;
  EXPECT_TRUE(Holds(svg, "class=\"estimate\" d=\"M104.0,884.0 112.0,484.0\"")) << svg;
  EXPECT_TRUE(Holds(svg, "viewBox=\"0 0 448 908\"")) << svg;
  EXPECT_TRUE(Holds(svg, "h160.0\"")) << "a bar of 20 m";
  EXPECT_TRUE(Holds(svg, ">20 m<")) << svg;
}

TEST(PathPicture, TitleIsText) {
  PathPicture picture;
  picture.truth = {{0, 0}};
  picture.title = "a < b & c";
  EXPECT_TRUE(Holds(PathSvg(picture), ">a &lt; b &amp; c<"));
}

TEST(PathPicture, RefusesWhatCannotBeDrawn) {
  PathPicture picture;
  EXPECT_THROW(PathSvg(picture), InputError);
  picture.truth = {{0, std::numeric_limits<double>::quiet_NaN()}};
  EXPECT_THROW(PathSvg(picture), InputError);
}

}  // namespace
}  // namespace turnscale
