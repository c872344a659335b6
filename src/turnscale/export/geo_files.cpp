// SPDX-License-Identifier: MIT
#include "turnscale/export/geo_files.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/escaped_text.h"
#include "turnscale/export/utc_time.h"

namespace turnscale {
namespace {

using Json = nlohmann::ordered_json;

// A centimetre.
constexpr double kDegreeSteps = 1e7;
double Degrees(double value) { return std::round(value * kDegreeSteps) / kDegreeSteps; }

// Names of files may be no UTF-8.
std::string XmlName(const GeoTrack& track) { return EscapedXml(Printable(track.name)); }

std::string KmlCoordinates(const GeoTrack& track, const GeoPlace& place, char separator) {
  std::string text = fmt::format("{:.7f}{}{:.7f}", place.point.longitude, separator, place.point.latitude);
  // gx:coord needs a height.
  if (track.has_height || separator == ' ')
    text += fmt::format("{}{:.2f}", separator, track.has_height ? place.point.height : 0.0);
  return text;
}

std::string KmlValues(const GeoTrack& track, const char* name,
                      const std::function<double(const SpeedReading&)>& value) {
  std::string text = fmt::format("<gx:SimpleArrayData name=\"{}\">\n", name);
  for (const GeoPlace& place : track.places)
    text += place.speed ? fmt::format("<gx:value>{:.3f}</gx:value>\n", value(*place.speed)) : "<gx:value/>\n";
  return text + "</gx:SimpleArrayData>\n";
}

std::string KmlTrack(const GeoTrack& track) {
  std::string text = "<Placemark>\n<name>Path</name>\n<styleUrl>#path</styleUrl>\n<gx:Track>\n";
  text += track.has_height ? "<altitudeMode>absolute</altitudeMode>\n" : "";
  for (const GeoPlace& place : track.places)
    text += "<when>" + UtcTimeText(*track.start_time + place.time) + "</when>\n";
  for (const GeoPlace& place : track.places) text += "<gx:coord>" + KmlCoordinates(track, place, ' ') + "</gx:coord>\n";
  text += "<ExtendedData>\n<SchemaData schemaUrl=\"#readings\">\n";
  text += KmlValues(track, "speed", [](const SpeedReading& reading) { return reading.speed; });
  text += KmlValues(track, "speed_sigma", [](const SpeedReading& reading) { return reading.sigma; });
  return text + "</SchemaData>\n</ExtendedData>\n</gx:Track>\n</Placemark>\n";
}

std::string KmlLine(const GeoTrack& track) {
  std::string text = "<Placemark>\n<name>Path</name>\n<styleUrl>#path</styleUrl>\n<LineString>\n";
  text += track.has_height ? "<altitudeMode>absolute</altitudeMode>\n" : "<tessellate>1</tessellate>\n";
  text += "<coordinates>\n";
  for (const GeoPlace& place : track.places) text += KmlCoordinates(track, place, ',') + "\n";
  return text + "</coordinates>\n</LineString>\n</Placemark>\n";
}

Json Position(const GeoTrack& track, const GeoPoint& point) {
  Json position = {Degrees(point.longitude), Degrees(point.latitude)};
  if (track.has_height) position.push_back(std::round(point.height * 100) / 100);
  return position;
}

}  // namespace

std::string GpxText(const GeoTrack& track) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<gpx version=\"1.1\" creator=\"turnscale\" xmlns=\"http://www.topografix.com/GPX/1/1\" "
      "xmlns:gpxtpx=\"http://www.garmin.com/xmlschemas/TrackPointExtension/v2\" xmlns:turnscale=\"urn:turnscale\">\n";
  if (track.start_time && !track.places.empty())
    text += "<metadata><time>" + UtcTimeText(*track.start_time + track.places.front().time) + "</time></metadata>\n";
  text += "<trk>\n<name>" + XmlName(track) + "</name>\n<trkseg>\n";
  for (const GeoPlace& place : track.places) {
    text += fmt::format("<trkpt lat=\"{:.7f}\" lon=\"{:.7f}\">", place.point.latitude, place.point.longitude);
    if (track.has_height) text += fmt::format("<ele>{:.2f}</ele>", place.point.height);
    if (track.start_time) text += "<time>" + UtcTimeText(*track.start_time + place.time) + "</time>";
    text += "<extensions>";
    // The schema of the extension knows no negative speed: a car that reverses has one in ours.
    if (place.speed) {
      text += fmt::format(
          "<gpxtpx:TrackPointExtension><gpxtpx:speed>{:.3f}</gpxtpx:speed></gpxtpx:TrackPointExtension>"
          "<turnscale:speed>{:.3f}</turnscale:speed><turnscale:speed_sigma>{:.3f}</turnscale:speed_sigma>",
          std::abs(place.speed->speed), place.speed->speed, place.speed->sigma);
    }
    text += fmt::format("<turnscale:scale_sigma>{:.5f}</turnscale:scale_sigma></extensions></trkpt>\n", place.sigma);
  }
  return text + "</trkseg>\n</trk>\n</gpx>\n";
}

std::string KmlText(const GeoTrack& track) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<kml xmlns=\"http://www.opengis.net/kml/2.2\" "
      "xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n<Document>\n<name>" +
      XmlName(track) +
      "</name>\n<Style id=\"path\"><LineStyle><color>ffce630b</color><width>4</width></LineStyle></Style>\n"
      "<Schema id=\"readings\">\n"
      "<gx:SimpleArrayField name=\"speed\" type=\"float\"><displayName>Speed "
      "(m/s)</displayName></gx:SimpleArrayField>\n"
      "<gx:SimpleArrayField name=\"speed_sigma\" type=\"float\"><displayName>Sigma of the speed "
      "(m/s)</displayName></gx:SimpleArrayField>\n</Schema>\n";
  text += track.start_time ? KmlTrack(track) : KmlLine(track);
  for (size_t i = 0; i < track.turns.size(); ++i) {
    text += fmt::format(
        "<Placemark>\n<name>Turn {}</name>\n<Point>\n<coordinates>{}</coordinates>\n</Point>\n</Placemark>\n", i + 1,
        KmlCoordinates(track, track.turns[i], ','));
  }
  return text + "</Document>\n</kml>\n";
}

std::string GeoJsonText(const GeoTrack& track) {
  Json positions = Json::array();
  Json times = Json::array();
  Json seconds = Json::array();
  Json speeds = Json::array();
  Json speed_sigmas = Json::array();
  Json sigmas = Json::array();
  const auto rounded = [](double value) { return std::round(value * 1e4) / 1e4; };
  for (const GeoPlace& place : track.places) {
    positions.push_back(Position(track, place.point));
    seconds.push_back(rounded(place.time));
    if (track.start_time) times.push_back(UtcTimeText(*track.start_time + place.time));
    speeds.push_back(place.speed ? Json(rounded(place.speed->speed)) : Json(nullptr));
    speed_sigmas.push_back(place.speed ? Json(rounded(place.speed->sigma)) : Json(nullptr));
    sigmas.push_back(std::isfinite(place.sigma) ? Json(rounded(place.sigma)) : Json(nullptr));
  }
  Json readings = {
      {"seconds", seconds}, {"speed_mps", speeds}, {"speed_sigma_mps", speed_sigmas}, {"scale_sigma", sigmas}};
  if (track.start_time) readings["times"] = times;
  Json features = Json::array();
  features.push_back({{"type", "Feature"},
                      {"geometry", {{"type", "LineString"}, {"coordinates", positions}}},
                      {"properties", {{"name", track.name}, {"coordinateProperties", readings}}}});
  for (size_t i = 0; i < track.turns.size(); ++i) {
    features.push_back(
        {{"type", "Feature"},
         {"geometry", {{"type", "Point"}, {"coordinates", Position(track, track.turns[i].point)}}},
         {"properties", {{"name", fmt::format("Turn {}", i + 1)}, {"seconds", rounded(track.turns[i].time)}}}});
  }
  const Json json = {{"type", "FeatureCollection"}, {"features", features}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace turnscale
