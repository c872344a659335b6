// SPDX-License-Identifier: MIT
#include "rescale_report.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/escaped_text.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/turn_warning.h"

namespace turnscale {
namespace {

std::string PositiveCell(double value) { return value > 0 ? fmt::format("{:.6g}", value) : std::string(); }

// Lowest and highest of the drive.
std::pair<double, double> ScaleRange(const RescaleResult& result) {
  const auto [low, high] =
      std::minmax_element(result.poses.begin(), result.poses.end(),
                          [](const auto& a, const auto& b) { return a.metres_per_unit < b.metres_per_unit; });
  return {low->metres_per_unit, high->metres_per_unit};
}

std::pair<double, double> SigmaRange(const RescaleResult& result) {
  const auto [low, high] = std::minmax_element(result.poses.begin(), result.poses.end(),
                                               [](const auto& a, const auto& b) { return a.sigma < b.sigma; });
  return {low->sigma, high->sigma};
}

const std::vector<TurnEstimate>& TurnsOf(const RescaleResult& result) { return result.estimate->turns; }

auto UsedTurns(const RescaleResult& result) {
  return std::ranges::count_if(TurnsOf(result), [](const TurnEstimate& turn) { return turn.used; });
}

// All lengths of the page in its own units, about pixels.
constexpr double kWidth = 800;
constexpr double kPathHeight = 480;
constexpr double kChartHeight = 170;
constexpr double kMargin = 56;
constexpr double kHeading = 40;
constexpr std::size_t kMostPoints = 2000;  // of a curve
constexpr double kMostBand = 1;            // by how many bands a single turn may widen the chart
constexpr double kSpeedSeconds = 1;        // over which the speed is taken

constexpr auto kStyle =
    "text{font-family:sans-serif;font-size:13px;fill:#333}.title{font-size:15px;font-weight:bold}"
    "path{fill:none;stroke-linejoin:round}.path{stroke:#222;stroke-width:2}.turn{stroke:#c2185b;stroke-width:4}"
    ".band{fill:#c2185b;fill-opacity:.18}.scale{stroke:#c2185b;stroke-width:1.8}.frame{stroke:#999}"
    ".own{stroke:#222;stroke-width:1.5}.off{stroke:#999;stroke-width:1.5;stroke-dasharray:2 "
    "2}.speed{stroke:#1565c0;stroke-width:1.4}";

using Points = std::vector<Eigen::Vector2d>;

std::string Line(const char* style, const Points& points, bool closed = false) {
  if (points.empty()) return "";
  std::string text = fmt::format("<path class=\"{}\" d=\"M", style);
  for (const Eigen::Vector2d& point : points) text += fmt::format("{:.1f},{:.1f} ", point.x(), point.y());
  text.back() = closed ? 'Z' : '"';
  return text + (closed ? "\"/>\n" : "/>\n");
}

std::string Text(double x, double y, const std::string& text, const char* anchor = "start") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor, EscapedXml(text));
}

// Every so many, and the last.
std::vector<std::size_t> Thinned(std::size_t first, std::size_t last) {
  const std::size_t stride = (last - first) / kMostPoints + 1;
  std::vector<std::size_t> indices;
  for (std::size_t i = first; i < last; i += stride) indices.push_back(i);
  indices.push_back(last);
  return indices;
}

// Right and up on the page, in the world's axes: the drive as seen from above, however its world frame lies. Up is what
// the car has above it on the whole; the world's x axis goes to the right, or its z axis where x points up.
Eigen::Matrix<double, 2, 3> PageAxes(const RescaleResult& result) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const StampedPose& pose : result.metric) {
    up -= pose.world_from_camera.rotation * (result.vehicle_from_camera.conjugate() * Eigen::Vector3d::UnitY());
  }
  up.normalize();
  constexpr double kAlong = 0.9;
  const Eigen::Vector3d reference = std::abs(up.x()) < kAlong ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
  Eigen::Matrix<double, 2, 3> axes;
  axes.row(0) = (reference - reference.dot(up) * up).normalized();
  axes.row(1) = up.cross(Eigen::Vector3d(axes.row(0)));
  return axes;
}

class PathPanel {
 public:
  explicit PathPanel(const RescaleResult& result) : metric_(result.metric), axes_(PageAxes(result)) {
    for (std::size_t i = 0; i < metric_.size(); ++i) box_.extend(FromAbove(i));
    const Eigen::Vector2d size = box_.sizes().cwiseMax(1.0);
    scale_ = std::min((kWidth - 2 * kMargin) / size.x(), (kPathHeight - kMargin) / size.y());
  }

  Points Places(std::size_t first, std::size_t last) const {
    Points points;
    for (const std::size_t i : Thinned(first, last)) {
      const Eigen::Vector2d off = scale_ * (FromAbove(i) - box_.center());
      points.emplace_back(kWidth / 2 + off.x(), kHeading + kPathHeight / 2 - off.y());
    }
    return points;
  }

  std::string MetreBar() const {
    const double decade = std::pow(10, std::floor(std::log10(kWidth / 5 / scale_)));
    double metres = decade;
    for (const double factor : {2.0, 5.0}) {
      if (factor * decade * scale_ <= kWidth / 5) metres = factor * decade;
    }
    const double y = kHeading + kPathHeight - 8;
    return Line("own", {{kMargin, y}, {kMargin + metres * scale_, y}}) +
           Text(kMargin + metres * scale_ + 6, y + 4, fmt::format("{:g} m", metres));
  }

 private:
  Eigen::Vector2d FromAbove(std::size_t i) const { return axes_ * metric_[i].world_from_camera.translation; }

  const Trajectory& metric_;
  Eigen::Matrix<double, 2, 3> axes_;
  Eigen::AlignedBox2d box_;
  double scale_ = 1;
};

// A chart over the metres of the drive.
class Chart {
 public:
  Chart(double top, double length, double low, double high) : top_(top), length_(length), low_(low), high_(high) {}

  Eigen::Vector2d At(double along, double value) const {
    const double share = (std::clamp(value, low_, high_) - low_) / (high_ - low_);
    return {kMargin + (kWidth - 2 * kMargin) * along / length_, top_ + kChartHeight * (1 - share)};
  }

  std::string Frame(const std::string& what) const {
    std::string text = Line("frame", {At(0, low_), At(length_, low_), At(length_, high_), At(0, high_)}, true) +
                       Text(kMargin, top_ - 6, what);
    for (const double value : {low_, 0.5 * (low_ + high_), high_}) {
      text += Text(kMargin - 6, At(0, value).y() + 4, fmt::format("{:.3g}", value), "end");
    }
    return text + Text(kWidth - kMargin, top_ + kChartHeight + 16, fmt::format("{:.0f} m", length_), "end");
  }

 private:
  double top_;
  double length_;
  double low_;
  double high_;
};

std::vector<double> MetresAlong(const Trajectory& metric) {
  std::vector<double> along(metric.size(), 0);
  for (std::size_t i = 1; i < metric.size(); ++i) {
    along[i] =
        along[i - 1] + (metric[i].world_from_camera.translation - metric[i - 1].world_from_camera.translation).norm();
  }
  return along;
}

std::string ScaleChart(const RescaleResult& result, const std::vector<double>& along, double top) {
  double low = HUGE_VAL;
  double high = 0;
  for (const RescaledPose& scale : result.poses) {
    low = std::min(low, scale.metres_per_unit * std::exp(-2 * scale.sigma));
    high = std::max(high, scale.metres_per_unit * std::exp(2 * scale.sigma));
  }
  const double most = kMostBand * (high - low);
  const double lowest = low - most;
  const double highest = high + most;
  for (const TurnEstimate& turn : result.estimate->turns) {
    if (!turn.used || !(turn.own > 0)) continue;
    low = std::max(lowest, std::min(low, turn.own * std::exp(-turn.own_sigma)));
    high = std::min(highest, std::max(high, turn.own * std::exp(turn.own_sigma)));
  }
  const Chart chart(top, std::max(along.back(), 1.0), low, high);
  const std::vector<std::size_t> shown = Thinned(0, result.poses.size() - 1);
  Points line;
  Points band;
  Points lower;
  for (const std::size_t i : shown) {
    const RescaledPose& scale = result.poses[i];
    line.push_back(chart.At(along[i], scale.metres_per_unit));
    band.push_back(chart.At(along[i], scale.metres_per_unit * std::exp(scale.sigma)));
    lower.push_back(chart.At(along[i], scale.metres_per_unit * std::exp(-scale.sigma)));
  }
  // Forth along the upper edge, back along the lower one.
  band.insert(band.end(), lower.rbegin(), lower.rend());
  std::string text = chart.Frame("metres per unit, +- 1 sigma; bars: single-turn scales");
  text += Line("band", band, true) + Line("scale", line);
  for (const TurnEstimate& turn : result.estimate->turns) {
    if (!(turn.own > 0)) continue;
    const double middle = 0.5 * (along[result.steps[turn.first_step].first] + along[result.steps[turn.last_step].last]);
    text += Line(turn.used ? "own" : "off", {chart.At(middle, turn.own * std::exp(-turn.own_sigma)),
                                             chart.At(middle, turn.own * std::exp(turn.own_sigma))});
  }
  return text;
}

std::string SpeedChart(const RescaleResult& result, const std::vector<double>& along, double top) {
  std::vector<std::pair<double, double>> speeds;
  double high = 1;
  std::size_t first = 0;
  for (std::size_t i = 1; i < along.size(); ++i) {
    const double seconds = result.metric[i].time - result.metric[first].time;
    if (seconds < kSpeedSeconds) continue;
    speeds.emplace_back(along[i], (along[i] - along[first]) / seconds);
    high = std::max(high, speeds.back().second);
    first = i;
  }
  const Chart chart(top, std::max(along.back(), 1.0), 0, std::ceil(high / 5) * 5);
  Points line;
  if (!speeds.empty()) {
    for (const std::size_t i : Thinned(0, speeds.size() - 1))
      line.push_back(chart.At(speeds[i].first, speeds[i].second));
  }
  return chart.Frame("implied speed, m/s") + Line("speed", line);
}

}  // namespace

std::string PoseScaleTable(const RescaleResult& result) {
  std::string table = "pose,time,metres_per_unit,sigma_relative,filtered_metres_per_unit,filtered_sigma_relative\n";
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    const RescaledPose& scale = result.poses[i];
    fmt::format_to(std::back_inserter(table), "{},{:.6f},{:.9g},{:.6g},{},{}\n", i, result.metric[i].time,
                   scale.metres_per_unit, scale.sigma, PositiveCell(scale.filtered_metres_per_unit),
                   PositiveCell(scale.filtered_sigma));
  }
  return table;
}

std::string TurnScaleTable(const RescaleResult& result) {
  std::string table =
      "first_pose,last_pose,angle_deg,speed_mps,metres_per_unit,sigma_relative,smoothed_metres_per_unit,"
      "smoothed_sigma_relative,deviation_sigmas,effective_lever_arm_m,used,weight,reason\n";
  for (const TurnEstimate& turn : TurnsOf(result)) {
    fmt::format_to(std::back_inserter(table), "{},{},{:.4f},{},{},{},{:.9g},{:.6g},{:.3f},{},{},{:.4g},{}\n",
                   result.steps[turn.first_step].first, result.steps[turn.last_step].last,
                   turn.angle * kDegreesPerRadian, PositiveCell(turn.speed_units * turn.smoothed),
                   PositiveCell(turn.own), PositiveCell(turn.own_sigma), turn.smoothed, turn.smoothed_sigma,
                   turn.deviation, PositiveCell(turn.lever_arm_units * turn.smoothed), turn.used ? 1 : 0, turn.weight,
                   turn.reason.empty() ? "" : "\"" + turn.reason + "\"");
  }
  return table;
}

std::string RescaleJson(const RescaleResult& result, const std::string& input) {
  const auto [low, high] = ScaleRange(result);
  const auto [best, worst] = SigmaRange(result);
  const YawPitchRoll camera = YawPitchRollFromRotation(result.vehicle_from_camera);
  const ScaleEstimate& estimate = *result.estimate;
  const CarRefinement& car = estimate.car;
  const nlohmann::ordered_json json = {{"input", input},
                                       {"poses", result.poses.size()},
                                       {"length_m", result.length},
                                       {"length_sigma", estimate.length_sigma},
                                       {"metres_per_unit", {{"min", low}, {"max", high}}},
                                       {"sigma_relative", {{"min", best}, {"max", worst}}},
                                       {"turns", {{"found", TurnsOf(result).size()}, {"used", UsedTurns(result)}}},
                                       {"converged", estimate.converged},
                                       {"contradicted", estimate.test.contradicted},
                                       {"follows_single_turns", estimate.fell_back},
                                       {"camera_rotation",
                                        {{"yaw_deg", camera.yaw * kDegreesPerRadian},
                                         {"pitch_deg", camera.pitch * kDegreesPerRadian},
                                         {"roll_deg", camera.roll * kDegreesPerRadian}}},
                                       {"yaw_error_deg", car.yaw_error * kDegreesPerRadian},
                                       {"yaw_error_sigma_deg", car.yaw_error_sigma * kDegreesPerRadian},
                                       {"side_slip_s2pm", car.side_slip},
                                       {"side_slip_sigma_s2pm", car.side_slip_sigma},
                                       {"side_slip_at_bound", car.side_slip_at_bound}};
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string RescaleWarning(const RescaleResult& result) {
  const auto poses_of = [&](int index) {
    const TurnEstimate& turn = result.estimate->turns[index];
    return fmt::format("poses {}-{}", result.steps[turn.first_step].first, result.steps[turn.last_step].last);
  };
  return TurnWarning(*result.estimate, poses_of, "the timestamps and the lever arm");
}

std::string RescaleText(const RescaleResult& result) {
  const auto [low, high] = ScaleRange(result);
  const auto [best, worst] = SigmaRange(result);
  std::string text = fmt::format("scale         {:.5g} m per unit", low);
  if (high > low) text = fmt::format("scale         {:.5g} ... {:.5g} m per unit", low, high);
  text += worst - best > 0.0005 ? fmt::format(", +- {:.1f} ... {:.1f} %\n", 100 * best, 100 * worst)
                                : fmt::format(", +- {:.1f} %\n", 100 * best);
  const CarRefinement& car = result.estimate->car;
  text += fmt::format("path          {:.1f} m +- {:.1f} %, {} turns used of {}\n", result.length,
                      100 * result.estimate->length_sigma, UsedTurns(result), TurnsOf(result).size());
  const YawPitchRoll camera = YawPitchRollFromRotation(result.vehicle_from_camera);
  text += fmt::format("camera        yaw {:+.2f} +- {:.2f}, pitch {:+.2f}, roll {:+.2f} deg\n",
                      (camera.yaw + car.yaw_error) * kDegreesPerRadian, car.yaw_error_sigma * kDegreesPerRadian,
                      camera.pitch * kDegreesPerRadian, camera.roll * kDegreesPerRadian);
  if (car.side_slip_at_bound) {
    text += "side slip     0: the estimate would be negative; check the lever arm and the timestamps\n";
  } else if (car.side_slip_sigma > 0) {
    text += fmt::format("side slip     {:.4f} +- {:.4f} s^2/m\n", car.side_slip, car.side_slip_sigma);
  }
  return text;
}

std::string RescaleSvg(const RescaleResult& result, const std::string& title, bool timed) {
  const std::vector<double> along = MetresAlong(result.metric);
  const double chart_room = kChartHeight + kMargin;
  const double height = kHeading + kPathHeight + kMargin / 2 + (timed ? 2 : 1) * chart_room;
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\">\n<style>{2}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      kWidth, height, kStyle);
  text += Text(kMargin, 26, title);
  const PathPanel panel(result);
  text += Line("path", panel.Places(0, result.metric.size() - 1));
  for (const TurnEstimate& turn : result.estimate->turns)
    text += Line("turn", panel.Places(result.steps[turn.first_step].first, result.steps[turn.last_step].last));
  text += panel.MetreBar();
  const double top = kHeading + kPathHeight + kMargin / 2;
  text += ScaleChart(result, along, top);
  if (timed) text += SpeedChart(result, along, top + chart_room);
  return text + "</svg>\n";
}

}  // namespace turnscale
