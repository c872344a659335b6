// SPDX-License-Identifier: MIT
#include "turnscale/io/calibration_file.h"

#include <fmt/format.h>

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

}  // namespace turnscale
