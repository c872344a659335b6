// SPDX-License-Identifier: MIT
#include "turnscale/simulation/garage_plan.h"

#include <algorithm>
#include <cmath>

namespace turnscale::garage {
namespace {

constexpr double kSpeed = 4.5;
constexpr double kRampSpeed = 3.5;
// Over a whole drive, halts and curves included.
constexpr double kMeanSpeed = 2.9;
constexpr double kTurnRadius = 5.2;
constexpr double kBackingRadius = 4.2;
constexpr double kPointStep = 0.25;
constexpr double kSouth = kAisle / 2;
constexpr double kNorth = kHallDepth - kAisle / 2;
constexpr double kRampX = kHallWidth + kRampWidth / 2;
// How far in front of a space's end the parked car's rear axle stands.
constexpr double kAxleInBay = 4.1;

RouteLeg Leg(const std::vector<Eigen::Vector2d>& corners, double speed, double wait) {
  RouteLeg leg;
  leg.points = RoundCorners(corners, kTurnRadius, kPointStep);
  leg.speed = speed;
  leg.wait = wait;
  return leg;
}

// Once round a hall and back to the corner it starts from, that corner left out at the start.
std::vector<Eigen::Vector2d> Lap(double x0, bool from_west, bool from_south) {
  const double near = x0 + kAisles[from_west ? 0 : 1];
  const double far = x0 + kAisles[from_west ? 1 : 0];
  const double start = from_south ? kSouth : kNorth;
  const double other = from_south ? kNorth : kSouth;
  return {{near, other}, {far, other}, {far, start}, {near, start}};
}

}  // namespace

double RoadUp(const Eigen::Vector2d& place) {
  if (place.x() <= kHallWidth) return 0;
  if (place.x() >= kUpperX) return kStorey;
  constexpr double kFoot = kAisle + 2;
  constexpr double kHead = kHallDepth - kAisle - 2;
  const double share = std::clamp((place.y() - kFoot) / (kHead - kFoot), 0.0, 1.0);
  // Rounded at foot and head, straight between.
  constexpr double kRound = 0.12;
  const double slope = 1 / (1 - kRound);
  if (share < kRound) return kStorey * slope * share * share / (2 * kRound);
  if (share > 1 - kRound) return kStorey * (1 - slope * (1 - share) * (1 - share) / (2 * kRound));
  return kStorey * slope * (share - kRound / 2);
}

Plan MakePlan(Random& random, double seconds) {
  const bool upwards = random.Chance(0.5);
  const double first_x = upwards ? 0 : kUpperX;
  const double second_x = upwards ? kUpperX : 0;
  // The lane beside the ramp is where a hall is left; the other one is where the drive begins.
  const int first_lane = upwards ? 0 : 1;
  const double start_lane = first_x + kAisles[first_lane];
  const double exit_lane = first_x + kAisles[1 - first_lane];
  const double leave_z = upwards ? kSouth : kNorth;
  const double arrive_z = upwards ? kNorth : kSouth;
  // Towards the end of the hall where the ramp is not, first.
  const double ahead = arrive_z;
  const double heading = ahead > leave_z ? 1.0 : -1.0;

  Plan plan;
  plan.start = {first_x, upwards ? 0 : 3, 5 + random.Below(6)};
  const double bay_z = BayEdge(plan.start.bay) + kBayWidth / 2;
  const double bay_x = first_x + (upwards ? kAxleInBay : kHallWidth - kAxleInBay);
  const double back_z = bay_z - heading * (kBackingRadius + 1.5);
  RouteLeg backing;
  backing.points =
      RoundCorners({{bay_x, bay_z}, {start_lane, bay_z}, {start_lane, back_z}}, kBackingRadius, kPointStep);
  backing.speed = 1.2;
  backing.reverse = true;
  backing.wait = 1;
  plan.legs.push_back(backing);

  std::vector<Eigen::Vector2d> corners = {
      {start_lane, back_z}, {start_lane, ahead}, {exit_lane, ahead}, {exit_lane, leave_z}};
  plan.legs.push_back(Leg({corners[0], corners[1], corners[2], {exit_lane, leave_z + heading * 8}}, kSpeed, 1.5));
  plan.legs.push_back(Leg(
      {{exit_lane, leave_z + heading * 8}, {exit_lane, leave_z}, {kRampX, leave_z}, {kRampX, arrive_z - heading * 8}},
      kRampSpeed, 0.5));

  const double near_lane = second_x + kAisles[upwards ? 0 : 1];
  corners = {{kRampX, arrive_z - heading * 8}, {kRampX, arrive_z}, {near_lane, arrive_z}};
  const double wanted = seconds * kMeanSpeed;
  while (PathLength(corners) < wanted) {
    const std::vector<Eigen::Vector2d> lap = Lap(second_x, upwards, !upwards);
    corners.insert(corners.end(), lap.begin(), lap.end());
  }
  plan.legs.push_back(Leg(corners, kSpeed, 1));
  CutLegs(wanted, plan.legs);
  return plan;
}

}  // namespace turnscale::garage
