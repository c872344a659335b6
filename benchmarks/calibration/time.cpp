// SPDX-License-Identifier: MIT
// Time of the calibration against the number of steps: linear, refined, and online per step.
#include <benchmark/benchmark.h>

#include "turnscale/calibration/linear_calibration.h"
#include "turnscale/calibration/online_calibration.h"
#include "turnscale/laboratory/calibration_trials.h"

namespace turnscale {
namespace {

// Noisy frame motions, each a step of its own: the most work for so many frames.
std::vector<CameraStep> Frames(int count) {
  const PaperDriveOptions drive = PaperCalibrationDrive();
  const std::vector<AckermannStep> round = PaperDriveSteps(drive);
  std::vector<AckermannStep> way;
  // Begun shortly before the first turn, so that a short drive has one; then round after round.
  constexpr size_t kBegin = 260;
  for (size_t i = kBegin; way.size() < static_cast<size_t>(count); ++i) way.push_back(round[i % round.size()]);
  const Trajectory path = NoisyCameraPath(way, drive, {0.002, 0.002, 1});
  std::vector<CameraStep> steps;
  for (size_t i = 1; i < path.size(); ++i) {
    steps.push_back(
        {path[i - 1].world_from_camera.inverse() * path[i].world_from_camera, 1, path[i - 1].time, path[i].time});
  }
  return steps;
}

void Linear(benchmark::State& state) {
  const auto steps = Frames(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    LinearCalibration linear;
    for (const CameraStep& step : steps) {
      linear.Add(step.previous_from_current,
                 TurningAngle(step.previous_from_current.rotation, Eigen::Vector3d::UnitY()));
    }
    benchmark::DoNotOptimize(linear.Solve());
  }
  state.SetComplexityN(state.range(0));
}

void RefineAll(benchmark::State& state) {
  const auto steps = Frames(static_cast<int>(state.range(0)));
  int iterations = 0;
  for (auto _ : state) iterations = Calibrate(steps).refinement.iterations;
  state.counters["iterations"] = iterations;
  state.SetComplexityN(state.range(0));
}

void OnlinePerStep(benchmark::State& state) {
  const auto steps = Frames(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    OnlineCalibration online;
    for (const CameraStep& step : steps) benchmark::DoNotOptimize(online.Add(step));
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

BENCHMARK(Linear)->RangeMultiplier(10)->Range(100, 100000)->Unit(benchmark::kMillisecond)->Complexity();
BENCHMARK(RefineAll)->RangeMultiplier(10)->Range(100, 100000)->Unit(benchmark::kMillisecond)->Complexity();
BENCHMARK(OnlinePerStep)->RangeMultiplier(10)->Range(100, 10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace turnscale

BENCHMARK_MAIN();
