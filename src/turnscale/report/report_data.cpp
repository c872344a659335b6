// SPDX-License-Identifier: MIT
#include "turnscale/report/report_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "turnscale/base/base64.h"
#include "turnscale/base/error.h"
#include "turnscale/geometry/level_frame.h"
#include "turnscale/geometry/path_length.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/geometry/similarity.h"
#include "turnscale/report/path_thinning.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Few digits: a number of the page is read by people.
Json Rounded(double value, double steps_per_unit) {
  if (!std::isfinite(value)) return nullptr;
  const double rounded = std::round(value * steps_per_unit) / steps_per_unit;
  if (rounded == std::floor(rounded) && std::abs(rounded) < 1e9) return static_cast<int64_t>(rounded);
  return rounded;
}

Json Significant(double value) {
  if (!std::isfinite(value) || value == 0) return value == 0 ? Json(0) : Json(nullptr);
  constexpr int kDigits = 5;
  return Rounded(value, std::pow(10, kDigits - 1 - std::floor(std::log10(std::abs(value)))));
}

constexpr double kMillimetres = 1000;
constexpr double kCentimetres = 100;
constexpr double kMilliseconds = 1000;
constexpr double kSigmaSteps = 1e5;

// In the page's seconds.
Json Time(double time, double origin) { return Rounded(time - origin, kMilliseconds); }

// How finely a length is given: centimetres of a drive in metres, a ten-thousandth of one without.
double LengthSteps(const Trajectory& poses, bool metric) {
  const double length = LengthsAlong(poses).back();
  constexpr double kShare = 2e5;
  return metric ? kCentimetres : std::max(1.0, std::round(kShare / std::max(length, 1e-9)));
}

struct Axes {
  double time_origin = 0;
  Eigen::Quaterniond level_from_world = Eigen::Quaterniond::Identity();
  double steps = kCentimetres;
};

class Column {
 public:
  void Add(Json value) { values_.push_back(std::move(value)); }
  Json Take() { return std::move(values_); }

 private:
  Json values_ = Json::array();
};

// x, y and z of points in level axes.
class PositionColumns {
 public:
  explicit PositionColumns(double steps) : steps_(steps) {}
  void Add(const Eigen::Vector3d& in_level) {
    for (int axis = 0; axis < 3; ++axis) columns_[axis].Add(Rounded(in_level[axis], steps_));
  }
  void MoveTo(Json& json) {
    json["x"] = columns_[0].Take();
    json["y"] = columns_[1].Take();
    json["z"] = columns_[2].Take();
  }

 private:
  double steps_;
  std::array<Column, 3> columns_;
};

char LetterOf(ScaleState state) {
  switch (state) {
    case ScaleState::kPending:
      return 'p';
    case ScaleState::kObserved:
      return 'o';
    case ScaleState::kFromRoad:
      return 'r';
    case ScaleState::kHeld:
      break;
  }
  return 'h';
}

char LetterOf(TrackingState state) {
  switch (state) {
    case TrackingState::kTracked:
      return 't';
    case TrackingState::kRepeated:
      return 'r';
    case TrackingState::kBridged:
      return 'b';
    case TrackingState::kUnreadable:
      return 'u';
    case TrackingState::kInitializing:
      return 'i';
  }
  return 'i';
}

// Frames with a pose, and where lost tracking and turns begin and end among them: points of the path that have to stay.
struct PosedFrames {
  std::vector<const FrameResult*> frames;
  Trajectory poses;
  std::vector<int> edges;
};

PosedFrames Posed(const ReportData& data, const ReportLimits& limits) {
  PosedFrames posed;
  std::vector<int> changes;
  for (const FrameResult& frame : data.frames) {
    if (!frame.world_from_camera) continue;
    const int place = static_cast<int>(posed.frames.size());
    if (place > 0 && IsLost(posed.frames.back()->state) != IsLost(frame.state)) changes.push_back(place);
    posed.frames.push_back(&frame);
    posed.poses.push_back({frame.time, *frame.world_from_camera});
  }
  // Where there are too many, some of all parts of the drive.
  const size_t stride = 4 * changes.size() / std::max(limits.path_points, 1) + 1;
  for (size_t i = 0; i < changes.size(); i += stride)
    posed.edges.insert(posed.edges.end(), {changes[i] - 1, changes[i]});
  const auto place_of = [&](int frame) {
    const auto after = std::lower_bound(posed.frames.begin(), posed.frames.end(), frame,
                                        [](const FrameResult* f, int number) { return f->frame < number; });
    return static_cast<int>(std::min<std::ptrdiff_t>(after - posed.frames.begin(), posed.frames.size() - 1));
  };
  if (posed.frames.empty()) return posed;
  for (const TurnResult& turn : data.turns)
    posed.edges.insert(posed.edges.end(), {place_of(turn.first_frame), place_of(turn.last_frame)});
  return posed;
}

// Where the car's nose points, clockwise from the y axis: not the direction of travel, which reverses.
double HeadingOf(const RigidTransform& world_from_body, const ReportData& data, const Axes& axes) {
  const Eigen::Vector3d forward = data.vehicle_from_body.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d in_level = axes.level_from_world * (world_from_body.rotation * forward);
  return std::atan2(in_level.x(), in_level.y());
}

Json PathJson(const ReportData& data, const PosedFrames& posed, const Axes& axes, const ReportLimits& limits) {
  Json path;
  Column time;
  Column frame;
  Column speed;
  Column speed_sigma;
  Column sigma;
  Column heading;
  Column driven;
  PositionColumns positions(axes.steps);
  // The points of the page are too few to add up to it.
  const std::vector<double> driven_to = LengthsAlong(posed.poses);
  std::string scale_state;
  std::string tracking;
  for (const int place : ThinPath(posed.poses, limits.path_points, posed.edges)) {
    const FrameResult& of = *posed.frames[place];
    time.Add(Time(of.time, axes.time_origin));
    frame.Add(of.frame);
    positions.Add(axes.level_from_world * of.world_from_camera->translation);
    heading.Add(Rounded(HeadingOf(*of.world_from_camera, data, axes) * kDegreesPerRadian, 1));
    driven.Add(Rounded(driven_to[place], axes.steps / 10));
    const std::optional<SpeedReading> reading = SpeedAt(data.speeds, of.time);
    speed.Add(reading ? Rounded(reading->speed, kMillimetres) : Json(nullptr));
    speed_sigma.Add(reading ? Rounded(reading->sigma, kMillimetres) : Json(nullptr));
    sigma.Add(Rounded(of.scale_sigma, kSigmaSteps));
    if (data.has_scale_state) scale_state += LetterOf(of.scale_state);
    if (data.has_tracking) tracking += LetterOf(of.state);
  }
  path["time"] = time.Take();
  path["frame"] = frame.Take();
  positions.MoveTo(path);
  path["heading"] = heading.Take();
  path["driven"] = driven.Take();
  path["speed"] = speed.Take();
  path["speedSigma"] = speed_sigma.Take();
  path["sigma"] = sigma.Take();
  path["scaleState"] = scale_state;
  path["tracking"] = tracking;
  return path;
}

// Landmarks near the path; the map has some that are far away, with hardly a depth.
Json LandmarksJson(const ReportData& data, const PosedFrames& posed, const Axes& axes, const ReportLimits& limits) {
  if (data.landmarks.empty() || posed.poses.empty()) return nullptr;
  Eigen::AlignedBox3d box;
  for (const StampedPose& pose : posed.poses) box.extend(axes.level_from_world * pose.world_from_camera.translation);
  constexpr double kRoom = 0.2;
  const double side = box.sizes().head<2>().maxCoeff();
  const double least = data.metric ? 12 : 0;
  const double room = std::max({kRoom * side, least, 1e-6});
  box.min() -= Eigen::Vector3d(room, room, std::min(room, 0.5 * side));
  box.max() += Eigen::Vector3d(room, room, std::min(room, 0.5 * side));
  std::vector<Eigen::Vector3d> near;
  for (const Eigen::Vector3f& landmark : data.landmarks) {
    const Eigen::Vector3d position = axes.level_from_world * landmark.cast<double>();
    if (box.contains(position)) near.push_back(position);
  }
  const size_t stride = near.size() / limits.landmarks + 1;
  const double step = box.sizes().maxCoeff() / std::numeric_limits<uint16_t>::max();
  std::string bytes;
  for (size_t i = 0; i < near.size(); i += stride) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto steps = static_cast<uint16_t>(std::lround((near[i][axis] - box.min()[axis]) / step));
      bytes += static_cast<char>(steps & 0xFFU);
      bytes += static_cast<char>(steps >> 8U);
    }
  }
  return {{"low", {box.min().x(), box.min().y(), box.min().z()}}, {"step", step}, {"data", Base64(bytes)}};
}

Json OrNull(double value) { return value > 0 ? Significant(value) : Json(nullptr); }

Json TurnsJson(const ReportData& data, double time_origin) {
  Json turns = Json::array();
  const auto time_of = [&](int frame) {
    return Time(data.frames[std::clamp<int>(frame, 0, static_cast<int>(data.frames.size()) - 1)].time, time_origin);
  };
  if (data.frames.empty()) return turns;
  for (const TurnResult& turn : data.turns) {
    turns.push_back({{"from", time_of(turn.first_frame)},
                     {"to", time_of(turn.last_frame)},
                     {"angle", Rounded(turn.angle * kDegreesPerRadian, 10)},
                     {"speed", OrNull(turn.speed)},
                     {"scale", OrNull(turn.own)},
                     {"sigma", OrNull(turn.own_sigma)},
                     {"smoothed", OrNull(turn.smoothed)},
                     {"deviation", turn.used ? Rounded(turn.deviation, 100) : Json(nullptr)},
                     {"leverArm", OrNull(turn.effective_lever_arm)},
                     {"used", turn.used},
                     {"reason", turn.reason}});
  }
  return turns;
}

Json ScaleJson(const ReportData& data, double time_origin, const ReportLimits& limits) {
  if (data.scale.empty()) return nullptr;
  Column time;
  Column value;
  Column sigma;
  const size_t stride = data.scale.size() / limits.scale_points + 1;
  for (size_t i = 0; i < data.scale.size(); ++i) {
    if (i % stride != 0 && i + 1 != data.scale.size()) continue;
    const ScaleRow& row = data.scale[i];
    time.Add(Time(row.time, time_origin));
    value.Add(Significant(row.metres_per_unit));
    sigma.Add(Rounded(row.sigma, kSigmaSteps));
  }
  return {{"time", time.Take()}, {"value", value.Take()}, {"sigma", sigma.Take()}};
}

Json RotationJson(const ReportData& data, double time_origin) {
  if (data.rotations.empty()) return nullptr;
  Json json;
  const auto add = [&](const char* name, double value) {
    json[name].push_back(Rounded(value * kDegreesPerRadian, 1e4));
  };
  const auto add_row = [&](double time, const RotationRow& row) {
    json["time"].push_back(Time(time, time_origin));
    add("yaw", row.angles.yaw);
    add("pitch", row.angles.pitch);
    add("roll", row.angles.roll);
    const YawPitchRoll sigma = row.sigma.value_or(YawPitchRoll{NAN, NAN, NAN});
    add("yawSigma", sigma.yaw);
    add("pitchSigma", sigma.pitch);
    add("rollSigma", sigma.roll);
  };
  for (const RotationRow& row : data.rotations) add_row(row.time, row);
  // The last rotation holds to the end.
  if (!data.frames.empty() && data.frames.back().time > data.rotations.back().time)
    add_row(data.frames.back().time, data.rotations.back());
  return json;
}

Json ThumbnailsJson(const ReportData& data, double time_origin) {
  Json thumbnails = Json::array();
  for (const Thumbnail& thumbnail : data.thumbnails) {
    thumbnails.push_back({{"time", Time(thumbnail.time, time_origin)},
                          {"frame", thumbnail.frame},
                          {"why", ThumbnailReasonName(thumbnail.reason)},
                          {"jpeg", Base64(thumbnail.jpeg)}});
  }
  return thumbnails;
}

// The truth as seen from the path: its first pose is laid on that of the estimate. A path without metres has the truth
// laid on the whole of it, with a change of scale, since its scale is arbitrary.
Similarity PathFromTruth(const ReportData& data) {
  const PosePair& first = data.truth.front();
  const RigidTransform rigid = first.estimate * first.truth.inverse();
  Similarity path_from_truth{1, rigid.rotation, rigid.translation};
  if (data.metric) return path_from_truth;
  std::vector<Eigen::Vector3d> estimate;
  std::vector<Eigen::Vector3d> truth;
  for (const PosePair& pair : data.truth) {
    estimate.push_back(pair.estimate.translation);
    truth.push_back(pair.truth.translation);
  }
  try {
    return AlignPoints(truth, estimate, AlignmentModel::kSimilarity);
  } catch (const InputError&) {
    // A straight line: the first pose gives the direction, the lengths give the scale.
    const double scale = EstimatedPathLength(data.truth) / TruePathLength(data.truth);
    if (std::isfinite(scale) && scale > 0) path_from_truth.scale = scale;
    path_from_truth.translation =
        first.estimate.translation - path_from_truth.scale * (rigid.rotation * first.truth.translation);
    return path_from_truth;
  }
}

Json TruthJson(const ReportData& data, const Axes& axes, const ReportLimits& limits) {
  if (data.truth.empty()) return nullptr;
  const Similarity path_from_truth = PathFromTruth(data);
  Trajectory truth;
  for (const PosePair& pair : data.truth) {
    truth.push_back(
        {pair.time, {path_from_truth.rotation * pair.truth.rotation, path_from_truth * pair.truth.translation}});
  }
  Json json;
  json["metresPerUnit"] = data.metric ? Json(nullptr) : Significant(1 / path_from_truth.scale);
  Column time;
  Column error;
  PositionColumns positions(axes.steps);
  for (const int place : ThinPath(truth, limits.truth_points)) {
    const Eigen::Vector3d& position = truth[place].world_from_camera.translation;
    time.Add(Time(truth[place].time, axes.time_origin));
    positions.Add(axes.level_from_world * position);
    error.Add(
        Rounded((data.truth[place].estimate.translation - position).norm() / path_from_truth.scale, kMillimetres));
  }
  json["time"] = time.Take();
  positions.MoveTo(json);
  json["error"] = error.Take();
  return json;
}

Json OutlinesJson(const ReportData& data, const Axes& axes) {
  Json outlines = Json::array();
  if (data.truth.empty()) return outlines;
  const Similarity path_from_truth = PathFromTruth(data);
  for (const std::vector<Eigen::Vector2d>& outline : data.outlines) {
    Json points = Json::array();
    const auto add = [&](const Eigen::Vector2d& corner) {
      const Eigen::Vector3d in_level =
          axes.level_from_world * (path_from_truth * Eigen::Vector3d(corner.x(), 0, corner.y()));
      for (int axis = 0; axis < 3; ++axis) points.push_back(Rounded(in_level[axis], axes.steps));
    };
    for (const Eigen::Vector2d& corner : outline) add(corner);
    if (!outline.empty()) add(outline.front());
    outlines.push_back(std::move(points));
  }
  return outlines;
}

// A page that counts the time from elsewhere, as those of earlier versions may, is of no use.
void TakeOverTruth(const std::string& earlier, Json& json) {
  const Json from = Json::parse(earlier, nullptr, false);
  if (!from.is_object() || from.value("timeOrigin", Json(0)) != json["timeOrigin"]) return;
  for (const char* part : {"truth", "errors", "outlines"})
    if (from.contains(part)) json[part] = from[part];
}

Json FactsJson(const std::vector<ReportFact>& facts) {
  Json json = Json::array();
  for (const ReportFact& fact : facts)
    json.push_back({{"name", fact.name}, {"value", fact.value}, {"note", fact.note}});
  return json;
}

}  // namespace

std::string ShortPath(const std::string& path) {
  const fs::path whole = fs::path(path).lexically_normal();
  const fs::path last = whole.has_filename() ? whole : whole.parent_path();
  if (!last.has_filename()) return path;
  const fs::path parent = last.parent_path().filename();
  return (parent == ".." ? last.filename() : parent / last.filename()).string();
}

double TimeOrigin(const std::vector<FrameResult>& frames) {
  constexpr double kDay = 86400;
  return !frames.empty() && frames.front().time > kDay ? frames.front().time : 0;
}

std::string ReportJson(const ReportData& data, const ReportLimits& limits) {
  const PosedFrames posed = Posed(data, limits);
  Axes axes;
  if (data.timed) axes.time_origin = data.time_origin.value_or(TimeOrigin(data.frames));
  if (!posed.poses.empty()) {
    axes.level_from_world = LevelFromWorld(posed.poses, data.vehicle_from_body);
    axes.steps = LengthSteps(posed.poses, data.metric);
  }
  Json json = {{"title", ShortPath(data.title)},
               {"version", data.version},
               {"unit", data.metric ? "m" : "units"},
               {"timed", data.timed},
               {"timeOrigin", Rounded(axes.time_origin, kMilliseconds)},
               {"notes", data.notes},
               {"warnings", data.warnings},
               {"facts", FactsJson(data.facts)},
               {"path", PathJson(data, posed, axes, limits)},
               {"landmarks", LandmarksJson(data, posed, axes, limits)},
               {"turns", TurnsJson(data, axes.time_origin)},
               {"scale", ScaleJson(data, axes.time_origin, limits)},
               {"rotation", RotationJson(data, axes.time_origin)},
               {"thumbnails", ThumbnailsJson(data, axes.time_origin)},
               {"truth", TruthJson(data, axes, limits)},
               {"errors", FactsJson(data.errors)},
               {"outlines", OutlinesJson(data, axes)},
               {"settings", data.settings}};
  if (data.truth.empty() && !data.earlier.empty()) TakeOverTruth(data.earlier, json);
  // Names of files may not be valid UTF-8. A '<' could end the script element that holds the data.
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      escaped += "\\u003c";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

}  // namespace turnscale
