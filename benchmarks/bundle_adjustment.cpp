// SPDX-License-Identifier: MIT
// Bundle adjustment beside Ceres on synthetic drives: time per iteration, iterations, peak memory. The recorded table
// is docs/bundle_adjustment.md.
#include "turnscale/bundle/bundle_adjustment.h"

#include <fstream>
#include <string>

#include <benchmark/benchmark.h>
#include <glog/logging.h>
#include <malloc.h>

#include "turnscale/bundle/ceres_reference.h"
#include "turnscale/bundle/synthetic_drive.h"

namespace turnscale {
namespace {

/// A line of /proc/self/status in megabytes.
double StatusMegabytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0;
    if (word == name && status >> kilobytes) return kilobytes / 1024;
  }
  return 0;
}

/// Peak memory since its construction, less what was in use then (the problem itself).
class PeakMemory {
 public:
  PeakMemory() {
    // Freed memory goes back to the system first, so that it is counted when it is used again; Linux then forgets the
    // peak so far.
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << 5;
    before_ = StatusMegabytes("VmRSS:");
  }
  double Megabytes() const { return StatusMegabytes("VmHWM:") - before_; }

 private:
  double before_;
};

SyntheticDriveOptions LongDrive(int points) {
  SyntheticDriveOptions options;
  options.cameras = 300;
  options.points = points;
  options.observations = points * 20 / 3;
  return options;
}

/// The absolute scale recovery's problem: everything 10 % too large, centres 2 cm and depths 2 % off.
BundleProblem TooLarge(const SyntheticDrive& drive, int distances) {
  BundleProblem problem = drive.truth;
  problem.distances = TurnDistances(drive, distances);
  Disturb(0.02, 0, 0.02, 2, problem);
  DriftScale(1.1, 1.1, problem);
  return problem;
}

void Record(benchmark::State& state, const BundleProblem& problem, int iterations, double cost, double megabytes) {
  state.counters["observations"] = static_cast<double>(problem.observations.size());
  state.counters["iterations"] = iterations;
  state.counters["final_cost"] = cost;
  state.counters["peak_MB"] = megabytes;
  using benchmark::Counter;
  state.counters["s_per_iteration"] = Counter(iterations, Counter::kIsIterationInvariantRate | Counter::kInvert);
}

void RunOurs(benchmark::State& state, const BundleOptions& options, const BundleProblem& start) {
  BundleSummary summary;
  double megabytes = 0;
  while (state.KeepRunning()) {
    state.PauseTiming();
    BundleProblem problem = start;
    const PeakMemory memory;
    state.ResumeTiming();
    summary = AdjustBundle(options, problem);
    state.PauseTiming();
    megabytes = memory.Megabytes();
    state.ResumeTiming();
  }
  Record(state, start, summary.iterations, summary.final_cost, megabytes);
  state.counters["kkt"] = summary.kkt_residual;
  state.counters["distance_error"] = summary.constraint_residual;
}

void RunCeres(benchmark::State& state, const BundleOptions& options, const BundleProblem& start) {
  ceres::Solver::Summary summary;
  double megabytes = 0;
  while (state.KeepRunning()) {
    state.PauseTiming();
    BundleProblem problem = start;
    const PeakMemory memory;
    ceres::Solver::Options ceres_options;
    ceres_options.max_num_iterations = options.max_iterations;
    ceres_options.function_tolerance = options.relative_cost_tolerance;
    state.ResumeTiming();
    summary = AdjustWithCeres(options, ceres_options, problem);
    state.PauseTiming();
    megabytes = memory.Megabytes();
    state.ResumeTiming();
  }
  Record(state, start, summary.num_successful_steps + summary.num_unsuccessful_steps, summary.final_cost, megabytes);
}

BundleProblem Window() {
  SyntheticDriveOptions options;
  options.turn_every = 5;
  options.turn_length = 3;
  BundleProblem problem = MakeSyntheticDrive(options).truth;
  problem.camera_is_fixed[1] = 1;
  Disturb(0.05, 0.003, 0.05, 2, problem);
  return problem;
}

/// Every keyframe of a drive waits for this one.
void LocalWindow(benchmark::State& state) { RunOurs(state, {}, Window()); }
void LocalWindowCeres(benchmark::State& state) { RunCeres(state, {}, Window()); }

BundleOptions RecoveryOptions() {
  BundleOptions options;
  options.fix_rotations = true;
  options.max_iterations = 50;
  options.relative_cost_tolerance = 0;
  options.kkt_tolerance = 1e-8;
  return options;
}

void ScaleRecovery(benchmark::State& state) {
  RunOurs(state, RecoveryOptions(), TooLarge(MakeSyntheticDrive(LongDrive(30000)), 40));
}

/// The argument: 1 for fixed rotations.
void WithoutConstraints(benchmark::State& state) {
  BundleOptions options;
  options.fix_rotations = state.range(0) != 0;
  RunOurs(state, options, TooLarge(MakeSyntheticDrive(LongDrive(30000)), 0));
}

void WithoutConstraintsCeres(benchmark::State& state) {
  BundleOptions options;
  options.fix_rotations = state.range(0) != 0;
  RunCeres(state, options, TooLarge(MakeSyntheticDrive(LongDrive(30000)), 0));
}

/// Five iterations, so that only the cost of one is compared.
void ByLandmarks(benchmark::State& state) {
  BundleOptions options = RecoveryOptions();
  options.max_iterations = 5;
  RunOurs(state, options, TooLarge(MakeSyntheticDrive(LongDrive(static_cast<int>(state.range(0)))), 40));
  state.SetComplexityN(state.range(0));
}

BENCHMARK(LocalWindow)->Unit(benchmark::kMillisecond);
BENCHMARK(LocalWindowCeres)->Unit(benchmark::kMillisecond);
BENCHMARK(ScaleRecovery)->Unit(benchmark::kMillisecond)->Iterations(5);
BENCHMARK(WithoutConstraints)->ArgName("rotations_fixed")->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond)->Iterations(3);
BENCHMARK(WithoutConstraintsCeres)
    ->ArgName("rotations_fixed")
    ->Arg(1)
    ->Arg(0)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);
BENCHMARK(ByLandmarks)
    ->RangeMultiplier(2)
    ->Range(7500, 120000)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(3)
    ->Complexity(benchmark::oN);

}  // namespace
}  // namespace turnscale

int main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
