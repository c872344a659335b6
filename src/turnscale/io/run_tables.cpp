// SPDX-License-Identifier: MIT
#include "turnscale/io/run_tables.h"

#include <cmath>

#include <fmt/format.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/io/progress.h"

namespace turnscale {
namespace {

std::string DegreesCell(double radians) {
  return std::isnan(radians) ? std::string() : fmt::format("{:.6f}", radians * kDegreesPerRadian);
}

// Reasons are free text: quoted, as commas would part them.
std::string QuotedCell(const std::string& text) {
  if (text.empty()) return {};
  std::string quoted(1, '"');
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  return quoted.append(1, '"');
}

}  // namespace

std::string FrameTableHeader() {
  return "frame,time,state,x,y,z,qx,qy,qz,qw,scale_state,scale_sigma,inliers,tracked,keyframe,psi_deg,theta_deg,"
         "turning\n";
}

std::string FrameTableLine(const FrameResult& frame, const std::optional<RigidTransform>& pose) {
  std::string cells = ",,,,,,";
  if (pose) {
    const Eigen::Vector3d& t = pose->translation;
    const Eigen::Quaterniond& q = pose->rotation;
    cells = fmt::format("{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}", t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
                        q.w());
  }
  return fmt::format("{},{:.6f},{},{},{},{:.6g},{},{},{},{},{},{}\n", frame.frame, frame.time,
                     TrackingStateName(frame.state), cells, ScaleStateName(frame.scale_state), frame.scale_sigma,
                     frame.inliers, frame.tracked, frame.keyframe ? 1 : 0, DegreesCell(frame.psi),
                     DegreesCell(frame.theta), frame.turning ? 1 : 0);
}

std::string TurnTable(const std::vector<TurnResult>& turns) {
  std::string table =
      "first_frame,last_frame,keyframes,angle_deg,speed_mps,metres_per_unit,sigma,smoothed_metres_per_unit,"
      "smoothed_sigma,deviation_sigmas,effective_lever_arm_m,used,reason,unadjusted\n";
  for (const TurnResult& turn : turns) {
    // A turn that says nothing leaves its cells empty.
    const auto positive = [](double value, int digits) {
      return value > 0 ? fmt::format("{:.{}g}", value, digits) : std::string();
    };
    table += fmt::format(
        "{},{},{},{:.4f},{},{},{},{},{},{},{},{},{},{}\n", turn.first_frame, turn.last_frame,
        turn.last_keyframe - turn.first_keyframe + 1, turn.angle * kDegreesPerRadian, positive(turn.speed, 5),
        positive(turn.metres_per_unit, 9), positive(turn.sigma, 6), positive(turn.smoothed, 9),
        positive(turn.smoothed_sigma, 6), turn.used ? fmt::format("{:.3f}", turn.deviation) : std::string(),
        positive(turn.effective_lever_arm, 6), turn.used ? 1 : 0, QuotedCell(turn.reason), QuotedCell(turn.unadjusted));
  }
  return table;
}

}  // namespace turnscale
