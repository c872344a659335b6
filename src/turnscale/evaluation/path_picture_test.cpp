// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/path_picture.h"

#include <limits>
#include <sstream>
#include <utility>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

bool Holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// First and last point of the curve of this colour.
std::pair<Eigen::Vector2d, Eigen::Vector2d> Ends(const std::string& svg, const std::string& color) {
  const size_t begin = svg.find("d=\"M", svg.find("<path stroke=\"" + color + "\"")) + 4;
  std::istringstream text(svg.substr(begin, svg.find('"', begin) - begin));
  std::vector<Eigen::Vector2d> points;
  char comma = 0;
  for (Eigen::Vector2d point; text >> point.x() >> comma >> point.y();) points.push_back(point);
  return {points.front(), points.back()};
}

TEST(PathPicture, AheadIsUpAndAMetreIsAsLongOnBothAxes) {
  PathPicture picture;
  picture.outlines = {{{0, 0}, {0, 100}, {50, 100}, {50, 0}}};
  picture.truth = {{10, 0}, {10, 50}};
  picture.estimate = {{10, 0}, {20, 50}};
  const std::string svg = PathSvg(picture);
  const auto [true_start, true_end] = Ends(svg, "#222");
  const auto [start, end] = Ends(svg, "#c2185b");
  EXPECT_EQ(start, true_start);
  EXPECT_EQ(true_end.x(), true_start.x());
  const double ahead = (true_start - true_end).y();
  EXPECT_GT(ahead, 350) << "half of the longer side";
  EXPECT_NEAR((end - start).x(), ahead / 5, 0.2);
  EXPECT_NEAR((end - true_end).y(), 0, 0.2);
  for (const char* part : {">true<", ">estimated<", " m<"}) EXPECT_TRUE(Holds(svg, part)) << part;
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
