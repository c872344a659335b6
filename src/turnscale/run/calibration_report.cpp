// SPDX-License-Identifier: MIT
#include "turnscale/run/calibration_report.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>

#include <fmt/format.h>

#include "turnscale/base/csv_cells.h"
#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/calibration/online_calibration.h"
#include "turnscale/figure/figure.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/run/vehicle_file.h"

namespace turnscale {
namespace {

std::string SlipSource(const LeverArmFit& arm) {
  if (arm.slip_at_bound) return "estimated, at its bound";
  const std::string sigma = arm.sigma_side_slip > 0 ? fmt::format("+-{:.4f}", arm.sigma_side_slip) : "";
  if (arm.slip_fitted) return sigma;
  return sigma.empty() ? "assumed" : "assumed, " + sigma;
}

double WrittenCorrelation(const LeverArmFit& arm) {
  return std::clamp(arm.slip_correlation, -kMostCorrelation, kMostCorrelation);
}

constexpr const char* kColors[] = {"#c2185b", "#1565c0", "#2e7d32"};
constexpr const char* kAngleNames[] = {"yaw", "pitch", "roll"};

using Value = std::function<double(const CalibrationMoment&)>;

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

PlotPoints Over(const std::vector<CalibrationMoment>& history, const Value& value) {
  PlotPoints points;
  for (const CalibrationMoment& moment : history) points.emplace_back(moment.time, value(moment));
  return points;
}

// One sigma to both sides, where there is one.
PlotPoints Band(const std::vector<CalibrationMoment>& history, const Value& value, const Value& sigma) {
  PlotPoints points;
  PlotPoints back;
  for (const CalibrationMoment& moment : history) {
    if (!std::isfinite(sigma(moment))) continue;
    points.emplace_back(moment.time, value(moment) + sigma(moment));
    back.emplace_back(moment.time, value(moment) - sigma(moment));
  }
  points.insert(points.end(), back.rbegin(), back.rend());
  return points;
}

PlotPanel AnglesPanel(const std::vector<CalibrationMoment>& history, const PlotRange& time,
                      const std::optional<YawPitchRoll>& truth) {
  PlotPanel panel;
  panel.title = "refined camera-to-vehicle rotation with its one-sigma bands";
  panel.x_label = "time [s]";
  panel.y_label = "angle [deg]";
  panel.x = time;
  PlotRange range{0, 0};
  const std::vector<Value> sigmas = Sigmas();
  const std::vector<Value> angles = Angles();
  const double true_angles[] = {truth ? truth->yaw : 0, truth ? truth->pitch : 0, truth ? truth->roll : 0};
  for (int i = 0; i < 3; ++i) {
    const Value known = [&](const CalibrationMoment& m) {
      return std::isfinite(sigmas[i](m)) ? angles[i](m) : std::numeric_limits<double>::quiet_NaN();
    };
    panel.areas.push_back({Band(history, angles[i], sigmas[i]), "", kColors[i], 0.15});
    panel.lines.push_back({Over(history, known), kAngleNames[i], kColors[i], 1.6});
    const double at = InDegrees(true_angles[i]);
    if (truth) panel.lines.push_back({{{time.low, at}, {time.high, at}}, "ground truth", kColors[i], 1.4, "6 4"});
    const auto include = [&](double angle) {
      range.low = std::min(range.low, angle);
      range.high = std::max(range.high, angle);
    };
    if (truth) include(at);
    // The bands before the first turn are wide.
    for (const CalibrationMoment& moment : history)
      if (std::isfinite(known(moment))) include(known(moment));
  }
  panel.y = PlotRange{std::floor(range.low - 2), std::ceil(range.high + 2)};
  return panel;
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
    if (arm.slip_correlation != 0)
      text += fmt::format("lever_arm_slip_correlation: {:.4f}  # of the errors of both\n", WrittenCorrelation(arm));
  }
  return text + fmt::format(
                    "confidence: {:.4g}  # ratio of the two smallest singular values\n"
                    "frames: {}\nsteps: {}\nturns: {}\nturning_deg: {:.1f}\ninput: {}\n",
                    found.linear.confidence, report.frames, found.steps, found.turns, InDegrees(found.turning),
                    QuotedYaml(report.input));
}

std::string CalibrationText(const CalibrationReport& report) {
  const Calibration& found = report.calibration;
  const auto angle = [](const char* name, double value, double sigma, const char* sense) {
    return fmt::format("{:<12}{:>8.2f} +-{:.2f} deg  {}\n", name, InDegrees(value), InDegrees(sigma), sense);
  };
  std::string text = angle("yaw", found.angles.yaw, found.sigma.yaw, "to the right");
  text += angle("pitch", found.angles.pitch, found.sigma.pitch, "up");
  text += angle("roll", found.angles.roll, found.sigma.roll, "leaning right");
  if (report.lever_arm) {
    const LeverArmFit& arm = *report.lever_arm;
    const bool measured = arm.turning_steps > 0;
    text += fmt::format("{:<12}{:>8.3f}{} m, with side slip {:.4f} s^2/m ({})\n", "lever arm", arm.lever_arm.length,
                        measured ? fmt::format(" +-{:.3f}", arm.sigma_length) : "", arm.lever_arm.side_slip,
                        SlipSource(arm));
    if (measured && arm.slip_correlation != 0)
      text += fmt::format("{:<12}{:>8} +-{:.3f} m if the side slip is exactly that\n", "", "", arm.SigmaAtExactSlip());
  }
  if (!report.lever_arm)
    text +=
        fmt::format("{:<12}not estimated: the file has the rotation only; run needs --lever-arm, too\n", "lever arm");
  text += fmt::format("{:<12}{} frames in {} steps, {} turns of {:.0f} deg in all{}\n", "data", report.frames,
                      found.steps, found.turns, InDegrees(found.turning),
                      found.reversed > 0 ? fmt::format(", {} steps backwards", found.reversed) : "");
  // Less is refused (Calibration::observable).
  text += fmt::format("{:<12}{:.1f} (ratio of the two smallest singular values; at least {:g} is needed)\n",
                      "confidence", found.linear.confidence, CalibrationOptions().min_confidence);
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
    text += fmt::format("{:.6f},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{},{},{}\n", moment.time,
                        moment.frames, InDegrees(moment.psi), s[0], s[1], s[2], s[3], InDegrees(moment.angles.yaw),
                        InDegrees(moment.angles.pitch), InDegrees(moment.angles.roll),
                        PositiveCell(InDegrees(moment.sigma.yaw)), PositiveCell(InDegrees(moment.sigma.pitch)),
                        PositiveCell(InDegrees(moment.sigma.roll)), moment.moved ? 1 : 0);
  }
  return text;
}

std::string HistorySvg(const std::vector<CalibrationMoment>& whole, const std::string& title,
                       const std::optional<YawPitchRoll>& truth) {
  if (whole.empty()) throw InputError("the plot of the calibration: nothing to draw");
  const std::vector<CalibrationMoment> history = Thinned(whole);
  const PlotRange time{history.front().time, std::max(history.back().time, history.front().time + 1)};
  PlotPanel psi;
  psi.title = "turning angle of a frame";
  psi.y_label = "psi [deg]";
  psi.x = time;
  psi.lines = {{Over(history, [](const CalibrationMoment& m) { return InDegrees(m.psi); }), "", "#333", 1.6}};
  PlotPanel singular;
  singular.title = "the two smallest singular values of M (14)";
  singular.y_label = "singular value";
  singular.x = time;
  constexpr const char* kRanks[] = {"smallest", "second smallest"};
  for (int i = 0; i < 2; ++i) {
    const Value value = [i](const CalibrationMoment& m) { return m.singular_values[i]; };
    singular.lines.push_back({Over(history, value), kRanks[i], kColors[i], 1.6});
  }
  Figure figure;
  figure.title = title;
  figure.panel_width = 680;
  figure.panel_height = 180;
  figure.panels = {psi, singular, AnglesPanel(history, time, truth)};
  return FigureSvg(figure);
}

}  // namespace turnscale
