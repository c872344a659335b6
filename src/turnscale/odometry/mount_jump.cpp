// SPDX-License-Identifier: MIT
#include "turnscale/odometry/mount_jump.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "turnscale/geometry/angle.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Frames are compared that are at least so far apart, seconds: between images that follow faster, noise counts more.
constexpr double kInterval = 0.08;
// Intervals on each side that show how the car turns, and those between them that a jump may take.
constexpr std::size_t kBeside = 2;
constexpr std::size_t kMostWithin = 2;
// The longest interval beside a jump over the shortest, and that with the jump over the shortest. Where images are
// missing and their times are wrong, a turn looks like a jump.
constexpr double kMostUneven = 1.6;
constexpr double kMostUnevenWithin = 2.2;
// Distance of an interval with a jump over that of the intervals beside it.
constexpr double kMostStretch = 1.5;
// Smallest jump, rad, and its growth with the square of the time that it takes, rad/s^2. In the ground truth of KITTI
// (23,000 frames) the yaw within 0.1 s differs by up to 1.4 degrees from what the motion beside it implies, that within
// 0.2 s by up to 2.6 degrees; without sequence 00, whose ground truth has jumps, by up to 0.5 and 0.9 degrees. Where
// the yaw rate beside it is as steady as kMostUnrest demands, it differs by up to 0.1 and 0.5 degrees (docs/knocks.md).
constexpr double kLeastJump = 0.5 / kDegreesPerRadian;
constexpr double kJumpGrowth = 60 / kDegreesPerRadian;
// Largest spread of the yaw rates beside a jump about the straight line that fits them best, times the duration of the
// jump, as a share of the jump. A line, as a car turns faster and faster where it begins a turn. Beyond it, a part of
// the jump lies outside.
constexpr double kMostUnrest = 0.4;

// Motion along an interval between two frames.
struct Motion {
  double seconds = 0;
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();  // rad
  double distance = 0;

  Eigen::Vector3d rate() const { return rotation / seconds; }
};

using ValuesBeside = Eigen::Vector<double, 2 * kBeside>;

// Largest minus smallest distance of rates from the straight line in time that fits them best.
double SpreadAboutLine(const ValuesBeside& times, const ValuesBeside& rates) {
  const ValuesBeside since_middle = times.array() - times.mean();
  const ValuesBeside from_line = rates - since_middle.dot(rates) / since_middle.squaredNorm() * since_middle;
  return from_line.maxCoeff() - from_line.minCoeff();
}

// The one that is nearer to zero; 0 if their signs differ.
double Weaker(double a, double b) {
  if (a * b <= 0) return 0;
  return std::abs(a) < std::abs(b) ? a : b;
}

}  // namespace

std::optional<MountJump> MountJumpDetector::End() {
  frames_.clear();
  const std::optional<Candidate> last = std::exchange(best_, std::nullopt);
  return last ? std::optional(last->jump) : std::nullopt;
}

void MountJumpDetector::Rescale(double factor) {
  for (Frame& frame : frames_) frame.world_from_camera.translation *= factor;
}

void MountJumpDetector::CorrectLast(const RigidTransform& last_from_corrected) {
  if (frames_.empty() || !last_from_corrected.IsFinite()) return;
  RigidTransform& last = frames_.back().world_from_camera;
  last = last * last_from_corrected;
}

std::optional<MountJump> MountJumpDetector::Add(int frame, double time, const RigidTransform& previous_from_current,
                                                const Eigen::Vector3d& vertical) {
  if (!previous_from_current.IsFinite()) return End();
  frames_.push_back(
      {frame, time, frames_.empty() ? RigidTransform() : frames_.back().world_from_camera * previous_from_current});
  if (const std::optional<Candidate> now = JumpNow(vertical)) {
    if (!best_ || now->unrest < best_->unrest) best_ = now;
    return std::nullopt;
  }
  if (!best_) return std::nullopt;
  const MountJump jump = best_->jump;
  best_.reset();
  // The motion after it is that before the next one.
  std::erase_if(frames_, [&](const Frame& earlier) { return earlier.number < jump.first_frame; });
  return jump;
}

// The jump that the latest frames show.
std::optional<MountJumpDetector::Candidate> MountJumpDetector::JumpNow(const Eigen::Vector3d& vertical) {
  // Rounding makes intervals of equal length unequal.
  constexpr double kRounding = 1e-6;
  constexpr std::size_t kMostSamples = 2 * kBeside + kMostWithin + 1;
  std::vector<std::size_t> samples = {frames_.size() - 1};
  for (std::size_t i = frames_.size() - 1; i-- > 0 && samples.size() < kMostSamples;)
    if (frames_[samples.back()].time - frames_[i].time > kInterval - kRounding) samples.push_back(i);
  std::ranges::reverse(samples);
  std::optional<Candidate> best;
  for (std::size_t within = 1; within <= kMostWithin; ++within) {
    const std::size_t count = 2 * kBeside + within + 1;
    if (samples.size() < count) break;
    const std::optional<Candidate> candidate = JumpBetween(std::span(samples).last(count), vertical);
    if (candidate && (!best || candidate->unrest < best->unrest)) best = candidate;
  }
  if (samples.size() == kMostSamples)
    frames_.erase(frames_.begin(), frames_.begin() + static_cast<std::ptrdiff_t>(samples.front()));
  return best;
}

// A jump between the third of the samples and the third from the end.
std::optional<MountJumpDetector::Candidate> MountJumpDetector::JumpBetween(std::span<const std::size_t> samples,
                                                                           const Eigen::Vector3d& vertical) const {
  const auto motion = [&](std::size_t first, std::size_t last) {
    const RigidTransform first_from_last = frames_[first].world_from_camera.inverse() * frames_[last].world_from_camera;
    return Motion{frames_[last].time - frames_[first].time, VectorFromRotation(first_from_last.rotation),
                  first_from_last.translation.norm()};
  };
  const std::size_t end = samples.size() - 1;
  const Motion within = motion(samples[kBeside], samples[end - kBeside]);
  const Motion before = motion(samples[kBeside - 1], samples[kBeside]);
  const Motion after = motion(samples[end - kBeside], samples[end - kBeside + 1]);
  double shortest = std::numeric_limits<double>::infinity();
  double longest = 0;
  ValuesBeside times;
  ValuesBeside rates;
  for (std::size_t k = 0; k < 2 * kBeside; ++k) {
    const std::size_t i = k < kBeside ? k : end - 2 * kBeside + k;
    const Motion beside = motion(samples[i], samples[i + 1]);
    shortest = std::min(shortest, beside.seconds);
    longest = std::max(longest, beside.seconds);
    times[k] = 0.5 * (frames_[samples[i]].time + frames_[samples[i + 1]].time);
    rates[k] = vertical.dot(beside.rate());
  }
  const auto intervals = static_cast<double>(end - 2 * kBeside);
  if (longest > kMostUneven * shortest || within.seconds > kMostUnevenWithin * intervals * shortest)
    return std::nullopt;
  const double distance_beside = before.distance + after.distance;
  if (!(within.distance <= 0.5 * kMostStretch * intervals * distance_beside)) return std::nullopt;

  const Eigen::Vector3d turned = 0.5 * within.seconds * (before.rate() + after.rate());
  const double by_time = vertical.dot(within.rotation - turned);
  const double by_distance =
      vertical.dot(within.rotation - within.distance / distance_beside * (before.rotation + after.rotation));
  const double jump = Weaker(by_time, by_distance);
  if (!(std::abs(jump) > kLeastJump + kJumpGrowth * within.seconds * within.seconds)) return std::nullopt;

  const double unrest = SpreadAboutLine(times, rates) * within.seconds;
  if (unrest > kMostUnrest * std::abs(jump)) return std::nullopt;

  // The first frame after the jump: where most of it takes place.
  const double car_rate = vertical.dot(turned) / within.seconds;
  std::size_t first = 0;
  double largest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = samples[kBeside] + 1; i <= samples[end - kBeside]; ++i) {
    const double rate = std::copysign(1.0, jump) * (vertical.dot(motion(i - 1, i).rate()) - car_rate);
    if (rate <= largest) continue;
    largest = rate;
    first = i;
  }
  const Eigen::Quaterniond before_from_after =
      RotationFromVector(turned).conjugate() * RotationFromVector(within.rotation);
  return Candidate{.jump = {.first_frame = frames_[first].number,
                            .time = frames_[first].time,
                            .before_from_after = before_from_after,
                            .yaw = vertical.dot(VectorFromRotation(before_from_after))},
                   .unrest = unrest};
}

}  // namespace turnscale
