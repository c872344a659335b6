// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "lab_experiments.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/laboratory/paper_drive.h"
#include "turnscale/laboratory/sensitivity.h"

namespace turnscale {
namespace {

constexpr double kDeg = 1 / kDegreesPerRadian;
constexpr std::array<double, 6> kTravelRatios = {0.1, 0.2, 0.3, 0.4, 0.6, 1.0};
constexpr double kMostPsi = 10;  // deg
constexpr std::array<double, 2> kAngleErrors = {0.05, 0.1};
// What the paper says of the region of interest, and of its example (V-A).
constexpr double kPaperMeanError = 2.5;
constexpr double kPaperWorstError = 5.5;
constexpr double kPaperExampleError = 0.02;

std::string RatioColor(double ratio) {
  return ScaleColor(std::log(ratio / kTravelRatios.front()) / std::log(kTravelRatios.back() / kTravelRatios.front()));
}

std::string RatioLabel(double ratio) { return fmt::format("rho/L = {:g}", ratio); }

template <class Value>
PlotPoints CurveOverPsi(double from, const Value& value) {
  PlotPoints points;
  for (double psi = from; psi <= kMostPsi + 1e-9; psi += 0.1) points.emplace_back(psi, value(psi * kDeg));
  return points;
}

double ErrorRatio(double psi, double ratio, double error) {
  return 100 * ScaleErrorRatio(psi, ratio, error, SensitivityOfStep(psi, ratio));
}

// Where psi and rho/L of the paper's parking lots lead to.
PlotArea RegionOfInterest(double angle_error) {
  PlotArea region{{}, "", "#0d47a1", 0.55};
  region.label =
      fmt::format("psi {} to {} deg, rho/L {} to {}", kRegionPsi[0], kRegionPsi[1], kRegionRatio[0], kRegionRatio[1]);
  const auto add = [&](double psi, double ratio) {
    region.outline.emplace_back(psi, ErrorRatio(psi * kDeg, ratio, angle_error));
  };
  for (double psi = kRegionPsi[0]; psi <= kRegionPsi[1] + 1e-9; psi += 0.1) add(psi, kRegionRatio[1]);
  for (double psi = kRegionPsi[1]; psi >= kRegionPsi[0] - 1e-9; psi -= 0.1) add(psi, kRegionRatio[0]);
  return region;
}

// Turning angle and travel of the synthetic drive, where the paper has its parking lot.
PlotPanel DrivePanel(bool travel) {
  const PaperDriveOptions drive;
  PlotPanel panel;
  panel.title = travel ? "(a) travel of the synthetic drive" : "(a) turning angle of the synthetic drive";
  panel.x_label = "time [s]";
  panel.y_label = travel ? "rho/L" : "psi [deg]";
  panel.legend = false;
  if (travel) panel.y = PlotRange{0, 1};
  PlotLine line;
  line.color = "#1565c0";
  for (const AckermannStep& step : PaperDriveSteps(drive)) {
    line.points.emplace_back(static_cast<double>(line.points.size()) / drive.rate_hz,
                             travel ? step.rho / drive.lever_arm : step.psi * kDegreesPerRadian);
  }
  panel.lines.push_back(line);
  return panel;
}

}  // namespace

LabResult LabFigure4() {
  LabResult result;
  Figure figure{"Fig. 4 (b): turning angle psi and direction of travel theta (23)", "", 2, 420, 320, {}};
  PlotPanel angles;
  angles.title = "theta over psi";
  angles.x_label = "psi [deg]";
  angles.y_label = "theta [deg]";
  angles.x = PlotRange{0, kMostPsi};
  angles.legend = false;
  PlotPanel ratios = angles;
  ratios.title = "theta / psi tends to 1/2";
  ratios.y_label = "theta / psi";
  ratios.legend = true;
  LabJson at_five = LabJson::array();
  for (const double ratio : {0.1, 0.2, 0.4, 1.0, 4.0, 100.0}) {
    const std::string color = ScaleColor(std::log10(ratio / 0.1) / 3);
    const auto theta = [ratio](double psi) { return DirectionOfTravel({psi, ratio}, 1) * kDegreesPerRadian; };
    angles.lines.push_back({CurveOverPsi(0, theta), RatioLabel(ratio), color});
    ratios.lines.push_back({CurveOverPsi(0.1, [&](double psi) { return theta(psi) / (psi * kDegreesPerRadian); }),
                            RatioLabel(ratio), color});
    at_five.push_back({{"travel_ratio", ratio}, {"theta_over_psi_at_5_deg", Rounded(theta(5 * kDeg) / 5)}});
  }
  figure.panels = {angles, ratios};
  result.figures.emplace_back("fig4b", figure);
  result.values["theta_over_psi"] = at_five;
  return result;
}

LabResult LabFigure6() {
  LabResult result;
  Figure figure{"Fig. 6: sensitivity of the scale observer to noise (31)",
                "Solid: correct; dashed: as printed in (31), half of the correct value for psi, the same for theta.",
                2,
                420,
                340,
                {}};
  PlotPanel by_psi;
  by_psi.title = "(a) with respect to psi";
  by_psi.x_label = "psi [deg]";
  by_psi.y_label = "|ds'/dpsi| [1/rad]";
  by_psi.x = PlotRange{0, kMostPsi};
  by_psi.y = PlotRange{0, 30};
  by_psi.legend = false;
  PlotPanel by_theta = by_psi;
  by_theta.title = "(b) with respect to theta";
  by_theta.y_label = "|ds'/dtheta| [1/rad]";
  by_theta.legend = true;
  for (const double ratio : kTravelRatios) {
    const std::string color = RatioColor(ratio);
    const auto curve = [&](double ScaleSensitivity::*which, auto sensitivity) {
      return CurveOverPsi(0.1, [&](double psi) { return std::abs(sensitivity(psi, ratio).*which); });
    };
    by_psi.lines.push_back({curve(&ScaleSensitivity::by_psi, SensitivityOfStep), RatioLabel(ratio), color});
    by_psi.lines.push_back({curve(&ScaleSensitivity::by_psi, PrintedSensitivityOfStep), "", color, 1.4, "5 4"});
    by_theta.lines.push_back({curve(&ScaleSensitivity::by_theta, SensitivityOfStep), RatioLabel(ratio), color});
    by_theta.lines.push_back({curve(&ScaleSensitivity::by_theta, PrintedSensitivityOfStep), "", color, 1.4, "5 4"});
  }
  figure.panels = {by_psi, by_theta};
  result.figures.emplace_back("fig6", figure);

  // The paper's example: psi = 5 deg, rho = 0.4 m, L = 1 m, angles off by 0.1 deg.
  const ScaleSensitivity right = SensitivityOfStep(5 * kDeg, 0.4);
  const ScaleSensitivity printed = PrintedSensitivityOfStep(5 * kDeg, 0.4);
  const double distance = CameraDistance({5 * kDeg, 0.4}, 1);
  result.values["example"] = {
      {"psi_deg", 5},
      {"travel_ratio", 0.4},
      {"angle_error_deg", 0.1},
      {"by_psi", Rounded(right.by_psi)},
      {"by_psi_printed", Rounded(printed.by_psi)},
      {"by_theta", Rounded(right.by_theta)},
      {"by_theta_printed", Rounded(printed.by_theta)},
      {"scale_error", Rounded(distance * ScaleErrorRatio(5 * kDeg, 0.4, 0.1 * kDeg, right))},
      {"scale_error_printed", Rounded(distance * ScaleErrorRatio(5 * kDeg, 0.4, 0.1 * kDeg, printed))},
      {"paper_scale_error", kPaperExampleError}};
  return result;
}

LabResult LabFigure7() {
  LabResult result;
  Figure figure{"Fig. 7: turning angle, travel, and the error of the scale (32)",
                "",
                2,
                420,
                280,
                {DrivePanel(false), DrivePanel(true)}};
  for (const double error : kAngleErrors) {
    PlotPanel panel;
    panel.title = fmt::format("({}) both angles off by {:g} deg", error == kAngleErrors.front() ? 'b' : 'c', error);
    panel.x_label = "psi [deg]";
    panel.y_label = "error over scale [%]";
    panel.x = PlotRange{1, 8};
    panel.y = PlotRange{0, 10};
    panel.areas.push_back(RegionOfInterest(error * kDeg));
    for (const double ratio : kTravelRatios) {
      panel.lines.push_back({CurveOverPsi(0.5, [&](double psi) { return ErrorRatio(psi, ratio, error * kDeg); }),
                             RatioLabel(ratio), RatioColor(ratio)});
    }
    panel.lines.push_back({{{1, kPaperWorstError}, {8, kPaperWorstError}}, "paper: at worst", "#c2185b", 1.4, "6 4"});
    panel.lines.push_back({{{1, kPaperMeanError}, {8, kPaperMeanError}}, "paper: in average", "#c2185b", 1.4, "2 3"});
    figure.panels.push_back(panel);
  }
  result.figures.emplace_back("fig7", figure);
  for (const double error : kAngleErrors) {
    const RegionError right = ErrorOverRegion(error * kDeg, false);
    const RegionError printed = ErrorOverRegion(error * kDeg, true);
    result.values["region"].push_back({{"angle_error_deg", error},
                                       {"mean_percent", Rounded(100 * right.mean)},
                                       {"worst_percent", Rounded(100 * right.worst)},
                                       {"mean_percent_printed", Rounded(100 * printed.mean)},
                                       {"worst_percent_printed", Rounded(100 * printed.worst)}});
  }
  result.values["paper"] = {{"mean_percent", kPaperMeanError}, {"worst_percent", kPaperWorstError}};
  return result;
}

}  // namespace turnscale
