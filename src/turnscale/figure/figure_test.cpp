// SPDX-License-Identifier: MIT
#include "turnscale/figure/figure.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/figure/plot_axes.h"

namespace turnscale {
namespace {

PlotPanel Panel() {
  PlotPanel panel;
  panel.title = "a < b & c";
  panel.lines.push_back({{{0, 0}, {10, 5}}, "line"});
  return panel;
}

TEST(Figure, TicksAreRoundAndWithinTheRange) {
  EXPECT_EQ(Ticks({0, 10}, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(Ticks({-0.12, 0.12}, 5), (std::vector<double>{-0.1, -0.05, 0, 0.05, 0.1}));
  EXPECT_TRUE(Ticks({1, 1}, 5).empty());
}

TEST(Figure, AxesPutTheLowestValueIntoTheLowerLeftCorner) {
  PlotPanel panel = Panel();
  panel.x = PlotRange{0, 10};
  panel.y = PlotRange{0, 5};
  const PlotAxes axes(panel, {100, 50}, {200, 80});
  EXPECT_EQ(axes.At({0, 0}), Eigen::Vector2d(100, 130));
  EXPECT_EQ(axes.At({10, 5}), Eigen::Vector2d(300, 50));
  EXPECT_FALSE(axes.Holds({11, 1}));
}

TEST(Figure, EqualAxesHaveOneUnit) {
  PlotPanel panel = Panel();
  panel.equal_axes = true;
  const PlotAxes axes(panel, {0, 0}, {300, 300});
  const Eigen::Vector2d unit = axes.At({1, 1}) - axes.At({0, 0});
  EXPECT_NEAR(unit.x(), -unit.y(), 1e-9);
}

TEST(Figure, EscapesWhatXmlReserves) {
  Figure figure;
  figure.panels.push_back(Panel());
  const std::string svg = FigureSvg(figure);
  EXPECT_NE(svg.find("a &lt; b &amp; c"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(Figure, LegendShowsEachLabelOnce) {
  Figure figure;
  figure.panels.push_back(Panel());
  figure.panels[0].lines.push_back({{{0, 1}, {10, 1}}, "line"});
  const std::string svg = FigureSvg(figure);
  const auto first = svg.find(">line<");
  ASSERT_NE(first, std::string::npos);
  EXPECT_EQ(svg.find(">line<", first + 1), std::string::npos);
}

TEST(Figure, CurvesBreakWhereAValueIsNotFinite) {
  Figure figure;
  figure.panels.push_back(Panel());
  figure.panels[0].lines = {{{{0, 0}, {1, NAN}, {2, 2}, {3, 3}}, ""}};
  const std::string svg = FigureSvg(figure);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  const size_t begin = svg.find("d=\"", svg.find("<path stroke=\"#222\"")) + 3;
  const std::string path = svg.substr(begin, svg.find('"', begin) - begin);
  EXPECT_EQ(std::count(path.begin(), path.end(), 'M'), 2) << path;
  EXPECT_EQ(std::count(path.begin(), path.end(), ','), 3) << path;
}

TEST(Figure, AMapHasABarForAxes) {
  Figure figure;
  PlotPanel panel = Panel();
  panel.x = panel.y = PlotRange{0, 100};
  panel.bar_unit = "m";
  figure.panels = {panel};
  figure.panel_width = figure.panel_height = 300;
  const std::string svg = FigureSvg(figure);
  EXPECT_EQ(svg.find("class=\"frame\""), std::string::npos);
  EXPECT_NE(svg.find(">20 m<"), std::string::npos) << svg;
  EXPECT_NE(svg.find("v5h60.0v-5"), std::string::npos) << "a fifth of the width";
}

TEST(Figure, PanelsMayHaveTheirOwnHeights) {
  Figure figure;
  figure.panels = {Panel(), Panel()};
  const auto height = [&] {
    const std::string svg = FigureSvg(figure);
    return std::stod(svg.substr(svg.find("height=\"") + 8));
  };
  const double before = height();
  figure.panels[1].height = figure.panel_height + 70;
  EXPECT_EQ(height(), before + 70);
}

TEST(Figure, RefusesWhatHasNothingToDraw) {
  EXPECT_THROW(FigureSvg(Figure{}), InternalError);
  Figure empty;
  empty.panels.emplace_back();
  EXPECT_THROW(FigureSvg(empty), InternalError);
}

}  // namespace
}  // namespace turnscale
