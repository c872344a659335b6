// SPDX-License-Identifier: MIT
// How fast images of simulated drives are drawn, sensor and files apart.
#include <utility>

#include <benchmark/benchmark.h>

#include "turnscale/rendering/renderer.h"
#include "turnscale/simulation/drive.h"
#include "turnscale/simulation/rig.h"
#include "turnscale/simulation/world.h"

namespace turnscale {
namespace {

constexpr unsigned kSeed = 1;
constexpr int kImages = 12;

// Images evenly over a drive, by so many threads.
void DrawDrive(benchmark::State& state, World world, const Rig& rig) {
  const CameraDrive drive(world, rig, kSeed);
  RenderOptions options;
  options.threads = static_cast<int>(state.range(0));
  const Renderer renderer(options, std::move(world.scene));
  // Lenses are inverted once for all images.
  renderer.Render(rig.camera, drive.ViewAt(0));
  int image = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(renderer.Render(rig.camera, drive.ViewAt(image * drive.frames() / kImages)));
    image = (image + 1) % kImages;
  }
  state.counters["images"] = benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

void Garage(benchmark::State& state) { DrawDrive(state, MakeGarage(kSeed, 60), MakeRig(RigPreset::kPaper)); }

void Street(benchmark::State& state) { DrawDrive(state, MakeStreet(kSeed, 60), MakeRig(RigPreset::kPaper)); }

void StreetAsKittiSeesIt(benchmark::State& state) {
  DrawDrive(state, MakeStreet(kSeed, 60), MakeRig(RigPreset::kKitti));
}

void GarageWithMotionBlur(benchmark::State& state) {
  Rig rig = MakeRig(RigPreset::kPaper);
  rig.sensor.exposure_ms = 5;
  DrawDrive(state, MakeGarage(kSeed, 60), rig);
}

void ByThreads(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("threads")->Arg(1)->Arg(2)->UseRealTime()->MeasureProcessCPUTime();
  benchmark->Iterations(2 * kImages)->Unit(benchmark::kMillisecond);
}

BENCHMARK(Garage)->Apply(ByThreads);
BENCHMARK(Street)->Apply(ByThreads);
BENCHMARK(StreetAsKittiSeesIt)->Apply(ByThreads);
BENCHMARK(GarageWithMotionBlur)->Apply(ByThreads);

}  // namespace
}  // namespace turnscale

BENCHMARK_MAIN();
