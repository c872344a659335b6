// SPDX-License-Identifier: MIT
#include "turnscale/run/result_folder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "turnscale/base/csv_table.h"
#include "turnscale/base/error.h"
#include "turnscale/base/file_text.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/odometry/results.h"
#include "turnscale/run/run_summary.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

// What a file of the results holds; empty if there is no such file: not every run writes all of them. A device or pipe
// keeps nothing of what a run has written to it.
std::string TextIfThere(const fs::path& path) {
  std::error_code none;
  const fs::file_status status = fs::status(path, none);
  if (status.type() == fs::file_type::not_found || fs::is_other(status)) return {};
  if (std::optional<std::string> text = FileText(path)) return *std::move(text);
  throw InputError(path.string() + ": cannot be read");
}

// Calls `read` for every line of a table, if there is one.
void ReadTable(const fs::path& path, const std::function<void(CsvTable&)>& read) {
  std::string text = TextIfThere(path);
  if (text.empty()) return;
  std::istringstream stream(std::move(text));
  CsvTable table(stream, path.string());
  while (table.Next()) read(table);
}

template <class State>
State StateIn(const CsvTable& table, size_t column, std::optional<State> (*named)(std::string_view)) {
  if (const std::optional<State> state = named(table.Text(column))) return *state;
  throw InputError(table.Where() + ": '" + table.Text(column) + "' is not a valid state");
}

std::vector<FrameResult> ReadFrames(const fs::path& path) {
  std::vector<FrameResult> frames;
  ReadTable(path, [&](CsvTable& table) {
    const auto whole = [&](const char* column) { return table.Value<int>(table.Column(column)); };
    const auto number = [&](const char* column) { return table.Value<double>(table.Column(column)); };
    FrameResult frame;
    frame.frame = whole("frame");
    frame.time = number("time");
    frame.state = StateIn(table, table.Column("state"), TrackingStateNamed);
    if (!table.Text(table.Column("x")).empty()) {
      const Eigen::Quaterniond rotation(number("qw"), number("qx"), number("qy"), number("qz"));
      frame.world_from_camera = RigidTransform{RotationFromFile(rotation, table.Where(), "qx,qy,qz,qw"),
                                               {number("x"), number("y"), number("z")}};
    }
    frame.scale_state = StateIn(table, table.Column("scale_state"), ScaleStateNamed);
    frame.scale_sigma = number("scale_sigma");
    frame.inliers = whole("inliers");
    frame.tracked = whole("tracked");
    frame.keyframe = whole("keyframe") != 0;
    frame.turning = whole("turning") != 0;
    frames.push_back(frame);
  });
  return frames;
}

std::vector<TurnResult> ReadTurns(const fs::path& path) {
  std::vector<TurnResult> turns;
  ReadTable(path, [&](CsvTable& table) {
    const auto number = [&](const char* column) { return table.ValueOrNone<double>(table.Column(column)).value_or(0); };
    TurnResult turn;
    turn.first_frame = table.Value<int>(table.Column("first_frame"));
    turn.last_frame = table.Value<int>(table.Column("last_frame"));
    turn.angle = number("angle_deg") / kDegreesPerRadian;
    turn.speed = number("speed_mps");
    turn.own = number("metres_per_unit");
    turn.own_sigma = number("sigma");
    turn.smoothed = number("smoothed_metres_per_unit");
    turn.smoothed_sigma = number("smoothed_sigma");
    turn.deviation = number("deviation_sigmas");
    turn.effective_lever_arm = number("effective_lever_arm_m");
    turn.used = table.Value<int>(table.Column("used")) != 0;
    turn.reason = table.Text(table.Column("reason"));
    turns.push_back(turn);
  });
  return turns;
}

std::vector<RotationRow> ReadRotations(const fs::path& path) {
  std::vector<RotationRow> rows;
  ReadTable(path, [&](CsvTable& table) {
    const auto radians = [&](const char* column) {
      return table.Value<double>(table.Column(column)) / kDegreesPerRadian;
    };
    RotationRow row;
    row.frame = table.Value<int>(table.Column("frame"));
    row.time = table.Value<double>(table.Column("time"));
    row.angles = {radians("yaw_deg"), radians("pitch_deg"), radians("roll_deg")};
    if (!table.Text(table.Column("yaw_sigma_deg")).empty())
      row.sigma = YawPitchRoll{radians("yaw_sigma_deg"), radians("pitch_sigma_deg"), radians("roll_sigma_deg")};
    rows.push_back(row);
  });
  return rows;
}

float FloatAt(const std::string& bytes, size_t place) {
  uint32_t bits = 0;
  for (size_t i = 0; i < sizeof bits; ++i)
    bits |= static_cast<uint32_t>(static_cast<unsigned char>(bytes[place + i])) << (8 * i);
  return std::bit_cast<float>(bits);
}

// As WriteMap writes them: landmarks are gray, cameras red.
std::vector<Eigen::Vector3f> ReadLandmarks(const fs::path& path) {
  const std::string text = TextIfThere(path);
  if (text.empty()) return {};
  constexpr std::string_view kCount = "element vertex ";
  constexpr std::string_view kEnd = "end_header\n";
  constexpr size_t kVertexBytes = 15;
  const size_t count_at = text.find(kCount);
  const size_t end = text.find(kEnd);
  const auto count = count_at < end && end != std::string::npos
                         ? ParseNumber<size_t>(std::string_view(text).substr(
                               count_at + kCount.size(), text.find('\n', count_at) - count_at - kCount.size()))
                         : std::nullopt;
  const size_t body = end + kEnd.size();
  const bool fits = count && (text.size() - body) % kVertexBytes == 0 && (text.size() - body) / kVertexBytes == *count;
  if (!fits) throw InputError(path.string() + ": is not a map that turnscale has written");
  std::vector<Eigen::Vector3f> landmarks;
  for (size_t i = 0; i < *count; ++i) {
    const size_t place = body + i * kVertexBytes;
    const bool is_camera = text[place + 12] != text[place + 13];
    if (!is_camera) landmarks.emplace_back(FloatAt(text, place), FloatAt(text, place + 4), FloatAt(text, place + 8));
  }
  return landmarks;
}

// From the intrinsics in the summary, if they are there.
void ReadView(const nlohmann::json& intrinsics, ResultFolder& results) {
  if (!intrinsics.is_object() ||
      intrinsics.value("lens_model", nlohmann::json()) == LensModelName(LensModel::kEquidistant))
    return;
  const auto pair = [&](const char* name) {
    const nlohmann::json values = intrinsics.value(name, nlohmann::json());
    const bool known = values.is_array() && values.size() == 2 && values[0].is_number() && values[1].is_number();
    return known ? Eigen::Vector2d(values[0].get<double>(), values[1].get<double>()) : Eigen::Vector2d(0, 0);
  };
  const Eigen::Vector2d size = pair("image_size");
  const Eigen::Vector2d focal = pair("focal_length");
  if (!(size.minCoeff() > 0 && focal.minCoeff() > 0)) return;
  results.horizontal_fov = 2 * std::atan(0.5 * size.x() / focal.x());
  results.aspect = (size.x() / focal.x()) / (size.y() / focal.y());
}

void ReadSummary(const fs::path& path, ResultFolder& results) {
  results.summary = TextIfThere(path);
  const auto json = nlohmann::json::parse(results.summary, nullptr, false);
  const auto member = [&](const char* name) { return json.is_object() ? json.value(name, nlohmann::json()) : json; };
  const nlohmann::json angles = member("camera_yaw_pitch_roll_deg");
  const bool is_summary = json.is_object() && angles.is_array() && angles.size() == 3 &&
                          std::ranges::all_of(angles, [](const auto& angle) { return angle.is_number(); });
  if (!is_summary) throw InputError(path.string() + ": is not a summary of a run");
  results.metric = member("distance_m").is_number();
  if (const nlohmann::json recorded = member("recorded_from"); recorded.is_string())
    results.recorded_from = recorded.get<std::string>();
  const nlohmann::json scale = member("scale");
  if (scale.is_object() && scale.value("known", nlohmann::json()).is_boolean())
    results.scale_known = scale["known"].get<bool>();
  ReadView(member("intrinsics"), results);
  results.poses_of_vehicle = member("pose_frame") == "vehicle";
  if (results.poses_of_vehicle) return;
  results.vehicle_from_body = RotationFromYawPitchRoll({angles[0].get<double>() / kDegreesPerRadian,
                                                        angles[1].get<double>() / kDegreesPerRadian,
                                                        angles[2].get<double>() / kDegreesPerRadian});
}

}  // namespace

Trajectory ResultFolder::Poses() const {
  Trajectory poses;
  for (const FrameResult& frame : frames)
    if (frame.world_from_camera) poses.push_back({frame.time, *frame.world_from_camera});
  return poses;
}

ResultFolder ReadResultFolder(const fs::path& folder) {
  std::error_code none;
  if (!fs::is_directory(folder, none)) throw InputError(folder.string() + ": is not a folder with results of a run");
  for (const char* name : {RunFiles::kSummary, RunFiles::kTrajectoryTable})
    if (!fs::exists(folder / name, none))
      throw InputError((folder / name).string() + ": no such file; give the --out folder of turnscale run");
  ResultFolder results;
  ReadSummary(folder / RunFiles::kSummary, results);
  results.settings = TextIfThere(folder / RunFiles::kSettings);
  results.frames = ReadFrames(folder / RunFiles::kTrajectoryTable);
  results.turns = ReadTurns(folder / RunFiles::kTurns);
  ReadTable(folder / RunFiles::kSpeed, [&](CsvTable& table) {
    results.speeds.push_back({table.Value<double>(table.Column("time")), table.Value<double>(table.Column("speed_mps")),
                              table.Value<double>(table.Column("sigma_mps"))});
  });
  ReadTable(folder / RunFiles::kScale, [&](CsvTable& table) {
    results.scale.push_back({table.Value<int>(table.Column("frame")), table.Value<double>(table.Column("time")),
                             table.Value<double>(table.Column("metres_per_unit")),
                             table.Value<double>(table.Column("sigma"))});
  });
  results.rotations = ReadRotations(folder / RunFiles::kRotation);
  results.landmarks = ReadLandmarks(folder / RunFiles::kMap);
  return results;
}

}  // namespace turnscale
