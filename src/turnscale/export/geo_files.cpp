// SPDX-License-Identifier: MIT
#include "turnscale/export/geo_files.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

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

std::string KmlCoordinates(const GeoTrack& track, const GeoPlace& place, char separator) {
  std::string text = fmt::format("{:.7f}{}{:.7f}", place.point.longitude, separator, place.point.latitude);
  // gx:coord needs a height.
  if (track.has_height || separator == ' ')
    text += fmt::format("{}{:.2f}", separator, track.has_height ? place.point.height : 0.0);
  return text;
}

// Not a number where the value is not known.
std::string KmlValues(const GeoTrack& track, const char* name, int digits,
                      const std::function<double(const GeoPlace&)>& value) {
  std::string text = fmt::format("<gx:SimpleArrayData name=\"{}\">\n", name);
  for (const GeoPlace& place : track.places)
    text += std::isfinite(value(place)) ? fmt::format("<gx:value>{:.{}f}</gx:value>\n", value(place), digits)
                                        : "<gx:value/>\n";
  return text + "</gx:SimpleArrayData>\n";
}

// A value per place of the path.
std::string KmlReadings(const GeoTrack& track) {
  std::string text = "<ExtendedData>\n<SchemaData schemaUrl=\"#readings\">\n";
  text += KmlValues(track, "seconds", 3, [](const GeoPlace& place) { return place.time; });
  text += KmlValues(track, "speed", 3, [](const GeoPlace& place) { return place.speed ? place.speed->speed : NAN; });
  text +=
      KmlValues(track, "speed_sigma", 3, [](const GeoPlace& place) { return place.speed ? place.speed->sigma : NAN; });
  text += KmlValues(track, "scale_sigma", 5, [](const GeoPlace& place) { return place.sigma; });
  return text + "</SchemaData>\n</ExtendedData>\n";
}

std::string KmlField(const char* name, const char* description) {
  return fmt::format(
      "<gx:SimpleArrayField name=\"{}\" type=\"float\"><displayName>{}</displayName></gx:SimpleArrayField>\n", name,
      description);
}

std::string KmlTrack(const GeoTrack& track) {
  std::string text = "<Placemark>\n<name>Path</name>\n<styleUrl>#path</styleUrl>\n<gx:Track>\n";
  for (const GeoPlace& place : track.places)
    text += "<when>" + UtcTimeText(*track.start_time + place.time) + "</when>\n";
  for (const GeoPlace& place : track.places) text += "<gx:coord>" + KmlCoordinates(track, place, ' ') + "</gx:coord>\n";
  return text + KmlReadings(track) + "</gx:Track>\n</Placemark>\n";
}

std::string KmlLine(const GeoTrack& track) {
  std::string text = "<Placemark>\n<name>Path</name>\n<styleUrl>#path</styleUrl>\n";
  text += KmlReadings(track) + "<LineString>\n";
  text += "<tessellate>1</tessellate>\n";
  text += "<coordinates>\n";
  for (const GeoPlace& place : track.places) text += KmlCoordinates(track, place, ',') + "\n";
  return text + "</coordinates>\n</LineString>\n</Placemark>\n";
}

Json Position(const GeoPoint& point) { return {Degrees(point.longitude), Degrees(point.latitude)}; }

// Where a step from `a` to `b` crosses the 180th meridian, on the side of `a`.
GeoPlace Crossing(const GeoPlace& a, const GeoPlace& b) {
  const double side = a.point.longitude < 0 ? -180 : 180;
  const double to_b = b.point.longitude + 2 * side - a.point.longitude;
  const double share = to_b == 0 ? 0 : (side - a.point.longitude) / to_b;
  GeoPlace at = a;
  at.time = std::lerp(a.time, b.time, share);
  at.point = {std::lerp(a.point.latitude, b.point.latitude, share), side,
              std::lerp(a.point.height, b.point.height, share)};
  at.speed.reset();
  return at;
}

// Parts that do not cross the 180th meridian.
std::vector<std::vector<GeoPlace>> CutAtMeridian(const std::vector<GeoPlace>& places) {
  std::vector<std::vector<GeoPlace>> parts(1);
  for (const GeoPlace& place : places) {
    std::vector<GeoPlace>& part = parts.back();
    const bool crosses = !part.empty() && std::abs(place.point.longitude - part.back().point.longitude) > 180;
    if (crosses) {
      const GeoPlace end = Crossing(part.back(), place);
      GeoPlace begin = end;
      begin.point.longitude = -end.point.longitude;
      part.push_back(end);
      parts.push_back({begin});
    }
    parts.back().push_back(place);
  }
  return parts;
}

Json Rounded(double value) {
  constexpr double kSteps = 1e4;
  return std::isfinite(value) ? Json(std::round(value * kSteps) / kSteps) : Json(nullptr);
}

// One value per position.
Json Column(const std::vector<GeoPlace>& places, const std::function<Json(const GeoPlace&)>& value) {
  Json column = Json::array();
  for (const GeoPlace& place : places) column.push_back(value(place));
  return column;
}

}  // namespace

std::string GpxText(const GeoTrack& track) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<gpx version=\"1.1\" creator=\"turnscale\" xmlns=\"http://www.topografix.com/GPX/1/1\" "
      "xmlns:gpxtpx=\"http://www.garmin.com/xmlschemas/TrackPointExtension/v2\" xmlns:turnscale=\"urn:turnscale\">\n";
  if (track.start_time && !track.places.empty())
    text += "<metadata><time>" + UtcTimeText(*track.start_time + track.places.front().time) + "</time></metadata>\n";
  text += "<trk>\n<name>" + EscapedXml(track.name) + "</name>\n<trkseg>\n";
  for (const GeoPlace& place : track.places) {
    text += fmt::format("<trkpt lat=\"{:.7f}\" lon=\"{:.7f}\">", place.point.latitude, place.point.longitude);
    if (track.has_height) text += fmt::format("<ele>{:.2f}</ele>", place.point.height);
    if (track.start_time) text += "<time>" + UtcTimeText(*track.start_time + place.time) + "</time>";
    text += "<extensions>";
    // The schema of the extension does not allow a negative speed: that of a car in reverse is in ours.
    if (place.speed) {
      text += fmt::format(
          "<gpxtpx:TrackPointExtension><gpxtpx:speed>{:.3f}</gpxtpx:speed></gpxtpx:TrackPointExtension>"
          "<turnscale:speed>{:.3f}</turnscale:speed>",
          std::abs(place.speed->speed), place.speed->speed);
      if (std::isfinite(place.speed->sigma))
        text += fmt::format("<turnscale:speed_sigma>{:.3f}</turnscale:speed_sigma>", place.speed->sigma);
    }
    if (std::isfinite(place.sigma))
      text += fmt::format("<turnscale:scale_sigma>{:.5f}</turnscale:scale_sigma>", place.sigma);
    text += "</extensions></trkpt>\n";
  }
  return text + "</trkseg>\n</trk>\n</gpx>\n";
}

std::string KmlText(const GeoTrack& track) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<kml xmlns=\"http://www.opengis.net/kml/2.2\" "
      "xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n<Document>\n<name>" +
      EscapedXml(track.name) +
      "</name>\n<Style id=\"path\"><LineStyle><color>ffce630b</color><width>4</width></LineStyle></Style>\n"
      "<Schema id=\"readings\">\n";
  text += KmlField("seconds", "Time of the drive (s)") + KmlField("speed", "Speed (m/s)") +
          KmlField("speed_sigma", "Sigma of the speed (m/s)") + KmlField("scale_sigma", "Relative sigma of the scale") +
          "</Schema>\n";
  text += track.start_time ? KmlTrack(track) : KmlLine(track);
  for (size_t i = 0; i < track.turns.size(); ++i) {
    text += fmt::format(
        "<Placemark>\n<name>Turn {}</name>\n<Point>\n<coordinates>{}</coordinates>\n</Point>\n</Placemark>\n", i + 1,
        KmlCoordinates(track, track.turns[i], ','));
  }
  return text + "</Document>\n</kml>\n";
}

std::string GeoJsonText(const GeoTrack& track) {
  const std::vector<std::vector<GeoPlace>> parts = CutAtMeridian(track.places);
  // A list per part if there are several.
  const auto of_parts = [&](const std::function<Json(const GeoPlace&)>& value) {
    if (parts.size() == 1) return Column(parts.front(), value);
    Json all = Json::array();
    for (const std::vector<GeoPlace>& part : parts) all.push_back(Column(part, value));
    return all;
  };
  const auto of_speed = [&](double SpeedReading::*value) {
    return of_parts([value](const GeoPlace& place) { return place.speed ? Rounded(*place.speed.*value) : Json(); });
  };
  Json readings = {{"seconds", of_parts([](const GeoPlace& place) { return Rounded(place.time); })},
                   {"speed_mps", of_speed(&SpeedReading::speed)},
                   {"speed_sigma_mps", of_speed(&SpeedReading::sigma)},
                   {"scale_sigma", of_parts([](const GeoPlace& place) { return Rounded(place.sigma); })}};
  if (track.start_time)
    readings["times"] =
        of_parts([&](const GeoPlace& place) { return Json(UtcTimeText(*track.start_time + place.time)); });
  if (track.has_height)
    readings["height_m"] = of_parts([](const GeoPlace& place) { return Rounded(place.point.height); });
  Json features = Json::array();
  features.push_back({{"type", "Feature"},
                      {"geometry",
                       {{"type", parts.size() == 1 ? "LineString" : "MultiLineString"},
                        {"coordinates", of_parts([](const GeoPlace& place) { return Position(place.point); })}}},
                      {"properties", {{"name", track.name}, {"coordinateProperties", readings}}}});
  for (size_t i = 0; i < track.turns.size(); ++i) {
    features.push_back(
        {{"type", "Feature"},
         {"geometry", {{"type", "Point"}, {"coordinates", Position(track.turns[i].point)}}},
         {"properties", {{"name", fmt::format("Turn {}", i + 1)}, {"seconds", Rounded(track.turns[i].time)}}}});
  }
  const Json json = {{"type", "FeatureCollection"}, {"features", features}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace turnscale
