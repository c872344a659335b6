// SPDX-License-Identifier: MIT
#include "turnscale/odometry/drive_speed.h"

#include <algorithm>
#include <cmath>

namespace turnscale {
std::vector<SpeedReading> SpeedsOf(const std::vector<FrameResult>& frames, double lever_arm) {
  const auto is_tracked = [](const FrameResult& frame) { return frame.state == TrackingState::kTracked; };
  const auto first = std::find_if(frames.begin(), frames.end(), is_tracked);
  std::vector<PathReading> readings;
  std::vector<double> scale_sigmas;
  double position = 0;
  for (auto frame = first; frame != frames.end(); ++frame) {
    if (!frame->world_from_camera || frame->scale_state == ScaleState::kPending) return {};
    if (frame != first) {
      const AxlePose before = RearAxle(*(frame - 1), lever_arm);
      const AxlePose now = RearAxle(*frame, lever_arm);
      position += (now.position - before.position).dot((before.forward + now.forward).normalized());
    }
    readings.push_back({frame->time, position, is_tracked(*frame)});
    scale_sigmas.push_back(frame->scale_sigma);
  }
  std::vector<SpeedReading> speeds = SmoothSpeed(readings);
  for (size_t i = 0; i < speeds.size(); ++i)
    speeds[i].sigma = std::hypot(speeds[i].sigma, speeds[i].speed * scale_sigmas[i]);
  return speeds;
}

}  // namespace turnscale
