// SPDX-License-Identifier: MIT
#include "turnscale/export/geo_files.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/export/test_results.h"
#include "turnscale/export/utc_time.h"

namespace turnscale {
namespace {

GeoTrack Track() {
  GeoTrack track;
  track.name = "a & b";
  track.places = PlaceOnEarth(LevelPath(TestResults(101), "out"), {{49, 8, 0}, 0}, 1);
  track.turns = {track.places[5]};
  track.start_time = ParseUtcTime("2026-03-22T07:14:05+01:00");
  return track;
}

int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(GeoFiles, Gpx) {
  const std::string gpx = GpxText(Track());
  EXPECT_NE(gpx.find("<gpx version=\"1.1\""), std::string::npos);
  EXPECT_NE(gpx.find("<name>a &amp; b</name>"), std::string::npos);
  EXPECT_EQ(Count(gpx, "<trkpt "), 11);
  EXPECT_NE(gpx.find("<trkpt lat=\"49.0000000\" lon=\"8.0000000\"><time>2026-03-22T06:14:05.000Z</time>"),
            std::string::npos);
  EXPECT_EQ(Count(gpx, "<gpxtpx:speed>10.000</gpxtpx:speed>"), 10) << "none at the first frame";
  EXPECT_EQ(Count(gpx, "<ele>"), 0);
}

TEST(GeoFiles, Kml) {
  GeoTrack track = Track();
  const std::string kml = KmlText(track);
  EXPECT_EQ(Count(kml, "<when>"), 11);
  EXPECT_EQ(Count(kml, "<gx:coord>"), 11);
  EXPECT_EQ(Count(kml, "<LineString>"), 0) << "readers would find the path twice";
  EXPECT_EQ(Count(kml, "<gx:value>10.000</gx:value>"), 11) << "the speeds, and the last time";
  EXPECT_NE(kml.find("<gx:coord>8.0000000 49.0000000 0.00</gx:coord>"), std::string::npos);
  track.start_time.reset();
  EXPECT_EQ(Count(KmlText(track), "gx:Track"), 0);
  EXPECT_EQ(Count(KmlText(track), "<LineString>"), 1);
  EXPECT_EQ(Count(KmlText(track), "<gx:value>10.000</gx:value>"), 11) << "the speeds, and the last time";
  EXPECT_EQ(Count(KmlText(track), "<gx:value>0.02000</gx:value>"), 11) << "the sigma of the scale";
}

TEST(GeoFiles, GeoJsonIsLongitudeFirst) {
  GeoTrack track = Track();
  const auto json = nlohmann::json::parse(GeoJsonText(track));
  EXPECT_EQ(json["type"], "FeatureCollection");
  EXPECT_FALSE(json.contains("crs")) << "RFC 7946 knows WGS 84 only";
  const auto& line = json["features"][0];
  EXPECT_EQ(line["geometry"]["type"], "LineString");
  ASSERT_EQ(line["geometry"]["coordinates"].size(), 11u);
  EXPECT_EQ(line["geometry"]["coordinates"][0], nlohmann::json::parse("[8.0, 49.0]"));
  const auto& readings = line["properties"]["coordinateProperties"];
  for (const char* name : {"times", "seconds", "speed_mps", "speed_sigma_mps", "scale_sigma"})
    EXPECT_EQ(readings[name].size(), 11u) << name;
  EXPECT_EQ(readings["times"][1], "2026-03-22T06:14:06.000Z");
  EXPECT_TRUE(readings["speed_mps"][0].is_null());
  EXPECT_EQ(json["features"][1]["geometry"]["type"], "Point");
  track.has_height = true;
  const auto high = nlohmann::json::parse(GeoJsonText(track))["features"][0];
  EXPECT_EQ(high["geometry"]["coordinates"][0].size(), 2u) << "a third number would be above the ellipsoid";
  EXPECT_EQ(high["properties"]["coordinateProperties"]["height_m"][0], 0);
}

// RFC 7946, 3.1.9: a line is cut at the 180th meridian.
TEST(GeoFiles, GeoJsonIsCutAtTheMeridian) {
  GeoTrack track;
  for (const auto& [time, longitude] : {std::pair(0.0, 179.9998), {1.0, 179.9999}, {2.0, -179.9998}, {3.0, -179.9997}})
    track.places.push_back({time, {10 + 0.003 * time, longitude, 0}, SpeedReading{time, 10, 0.2}, 0.02});
  const auto line = nlohmann::json::parse(GeoJsonText(track))["features"][0];
  EXPECT_EQ(line["geometry"]["type"], "MultiLineString");
  const auto& parts = line["geometry"]["coordinates"];
  ASSERT_EQ(parts.size(), 2u);
  ASSERT_EQ(parts[0].size(), 3u);
  ASSERT_EQ(parts[1].size(), 3u);
  EXPECT_EQ(parts[0][2], nlohmann::json::parse("[180.0, 10.004]")) << "after a third of the step";
  EXPECT_EQ(parts[1][0], nlohmann::json::parse("[-180.0, 10.004]"));
  const auto& readings = line["properties"]["coordinateProperties"];
  EXPECT_NEAR(readings["seconds"][0][2].get<double>(), 4 / 3.0, 1e-4);
  EXPECT_TRUE(readings["speed_mps"][1][0].is_null());
  EXPECT_EQ(readings["speed_mps"][1].size(), 3u);
  // And the other way round.
  std::reverse(track.places.begin(), track.places.end());
  const auto back = nlohmann::json::parse(GeoJsonText(track))["features"][0]["geometry"]["coordinates"];
  EXPECT_EQ(back[0][2][0], -180);
  EXPECT_EQ(back[1][0][0], 180);
}

TEST(GeoFiles, WhatIsNotKnownIsLeftOut) {
  GeoTrack track = Track();
  for (GeoPlace& place : track.places) {
    place.sigma = NAN;
    if (place.speed) place.speed->sigma = NAN;
  }
  for (const std::string& text : {GpxText(track), KmlText(track), GeoJsonText(track)})
    EXPECT_EQ(text.find("nan"), std::string::npos) << text;
}

}  // namespace
}  // namespace turnscale
