// SPDX-License-Identifier: MIT
// Does the cost of a frame grow with the drive? Renders a lap that closes on itself, or the pieces of a long straight,
// drives it for as many frames as wanted, and prints what each minute took, as JSON.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>
#include <time.h>

#include "../tests/street_world.h"
#include "turnscale/base/error.h"
#include "turnscale/frames/frame_reader.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/image_file/image_encoder.h"
#include "turnscale/io/output_file.h"
#include "turnscale/odometry/odometry.h"

namespace turnscale {
namespace {

constexpr double kInterval = 0.1;  // seconds
constexpr double kFramesPerMinute = 60 / kInterval;
constexpr double kLeverArm = 1.5;      // metres
constexpr double kCameraHeight = 1.5;  // metres
constexpr double kRadius = 9;          // of corners, metres
constexpr double kHalfStreet = 6;      // metres
constexpr double kStep = 0.8192;       // metres a frame: 25 steps are a period of the walls' texture
constexpr int kPeriod = 25;
constexpr double kCornerStep = 0.5;  // metres a frame
constexpr double kBraking = 20;      // metres before and after a corner
constexpr double kFarSight = 800;    // metres from which the end of a street is a few pixels
constexpr double kNoise = 1.5;       // gray levels
const CameraModel kCamera{.pinhole = {718.856, 718.856, 607.193, 185.216}, .width = 1226, .height = 370};

/// A piece of the rear axle's way.
struct Arc {
  double length = 0;     ///< metres
  double curvature = 0;  ///< rad/m, positive to the right
};
using Route = std::vector<Arc>;

Route Straight(double length) { return {{length, 0}}; }
Route Corner(double direction) { return {{kRadius * M_PI / 2, direction / kRadius}}; }

Route Joined(const std::vector<Route>& parts) {
  Route all;
  for (const Route& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

double Length(const Route& route) {
  double length = 0;
  for (const Arc& arc : route) length += arc.length;
  return length;
}

RigidTransform VehicleAt(const Route& route, double s) {
  RigidTransform world_from_vehicle;
  for (const Arc& arc : route) {
    const double part = std::min(s, arc.length);
    const double psi = part * arc.curvature;
    const Eigen::Vector3d moved = arc.curvature == 0
                                      ? Eigen::Vector3d(0, 0, part)
                                      : Eigen::Vector3d(1 - std::cos(psi), 0, std::sin(psi)) / arc.curvature;
    world_from_vehicle = world_from_vehicle * RigidTransform{RotationFromVector({0, psi, 0}), moved};
    s -= part;
    if (s <= 0) break;
  }
  return world_from_vehicle;
}

// Metres to the nearest corner.
double CornerAhead(const Route& route, double s) {
  double nearest = HUGE_VAL;
  double begin = 0;
  for (const Arc& arc : route) {
    if (arc.curvature != 0) nearest = std::min(nearest, std::max({0.0, begin - s, s - begin - arc.length}));
    begin += arc.length;
  }
  return nearest;
}

double StepAt(const Route& route, double s) {
  return kCornerStep + (kStep - kCornerStep) * std::min(1.0, CornerAhead(route, s) / kBraking);
}

/// Frames of a drive: where the rear axle is, and which image shows it.
struct Drive {
  std::vector<double> places;     ///< along the route, of each image
  std::vector<int> images;        ///< of each frame
  std::vector<double> travelled;  ///< by the rear axle, of each frame, metres
};

// The closed route again and again.
Drive Laps(const Route& route, int frames) {
  Drive drive;
  const double lap = Length(route);
  double s = 0;
  for (; s < lap; s += StepAt(route, s)) drive.places.push_back(s);
  // The last step closes the lap.
  for (double& place : drive.places) place *= lap / s;
  const int images = static_cast<int>(drive.places.size());
  for (int i = 0; i < frames; ++i) {
    drive.images.push_back(i % images);
    const int laps = i / images;
    drive.travelled.push_back(lap * laps + drive.places[i % images]);
  }
  return drive;
}

// A route whose long straight looks the same after every period, away from its ends.
Drive Once(const Route& route) {
  Drive drive;
  std::vector<int> latest;
  for (double s = 0; s < Length(route); s += StepAt(route, s)) {
    drive.travelled.push_back(s);
    if (latest.size() >= kPeriod && CornerAhead(route, s) > kFarSight) {
      drive.images.push_back(latest[latest.size() - kPeriod]);
    } else {
      drive.images.push_back(static_cast<int>(drive.places.size()));
      drive.places.push_back(s);
    }
    latest.push_back(drive.images.back());
  }
  return drive;
}

// Boxes on both sides of a street, so that depth varies along the walls.
void AddBoxes(Eigen::Vector3d from, const Eigen::Vector3d& to, std::vector<Block>& blocks) {
  const Eigen::Vector3d along = (to - from).normalized();
  const Eigen::Vector3d right(along.z(), 0, -along.x());
  int i = 0;
  for (double s = 14; s < (to - from).norm() - 14; s += 9, ++i) {
    const double side = i % 2 == 0 ? 4.9 : -5.0;
    const Eigen::Vector3d a = from + s * along + (side - 0.5) * right;
    const Eigen::Vector3d b = a + 2.0 * along + 1.0 * right;
    const double high = 0.9 + 0.6 * (i % 3);
    blocks.push_back(
        {{std::min(a.x(), b.x()), -high, std::min(a.z(), b.z())}, {std::max(a.x(), b.x()), 0, std::max(a.z(), b.z())}});
  }
}

struct Place {
  Route route;
  std::vector<Block> blocks;
};

// Five corners to the right and one to the left around two blocks of houses, 120 m at most.
Place Lap() {
  const double r = kRadius;
  Place place;
  place.route = Joined({Straight(60 - r), Corner(1), Straight(60 - 2 * r), Corner(1), Straight(60 - 2 * r), Corner(-1),
                        Straight(60 - 2 * r), Corner(1), Straight(60 - 2 * r), Corner(1), Straight(120 - 2 * r),
                        Corner(1), Straight(60 - r)});
  const double h = kHalfStreet;
  // The start is at x = 0, z = 0, half-way along the first street.
  place.blocks = {{{h, -9, -60 + h}, {60 - h, 0, 60 - h}}, {{60 - h, -7, -60 + h}, {120 - h, 0, -h}},
                  {{-40, -8, -100}, {-h, 0, 100}},         {{-40, -10, 60 + h}, {100, 0, 100}},
                  {{60 + h, -8, h}, {160, 0, 100}},        {{120 + h, -9, -100}, {160, 0, h}},
                  {{-40, -7, -100}, {160, 0, -60 - h}}};
  const std::vector<Eigen::Vector3d> corners = {{0, 0, -60}, {0, 0, 60},    {60, 0, 60}, {60, 0, 0},
                                                {120, 0, 0}, {120, 0, -60}, {0, 0, -60}};
  for (size_t i = 1; i < corners.size(); ++i) AddBoxes(corners[i - 1], corners[i], place.blocks);
  return place;
}

// A corner, a long street, a corner.
Place LongStreet(double length) {
  const double h = kHalfStreet;
  const double r = kRadius;
  Place place;
  place.route = Joined({Straight(60 - r), Corner(1), Straight(length - 2 * r), Corner(1), Straight(60 - r)});
  place.blocks = {{{-40, -8, -60}, {-h, 0, 100}},
                  {{-h, -9, 60 + h}, {length + 60, 0, 100}},
                  {{h, -7, -60}, {length - h, 0, 60 - h}},
                  {{length + h, -8, -60}, {length + 60, 0, 60 + h}},
                  {{-h, -8, -60}, {h, 0, -50}},
                  {{length - h, -10, -60}, {length + h, 0, -50}}};
  return place;
}

std::string ImageFile(const std::filesystem::path& folder, int image) {
  return (folder / fmt::format("{:06}.png", image)).string();
}

RigidTransform CameraAt(const Route& route, double s) {
  return VehicleAt(route, s) * RigidTransform{Eigen::Quaterniond::Identity(), {0, -kCameraHeight, kLeverArm}};
}

void RenderImages(const Place& place, const Drive& drive, const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / "complete")) return;
  std::filesystem::create_directories(folder);
  const StreetWorld world(place.blocks);
  const std::vector<Eigen::Vector3d> rays = PixelRays(kCamera);
  for (int i = 0; i < static_cast<int>(drive.places.size()); ++i) {
    const cv::Mat ideal = world.Render(kCamera, rays, CameraAt(place.route, drive.places[i]));
    cv::Mat noise(ideal.size(), CV_16S);
    cv::RNG random(1000 + i);
    random.fill(noise, cv::RNG::NORMAL, 0, kNoise);
    cv::Mat image;
    cv::add(ideal, noise, image, cv::noArray(), CV_8U);
    ReplaceFile(ImageFile(folder, i), EncodePng(image), Durability::kProcess);
    if (i % 100 == 0) fmt::print(stderr, "rendering: {} of {}\n", i, drive.places.size());
  }
  std::ofstream(folder / "complete");
}

double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double WallSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double PeakMegabytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0;
    if (word == "VmHWM:" && status >> kilobytes) return kilobytes / 1024;
  }
  return 0;
}

// Ratio of the refined path's length to the true one, from one frame to another.
double LengthRatio(const std::vector<FrameResult>& frames, const Route& route, const Drive& drive, int first,
                   int last) {
  double length = 0;
  double true_length = 0;
  for (int i = first + 1; i <= last; ++i) {
    length += (frames[i].world_from_camera->translation - frames[i - 1].world_from_camera->translation).norm();
    const double before = drive.places[drive.images[i - 1]];
    // Where an image comes back, the way since the one before is still the true one.
    const double step = drive.travelled[i] - drive.travelled[i - 1];
    true_length += (CameraAt(route, before + step).translation - CameraAt(route, before).translation).norm();
  }
  return length / true_length;
}

nlohmann::json Run(const Place& place, const Drive& drive, const std::filesystem::path& folder, int threads) {
  cv::setNumThreads(threads);
  OdometryOptions options;
  options.vehicle.lever_arm = kLeverArm;
  options.vehicle.side_slip = 0;
  options.vehicle.side_slip_sigma = 0.0005;
  Odometry odometry(options, kCamera);
  nlohmann::json minutes = nlohmann::json::array();
  double longest = 0;
  double longest_cpu = 0;
  double cpu = 0;
  double wall = 0;
  int tracked = 0;
  std::vector<double> latencies;
  const int frames = static_cast<int>(drive.images.size());
  double run_cpu = 0;
  for (int i = 0; i < frames; ++i) {
    const cv::Mat image = ReadGrayImage(ImageFile(folder, drive.images[i])).gray;
    const double cpu_before = CpuSeconds();
    const double wall_before = WallSeconds();
    const FrameResult result = odometry.Process(image, kInterval * i);
    const double latency = WallSeconds() - wall_before;
    latencies.push_back(latency);
    const double frame_cpu = CpuSeconds() - cpu_before;
    cpu += frame_cpu;
    longest_cpu = std::max(longest_cpu, frame_cpu);
    wall += latency;
    longest = std::max(longest, latency);
    tracked += result.state == TrackingState::kTracked ? 1 : 0;
    if ((i + 1) % static_cast<int>(kFramesPerMinute) != 0 && i + 1 < frames) continue;
    const int in_minute = i % static_cast<int>(kFramesPerMinute) + 1;
    minutes.push_back({{"frames", i + 1},
                       {"cpu_ms_per_frame", 1e3 * cpu / in_minute},
                       {"wall_ms_per_frame", 1e3 * wall / in_minute},
                       {"longest_ms", 1e3 * longest},
                       {"longest_cpu_ms", 1e3 * longest_cpu},
                       {"peak_memory_mb", PeakMegabytes()},
                       {"keyframes", odometry.map().keyframes.size()},
                       {"scale_sigma", result.scale_sigma}});
    run_cpu += cpu;
    fmt::print(stderr, "minute {}: {:.1f} ms of CPU per frame, longest {:.0f} ms, {:.0f} ms of CPU, {:.0f} MB\n",
               minutes.size(), 1e3 * cpu / in_minute, 1e3 * longest, 1e3 * longest_cpu, PeakMegabytes());
    cpu = wall = longest = longest_cpu = 0;
  }
  const double finish_before = CpuSeconds();
  const double finish_wall_before = WallSeconds();
  odometry.Finish();
  const std::vector<FrameResult> refined = odometry.RefinedFrames();
  const double finish = CpuSeconds() - finish_before;
  const double finish_wall = WallSeconds() - finish_wall_before;
  const size_t landmarks = odometry.RefinedMap().landmarks.size();
  const int part = std::min(frames - 1, static_cast<int>(drive.places.size()));
  std::ranges::sort(latencies);
  const auto quantile = [&](double share) {
    return 1e3 * latencies[static_cast<size_t>(share * static_cast<double>(latencies.size() - 1))];
  };
  return {{"frames", frames},
          {"images", drive.places.size()},
          {"tracked", tracked},
          {"minutes", minutes},
          {"latency_ms", {{"median", quantile(0.5)}, {"99 %", quantile(0.99)}, {"longest", quantile(1)}}},
          {"cpu_s", run_cpu},
          {"finish_cpu_s", finish},
          {"finish_wall_s", finish_wall},
          {"landmarks", landmarks},
          {"peak_memory_mb", PeakMegabytes()},
          {"length_ratio_first", LengthRatio(refined, place.route, drive, 0, part)},
          {"length_ratio_last", LengthRatio(refined, place.route, drive, frames - 1 - part, frames - 1)}};
}

}  // namespace
}  // namespace turnscale

int main(int argc, char** argv) {
  using namespace turnscale;
  CLI::App app("Drives for long, and prints what each minute took.");
  std::string what = "lap";
  std::filesystem::path work = "build/long_drives";
  int frames = 36000;
  int threads = 2;
  app.add_option("drive", what, "lap, or straight: a corner, a long street, a corner")
      ->check(CLI::IsMember({"lap", "straight"}));
  app.add_option("--frames", frames, "Of the lap, or of the long street")->check(CLI::PositiveNumber);
  app.add_option("--threads", threads, "Threads of image operations");
  app.add_option("--work", work, "Folder for the images");
  CLI11_PARSE(app, argc, argv);
  try {
    const bool is_lap = what == "lap";
    const Place place = is_lap ? Lap() : LongStreet(kStep * frames);
    const Drive drive = is_lap ? Laps(place.route, frames) : Once(place.route);
    const std::filesystem::path folder = work / (is_lap ? what : fmt::format("{}_{}", what, frames));
    RenderImages(place, drive, folder);
    std::cout << Run(place, drive, folder, threads).dump(2) << '\n';
  } catch (const std::exception& error) {
    fmt::print(stderr, "long_drives: {}\n", error.what());
    return 1;
  }
  return 0;
}
