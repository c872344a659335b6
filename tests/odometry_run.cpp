// SPDX-License-Identifier: MIT
#include "odometry_run.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/evaluation/association.h"
#include "turnscale/evaluation/evaluation.h"
#include "turnscale/odometry/odometry.h"

namespace turnscale {

OdometryRun RunOdometry(const OdometryOptions& options, const CameraModel& camera, const std::vector<cv::Mat>& images,
                        const std::vector<double>& times) {
  Odometry odometry(options, camera);
  OdometryRun run;
  for (size_t i = 0; i < images.size(); ++i)
    run.live.push_back(images[i].empty() ? odometry.ProcessUnreadable(times[i])
                                         : odometry.Process(images[i], times[i]));
  odometry.Finish();
  run.refined = odometry.RefinedFrames();
  run.scale = odometry.Refined();
  run.turns = run.scale.turns;
  run.lens_correction = odometry.lens().correction();
  run.map = odometry.map();
  run.mask = odometry.mask();
  run.upside_down = odometry.is_upside_down();
  run.mount_jumps = odometry.mount().jumps();
  return run;
}

OdometryRun RunOdometry(const OdometryOptions& options, const StreetDrive& drive) {
  return RunOdometry(options, drive.camera, drive.images, drive.times);
}

OdometryOptions StreetOptions() {
  OdometryOptions options;
  options.vehicle.lever_arm = kStreetLeverArm;
  options.vehicle.side_slip = 0;
  options.vehicle.side_slip_sigma = 0;
  return options;
}

bool AllPosed(const std::vector<FrameResult>& frames) {
  return std::ranges::all_of(frames, [](const FrameResult& frame) {
    return frame.world_from_camera && frame.world_from_camera->translation.allFinite() &&
           frame.world_from_camera->rotation.coeffs().allFinite();
  });
}

int Count(const std::vector<FrameResult>& frames, TrackingState state) {
  return static_cast<int>(
      std::ranges::count_if(frames, [state](const FrameResult& frame) { return frame.state == state; }));
}

RunErrors MeasureRun(const std::vector<FrameResult>& refined, const std::vector<RigidTransform>& truth) {
  PosePairs pairs;
  std::vector<Step> steps;
  int keyframe = -1;
  for (int i = 0; i < static_cast<int>(refined.size()); ++i) {
    pairs.push_back({i, i, refined[i].time, refined[i].world_from_camera.value(), truth.at(i)});
    if (!refined[i].keyframe) continue;
    if (keyframe >= 0 && !std::isnan(refined[i].psi)) steps.push_back({keyframe, i, refined[i].turning});
    keyframe = i;
  }
  RunErrors errors;
  errors.path_length = EstimatedPathLength(pairs) / TruePathLength(pairs) - 1;
  errors.psi_rms_deg = MeasureSteps(pairs, steps, true).psi.rms * kDegreesPerRadian;
  errors.position = MeasureAlignedPositions(pairs, AlignmentModel::kRigid).distance.max;
  errors.shape = MeasureAlignedPositions(pairs, AlignmentModel::kSimilarity).distance.max;
  return errors;
}

void ExpectMetres(const OdometryRun& run, const StreetDrive& drive) {
  ASSERT_TRUE(AllPosed(run.refined));
  const RunErrors errors = MeasureRun(run.refined, drive.world_from_camera);
  EXPECT_LT(std::abs(errors.path_length), 0.02);
  EXPECT_LT(errors.psi_rms_deg, 0.014);
  EXPECT_LT(errors.position, 0.45);
  ASSERT_TRUE(run.scale.estimate) << run.scale.reason;
  EXPECT_LT(std::abs(errors.path_length), run.scale.estimate->length_sigma);
}

}  // namespace turnscale
