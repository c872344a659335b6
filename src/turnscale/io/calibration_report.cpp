// SPDX-License-Identifier: MIT
#include "turnscale/io/calibration_report.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/calibration/online_calibration.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {
namespace {

// A name may hold what means something in YAML.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string SlipSource(const LeverArmFit& arm) {
  if (arm.slip_at_bound) return "estimated, at its bound";
  return arm.sigma_side_slip > 0 ? fmt::format("+- {:.4f}", arm.sigma_side_slip) : "assumed";
}

// Cells of what is not known yet are empty.
std::string Cell(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : ""; }

using Value = std::function<double(const CalibrationMoment&)>;

// One of the graphs above each other, in units of the page, about pixels.
class Graph {
 public:
  static constexpr double kLeft = 64;
  static constexpr double kWidth = 760;
  static constexpr double kHeight = 190;

  Graph(double top, double begin, double end, double low, double high)
      : top_(top), begin_(begin), end_(end), low_(low), high_(high) {}

  double X(double time) const { return kLeft + kWidth * (time - begin_) / (end_ - begin_); }
  double Y(double value) const {
    return top_ + kHeight * (1 - (std::clamp(value, low_, high_) - low_) / (high_ - low_));
  }

  std::string Frame(const std::string& title) const {
    std::string text = fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" class=\"frame\"/>\n", kLeft,
                                   top_, kWidth, kHeight);
    text += fmt::format("<text x=\"{}\" y=\"{:.0f}\">{}</text>\n", kLeft, top_ - 8, title);
    for (int i = 0; i <= 4; ++i) {
      const double value = low_ + (high_ - low_) * i / 4;
      text += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:.3g}</text>\n", kLeft - 6, Y(value) + 4,
                          value);
      const double time = begin_ + (end_ - begin_) * i / 4;
      text += fmt::format("<text x=\"{:.1f}\" y=\"{:.0f}\" text-anchor=\"middle\">{:.0f}</text>\n", X(time),
                          top_ + kHeight + 16, time);
    }
    return text;
  }

  std::string Line(const std::vector<CalibrationMoment>& history, const Value& value, const char* color) const {
    std::string path;
    bool drawing = false;
    for (const CalibrationMoment& moment : history) {
      const double v = value(moment);
      if (std::isfinite(v)) path += fmt::format("{}{:.1f},{:.1f} ", drawing ? "L" : "M", X(moment.time), Y(v));
      drawing = std::isfinite(v);
    }
    return path.empty() ? "" : fmt::format("<path d=\"{}\" stroke=\"{}\"/>\n", path, color);
  }

  std::string Band(const std::vector<CalibrationMoment>& history, const Value& value, const Value& sigma,
                   const char* color) const {
    std::string there;
    std::vector<std::string> back;
    for (const CalibrationMoment& moment : history) {
      if (!std::isfinite(sigma(moment))) continue;
      there += fmt::format("{:.1f},{:.1f} ", X(moment.time), Y(value(moment) + sigma(moment)));
      back.push_back(fmt::format("{:.1f},{:.1f} ", X(moment.time), Y(value(moment) - sigma(moment))));
    }
    if (there.empty()) return "";
    there = std::accumulate(back.rbegin(), back.rend(), std::move(there));
    return fmt::format("<polygon points=\"{}\" fill=\"{}\" fill-opacity=\"0.15\"/>\n", there, color);
  }

  std::string Dashed(double value, const char* color) const {
    return fmt::format("<path d=\"M{0},{1:.1f}h{2}\" stroke=\"{3}\" stroke-dasharray=\"6 4\"/>\n", kLeft, Y(value),
                       kWidth, color);
  }

 private:
  double top_;
  double begin_;
  double end_;
  double low_;
  double high_;
};

constexpr const char* kColors[] = {"#c2185b", "#1565c0", "#2e7d32"};

std::vector<Value> Angles() {
  return {[](const CalibrationMoment& m) { return InDegrees(m.angles.yaw); },
          [](const CalibrationMoment& m) { return InDegrees(m.angles.pitch); },
          [](const CalibrationMoment& m) { return InDegrees(m.angles.roll); }};
}

std::vector<Value> Sigmas() {
  return {[](const CalibrationMoment& m) { return InDegrees(m.sigma.yaw); },
          [](const CalibrationMoment& m) { return InDegrees(m.sigma.pitch); },
          [](const CalibrationMoment& m) { return InDegrees(m.sigma.roll); }};
}

// Of equal runs of moments, the one that turns most.
std::vector<CalibrationMoment> Thinned(const std::vector<CalibrationMoment>& history) {
  constexpr size_t kMost = 1500;
  const size_t run = history.size() / kMost + 1;
  std::vector<CalibrationMoment> thinned;
  for (size_t i = 0; i < history.size(); i += run) {
    const auto begin = history.begin() + static_cast<std::ptrdiff_t>(i);
    const auto end = begin + static_cast<std::ptrdiff_t>(std::min(run, history.size() - i));
    thinned.push_back(*std::max_element(begin, end, [](const CalibrationMoment& a, const CalibrationMoment& b) {
      return std::abs(a.psi) < std::abs(b.psi);
    }));
  }
  return thinned;
}

}  // namespace

std::string CalibrationYaml(const CalibrationReport& report) {
  const Calibration& found = report.calibration;
  const Eigen::Quaterniond& q = found.vehicle_from_camera;
  std::string text = fmt::format(
      "# Camera-to-vehicle rotation: R_y(yaw) R_x(pitch) R_z(roll), axes x right, y down, z forward.\n"
      "# The z-y-x Euler angles of forward-right-down axes. For run --camera-rotation.\n"
      "yaw_deg: {:.6f}  # to the right\n"
      "pitch_deg: {:.6f}  # up\n"
      "roll_deg: {:.6f}  # leaning right\n"
      "yaw_sigma_deg: {:.6f}\n"
      "pitch_sigma_deg: {:.6f}\n"
      "roll_sigma_deg: {:.6f}\n"
      "vehicle_from_camera_wxyz: [{:.12g}, {:.12g}, {:.12g}, {:.12g}]\n",
      InDegrees(found.angles.yaw), InDegrees(found.angles.pitch), InDegrees(found.angles.roll),
      InDegrees(found.sigma.yaw), InDegrees(found.sigma.pitch), InDegrees(found.sigma.roll), q.w(), q.x(), q.y(),
      q.z());
  if (report.lever_arm) {
    const LeverArmFit& arm = *report.lever_arm;
    text += fmt::format("lever_arm: {:.6g}  # metres from the rear axle forward to the camera\n", arm.lever_arm.length);
    if (arm.turning_steps > 0) text += fmt::format("lever_arm_sigma: {:.3g}  # metres\n", arm.sigma_length);
    text += fmt::format("side_slip: {:.6g}  # c in L_eff = L - c v^2, s^2/m\n", arm.lever_arm.side_slip);
    if (arm.sigma_side_slip > 0) text += fmt::format("side_slip_sigma: {:.3g}\n", arm.sigma_side_slip);
  }
  return text + fmt::format(
                    "confidence: {:.4g}  # ratio of the two smallest singular values\n"
                    "frames: {}\nsteps: {}\nturns: {}\nturning_deg: {:.1f}\ninput: {}\n",
                    found.linear.confidence, report.frames, found.steps, found.turns, InDegrees(found.turning),
                    Quoted(report.input));
}

std::string CalibrationText(const CalibrationReport& report) {
  const Calibration& found = report.calibration;
  const auto angle = [](const char* name, double value, double sigma, const char* sense) {
    return fmt::format("{:<12}{:>8.2f} +- {:.2f} deg  {}\n", name, InDegrees(value), InDegrees(sigma), sense);
  };
  std::string text = angle("yaw", found.angles.yaw, found.sigma.yaw, "to the right");
  text += angle("pitch", found.angles.pitch, found.sigma.pitch, "up");
  text += angle("roll", found.angles.roll, found.sigma.roll, "leaning right");
  if (report.lever_arm) {
    const LeverArmFit& arm = *report.lever_arm;
    const bool measured = arm.turning_steps > 0;
    text += fmt::format("{:<12}{:>8.3f}{} m, with side slip {:.4f} s^2/m ({})\n", "lever arm", arm.lever_arm.length,
                        measured ? fmt::format(" +- {:.3f}", arm.sigma_length) : "", arm.lever_arm.side_slip,
                        SlipSource(arm));
  }
  text += fmt::format("{:<12}{} frames in {} steps, {} turns of {:.0f} deg in all{}\n", "data", report.frames,
                      found.steps, found.turns, InDegrees(found.turning),
                      found.reversed > 0 ? fmt::format(", {} steps backwards", found.reversed) : "");
  text +=
      fmt::format("{:<12}{:.1f} (ratio of the two smallest singular values)\n", "confidence", found.linear.confidence);
  return text;
}

std::vector<CalibrationMoment> CalibrationHistory(const std::vector<CameraStep>& steps) {
  OnlineCalibration online;
  std::vector<CalibrationMoment> history;
  int frames = 0;
  for (const CameraStep& step : steps) {
    const OnlineState& state = online.Add(step);
    frames += step.frames;
    history.push_back({step.end, frames, TurningMotionOf(step.previous_from_current, state.vehicle_from_camera).psi,
                       state.singular_values, state.angles, state.sigma, state.moved});
  }
  return history;
}

std::string HistoryCsv(const std::vector<CalibrationMoment>& history) {
  std::string text =
      "time,frames,psi_deg,singular_value_1,singular_value_2,singular_value_3,singular_value_4,yaw_deg,pitch_deg,"
      "roll_deg,yaw_sigma_deg,pitch_sigma_deg,roll_sigma_deg,moved\n";
  for (const CalibrationMoment& moment : history) {
    const Eigen::Vector4d& s = moment.singular_values;
    text +=
        fmt::format("{:.6f},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{},{},{}\n", moment.time,
                    moment.frames, InDegrees(moment.psi), s[0], s[1], s[2], s[3], InDegrees(moment.angles.yaw),
                    InDegrees(moment.angles.pitch), InDegrees(moment.angles.roll), Cell(InDegrees(moment.sigma.yaw)),
                    Cell(InDegrees(moment.sigma.pitch)), Cell(InDegrees(moment.sigma.roll)), moment.moved ? 1 : 0);
  }
  return text;
}

std::string HistorySvg(const std::vector<CalibrationMoment>& whole, const std::string& title,
                       const std::optional<YawPitchRoll>& truth) {
  if (whole.empty()) throw InputError("the plot of the calibration: nothing to draw");
  const std::vector<CalibrationMoment> history = Thinned(whole);
  const double begin = history.front().time;
  const double end = std::max(history.back().time, begin + 1);
  double most_psi = 1;
  double most_singular = 1e-3;
  double low = 0;
  double high = 0;
  for (const CalibrationMoment& moment : history) {
    most_psi = std::max(most_psi, std::abs(InDegrees(moment.psi)));
    most_singular = std::max(most_singular, moment.singular_values[1]);
    if (!std::isfinite(moment.sigma.yaw)) continue;
    for (const Value& angle : Angles()) {
      low = std::min(low, angle(moment));
      high = std::max(high, angle(moment));
    }
  }
  std::string text =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 860 780\" width=\"860\" height=\"780\">\n<style>"
      "text{font-family:sans-serif;font-size:13px;fill:#333}.title{font-size:15px;font-weight:bold}"
      "path{fill:none;stroke-width:1.6;stroke-linejoin:round}.frame{fill:none;stroke:#9aa0a8}</style>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
  text += fmt::format("<text x=\"24\" y=\"28\" class=\"title\">{}</text>\n", EscapedXml(title));
  const Graph psi(70, begin, end, -most_psi, most_psi);
  text += psi.Frame("turning angle per frame, deg, over time, s");
  text += psi.Line(
      history, [](const CalibrationMoment& m) { return InDegrees(m.psi); }, "#333");
  const Graph singular(310, begin, end, 0, most_singular);
  text += singular.Frame("the two smallest singular values of M (14): smallest (red), second smallest (blue)");
  for (int i = 0; i < 2; ++i) {
    text += singular.Line(
        history, [i](const CalibrationMoment& m) { return m.singular_values[i]; }, kColors[i]);
  }
  const Graph angles(550, begin, end, std::floor(low - 2), std::ceil(high + 2));
  text += angles.Frame("refined yaw (red), pitch (blue), roll (green), deg, with 1 sigma; dashed: ground truth");
  const double true_angles[] = {truth ? truth->yaw : 0, truth ? truth->pitch : 0, truth ? truth->roll : 0};
  for (int i = 0; i < 3; ++i) {
    const Value sigma = Sigmas()[i];
    const Value angle = Angles()[i];
    text += angles.Band(history, angle, sigma, kColors[i]);
    const Value known = [&](const CalibrationMoment& m) {
      return std::isfinite(sigma(m)) ? angle(m) : std::numeric_limits<double>::quiet_NaN();
    };
    text += angles.Line(history, known, kColors[i]);
    if (truth) text += angles.Dashed(InDegrees(true_angles[i]), kColors[i]);
  }
  return text + "</svg>\n";
}

}  // namespace turnscale
