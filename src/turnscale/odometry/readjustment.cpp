// SPDX-License-Identifier: MIT
#include "turnscale/odometry/readjustment.h"

#include <algorithm>
#include <utility>

namespace turnscale {

ReadjustmentWork WorkToReadjust(const LocalBundleOptions& options, const Map& map, const MountCalibration& mount,
                                int first) {
  ReadjustmentWork work{.radial_correction = map.camera.radial_correction,
                        .first = first,
                        .end = CountKeyframes(map),
                        .window = MakeLocalWindow(options, first, map),
                        .mount = mount,
                        .unlearned = {}};
  for (int k = mount.next_keyframe(); k < work.end; ++k) {
    const Keyframe& keyframe = map.keyframes[k];
    work.unlearned.push_back({.frame = keyframe.frame,
                              .time = keyframe.time,
                              .camera_from_world = keyframe.camera_from_world,
                              .observations = {},
                              .after_gap = keyframe.after_gap,
                              .gap_sigma = keyframe.gap_sigma});
  }
  return work;
}

ReadjustmentResult Readjusted(const LocalBundleOptions& options, ReadjustmentWork work) {
  ReadjustmentResult result{.radial_correction = work.radial_correction,
                            .first = work.first,
                            .end = work.end,
                            .window = std::nullopt,
                            .mount = std::move(work.mount)};
  if (AdjustWindow(options, work.window)) {
    const int first_adjusted = work.window.window.first;
    const int first_unlearned = result.mount.next_keyframe();
    for (int k = std::max(first_adjusted, first_unlearned); k < work.end; ++k)
      work.unlearned[k - first_unlearned].camera_from_world = work.window.bundle.camera_from_world[k - first_adjusted];
    result.window = std::move(work.window);
  }
  result.mount.Learn(work.unlearned);
  return result;
}

}  // namespace turnscale
