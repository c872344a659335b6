// SPDX-License-Identifier: MIT
#include "turnscale/report/run_report.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/file_text.h"
#include "turnscale/io/output_file.h"
#include "turnscale/report/report_page.h"
#include "turnscale/run/run_summary.h"
#include "turnscale/run/run_writer.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;
using Summary = nlohmann::json;

constexpr double kKmhPerMps = 3.6;

// Values that a summary of another version may lack.
double NumberAt(const Summary& json, const char* pointer) {
  const Summary::json_pointer place(pointer);
  return json.contains(place) && json.at(place).is_number() ? json.at(place).get<double>() : NAN;
}

std::string TextAt(const Summary& json, const char* pointer) {
  const Summary::json_pointer place(pointer);
  return json.contains(place) && json.at(place).is_string() ? json.at(place).get<std::string>() : "";
}

// Empty where the number is not known.
std::string Percent(double share, const char* more = "") {
  if (share > kLargestShownSigma) return fmt::format("beyond \u00b1100 %{}", more);
  return std::isfinite(share) ? fmt::format("\u00b1{:.{}f} %{}", 100 * share, share < 0.1 ? 1 : 0, more) : "";
}

std::string Clock(double seconds) {
  const auto whole = static_cast<int>(std::lround(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  return whole >= 3600 ? fmt::format("{}:{:02}:{:02} h", whole / 3600, whole / 60 % 60, whole % 60)
                       : fmt::format("{}:{:02} min", whole / 60, whole % 60);
}

// A moment of the page as its clock shows it; the page makes it a link to that place.
std::string Moment(double seconds) {
  const auto tenths = std::llround(10 * std::max(seconds, 0.0));
  const auto minutes = tenths / 600;
  const std::string rest = fmt::format("{:02}.{}", tenths / 10 % 60, tenths % 10);
  return minutes >= 60 ? fmt::format("{}:{:02}:{}", minutes / 60, minutes % 60, rest)
                       : fmt::format("{}:{}", minutes, rest);
}

// With its standard deviation in the same unit, if that is known.
std::string Metres(double metres, double sigma = NAN) {
  const bool far = metres >= 1000;
  const double per_unit = far ? 1000 : 1;
  const int digits = far ? 2 : 1;
  const std::string band = std::isfinite(sigma) ? fmt::format(" \u00b1{:.{}f}", sigma / per_unit, digits) : "";
  return fmt::format("{:.{}f}{} {}", metres / per_unit, digits, band, far ? "km" : "m");
}

std::string Speed(double mps) {
  const double kmh = kKmhPerMps * mps;
  return fmt::format("{:.{}f} km/h", kmh, kmh < 100 ? 1 : 0);
}

// That of the drive's first frame, which a summary of an earlier version lacks.
double OriginOf(const Summary& summary, const ResultFolder& results) {
  const double first_frame = NumberAt(summary, "/first_frame_s");
  return std::isfinite(first_frame) ? first_frame : TimeOrigin(results.frames);
}

std::vector<ReportFact> FactsOf(const Summary& summary, const ResultFolder& results, bool metric) {
  std::vector<ReportFact> facts;
  if (metric) {
    const double length = NumberAt(summary, "/distance_m");
    const double sigma = NumberAt(summary, "/path_sigma");
    facts.push_back({"Path length", Metres(length, sigma > kLargestShownSigma ? NAN : sigma * length),
                     Percent(sigma, " (1 sigma)")});
  } else {
    const double length = NumberAt(summary, "/distance_units");
    if (std::isfinite(length)) facts.push_back({"Path length", fmt::format("{:.2f} units", length), "up to scale"});
  }
  const double origin = OriginOf(summary, results);
  const double seconds = results.frames.empty() ? 0 : results.frames.back().time - results.frames.front().time;
  facts.push_back({"Duration", Clock(seconds), fmt::format("{} frames", results.frames.size())});
  if (!results.speeds.empty()) {
    const auto top = std::max_element(results.speeds.begin(), results.speeds.end(), [](const auto& a, const auto& b) {
      return std::abs(a.speed) < std::abs(b.speed);
    });
    facts.push_back({"Top speed", Speed(std::abs(top->speed)),
                     (std::isfinite(top->sigma) ? fmt::format("\u00b1{:.1f} km/h, ", kKmhPerMps * top->sigma) : "") +
                         (top->speed < 0 ? "in reverse, " : "") + "at " + Moment(top->time - origin)});
    const double driven = NumberAt(summary, "/distance_m");
    if (std::isfinite(driven) && seconds > 0)
      facts.push_back({"Mean speed", Speed(driven / seconds), "standstill included"});
  }
  const double used = NumberAt(summary, "/turns/used");
  const double found = NumberAt(summary, "/turns/found");
  if (std::isfinite(used + found))
    facts.push_back({"Turns", fmt::format("{:.0f} of {:.0f}", used, found), "used for the scale"});
  const double worst = NumberAt(summary, "/scale/worst_relative_sigma");
  const double worst_at = NumberAt(summary, "/scale/worst_at_s");
  // Along most drives it is that of the whole path, which stands above.
  constexpr double kClearly = 1.5;
  const bool is_news = !(worst < kClearly * NumberAt(summary, "/path_sigma"));
  if (metric && std::isfinite(worst + worst_at) && is_news)
    facts.push_back({"Largest uncertainty", Percent(worst), "1 sigma of the scale, at " + Moment(worst_at - origin)});
  const double tracked = NumberAt(summary, "/frames/tracked");
  const double total = NumberAt(summary, "/frames/total");
  if (tracked >= 0 && total > 0)
    facts.push_back({"Tracked", fmt::format("{:.4g} %", std::floor(1e3 * tracked / total) / 10), "of the frames"});
  return facts;
}

std::string MissingText(const Summary& part, double origin) {
  return fmt::format("{} from {} to {}", TextAt(part, "/reason"), Moment(NumberAt(part, "/from_s") - origin),
                     Moment(NumberAt(part, "/to_s") - origin));
}

std::vector<std::string> WarningsOf(const Summary& summary, double origin, bool metric) {
  std::vector<std::string> warnings;
  if (const std::string stopped = TextAt(summary, "/stopped"); !stopped.empty())
    warnings.push_back("The run ended early: " + stopped);
  if (!metric) {
    const std::string reason = TextAt(summary, "/scale/pending_reason");
    const bool has_measure =
        std::isfinite(NumberAt(summary, "/lever_arm_m")) || std::isfinite(NumberAt(summary, "/camera_height_m"));
    warnings.push_back("The path is not in metres: " + (!has_measure     ? "no lever arm was given (--lever-arm)"
                                                        : reason.empty() ? "no turn has determined the scale"
                                                                         : reason));
  }
  const Summary texts = summary.value("warnings", Summary::array());
  for (const Summary& text : texts)
    if (text.is_string()) warnings.push_back(text.get<std::string>());
  const Summary missing = summary.value("missing", Summary::object());
  const double seconds = NumberAt(missing, "/seconds");
  if (seconds > 0) {
    std::string text =
        fmt::format("The path is not measured for {:.1f} s of {:.1f} s", seconds, NumberAt(missing, "/of_s"));
    std::string separator = ": ";
    for (const Summary& part : missing.value("longest", Summary::array())) {
      text += std::exchange(separator, "; ") + MissingText(part, origin);
    }
    warnings.push_back(text);
  }
  return warnings;
}

std::vector<std::string> NotesOf(const Summary& summary) {
  std::vector<std::string> notes;
  if (const double arm = NumberAt(summary, "/lever_arm_m"); std::isfinite(arm))
    notes.push_back(fmt::format("Lever arm {:g} m", arm));
  const double slip = NumberAt(summary, "/by_all_turns/side_slip_s2_per_m");
  const double slip_sigma = NumberAt(summary, "/by_all_turns/side_slip_sigma_s2_per_m");
  const double assumed = NumberAt(summary, "/side_slip_s2_per_m");
  if (std::isfinite(slip + slip_sigma + assumed) && NumberAt(summary, "/turns/used") > 0)
    notes.push_back(
        fmt::format("Side slip {:.4f} \u00b1{:.4f} s\u00b2/m (before the drive: {:.4f})", slip, slip_sigma, assumed));
  notes.push_back("Intrinsics " + TextAt(summary, "/intrinsics/source"));
  const bool of_axle = TextAt(summary, "/pose_frame") == "vehicle" && std::isfinite(NumberAt(summary, "/distance_m"));
  notes.push_back(of_axle ? "Path of the rear axle" : "Path of the camera");
  return notes;
}

}  // namespace

ReportData DataOfRun(const ResultFolder& results, std::vector<Thumbnail> thumbnails, const RunReportExtras& extras) {
  const Summary summary = Summary::parse(results.summary);
  ReportData data;
  data.title = TextAt(summary, "/input");
  data.version = TextAt(summary, "/version");
  data.metric = std::isfinite(NumberAt(summary, "/distance_m"));
  data.time_origin = OriginOf(summary, results);
  data.warnings = WarningsOf(summary, *data.time_origin, data.metric);
  data.notes = NotesOf(summary);
  data.facts = FactsOf(summary, results, data.metric);
  data.frames = results.frames;
  data.vehicle_from_body = results.vehicle_from_body;
  data.turns = results.turns;
  data.speeds = results.speeds;
  data.scale = results.scale;
  data.rotations = results.rotations;
  data.landmarks = results.landmarks;
  data.thumbnails = std::move(thumbnails);
  data.truth = extras.truth;
  if (!extras.evaluation.empty()) data.errors = ErrorFacts(extras.evaluation, data.metric);
  data.outlines = extras.outlines;
  data.settings = results.settings;
  return data;
}

void WriteRunReport(const fs::path& folder, const RunReportExtras& extras) {
  const ResultFolder results = ReadResultFolder(folder);
  ReportData data = DataOfRun(results, ReadThumbnails(folder, results.frames), extras);
  if (const std::optional<std::string> page = FileText(folder / kReportFile); page && IsReportPage(*page))
    data.earlier = DataOfPage(*page, kReportFile);
  try {
    ReplaceFile(folder / kReportFile, ReportPage(ShortPath(data.title), ReportJson(data)));
  } catch (const InputError& error) {
    throw OutputError(error.what());
  }
}

std::vector<ReportFact> ErrorFacts(const std::string& evaluation_json, bool metric) {
  const Summary json = Summary::parse(evaluation_json);
  std::vector<ReportFact> facts;
  const auto add = [&](const char* name, const char* pointer, const char* format, const std::string& note) {
    if (const double value = NumberAt(json, pointer); std::isfinite(value))
      facts.push_back({name, fmt::format(fmt::runtime(format), value), note});
  };
  const double true_length = NumberAt(json, "/true_path_length_m");
  const double length_error = NumberAt(json, "/as_given/path_length_error_percent");
  if (!metric) {
    add("True path length", "/true_path_length_m", "{:.1f} m", "");
    add("Metres per unit", "/position_error/sim3/scale", "{:.4g}", "by the truth");
    add("Translation error", "/rescaled/kitti/translation_percent", "{:.2f} %", "KITTI, path scaled");
    add("Rotation error", "/rescaled/kitti/rotation_deg_per_100m", "{:.2f} deg/100 m", "KITTI, path scaled");
    add("Position error", "/position_error/sim3/rmse_m", "{:.2f} m", "RMSE, best fit with scale (Sim(3))");
    return facts;
  }
  const bool has_length = std::isfinite(true_length + length_error);
  if (!has_length) add("True path length", "/true_path_length_m", "{:.1f} m", "");
  add("Path length error", "/as_given/path_length_error_percent", "{:+.2f} %",
      has_length ? Metres(true_length * (1 + length_error / 100)) + ", true " + Metres(true_length) : "");
  add("Translation error", "/as_given/kitti/translation_percent", "{:.2f} %", "KITTI");
  add("Rotation error", "/as_given/kitti/rotation_deg_per_100m", "{:.2f} deg/100 m", "KITTI");
  add("Scale error ratio", "/as_given/scale_error_ratio/all/median_percent", "{:.2f} %", "median");
  add("Position error, start aligned", "/position_error/first_poses_equal/rmse_m", "{:.2f} m",
      "RMSE, first poses equal");
  add("Position error, best fit", "/position_error/sim3/rmse_m", "{:.2f} m", "RMSE, with scale (Sim(3))");
  return facts;
}

}  // namespace turnscale
