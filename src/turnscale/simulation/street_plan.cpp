// SPDX-License-Identifier: MIT
#include "turnscale/simulation/street_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace turnscale::street {
namespace {

constexpr double kSpeed = 11;
// Over a whole drive, halts and curves included.
constexpr double kMeanSpeed = 7.4;
constexpr double kTurnRadius = 7.5;
constexpr double kPointStep = 0.5;
constexpr double kRoadPointStep = 1;
// A corner is where the way turns by so much within so many metres; there the road goes on straight, too.
constexpr double kCornerTurn = 60 * std::numbers::pi / 180;
constexpr double kCornerLength = 25;
constexpr double kSideStreet = 70;

double Hills(const Eigen::Vector2d& place, double phase) {
  return 1.6 * std::sin(place.x() / 61 + phase) + 1.9 * std::sin(place.y() / 83 + 2 * phase) +
         0.5 * std::sin((place.x() + place.y()) / 23);
}

// Every `kRoadPointStep` metres along the straight lines between the points, and the last point.
std::vector<RoadPoint> Resampled(const std::vector<RoadPoint>& way) {
  std::vector<RoadPoint> resampled;
  double behind = 0;  // from the last point taken to the piece's start
  for (size_t i = 0; i + 1 < way.size(); ++i) {
    const double length = (way[i + 1].place - way[i].place).norm();
    double at = resampled.empty() ? 0 : kRoadPointStep - behind;
    for (; at < length; at += kRoadPointStep) {
      const double share = at / length;
      resampled.push_back(
          {way[i].place + share * (way[i + 1].place - way[i].place), way[i].up + share * (way[i + 1].up - way[i].up)});
    }
    behind = length - (at - kRoadPointStep);
  }
  resampled.push_back(way.back());
  return resampled;
}

std::vector<RoadPoint> StraightOn(const RoadPoint& from, const Eigen::Vector2d& along) {
  std::vector<RoadPoint> road;
  for (double at = 0; at <= kSideStreet; at += kRoadPointStep) road.push_back({from.place + at * along, from.up});
  return road;
}

// A side street must not run into the way elsewhere at a sharp angle: it ends before it comes near again.
void CutBefore(const std::vector<RoadPoint>& driven, int corner, std::vector<RoadPoint>& road) {
  constexpr int kNearCorner = 60;
  constexpr double kClear = 22;
  for (size_t i = 0; i < road.size(); ++i)
    for (int k = 0; k < static_cast<int>(driven.size()); ++k) {
      if (std::abs(k - corner) < kNearCorner || (driven[k].place - road[i].place).norm() > kClear) continue;
      road.resize(i);
      return;
    }
}

// Where the way turns a corner, and where it begins and ends, the road goes on.
void AddSideStreets(const std::vector<RoadPoint>& driven, std::vector<std::vector<RoadPoint>>& roads) {
  const std::vector<RoadPoint> middle = Beside(driven, -kMiddle);
  const auto add = [&](int from, const Eigen::Vector2d& along, int corner) {
    std::vector<RoadPoint> road = StraightOn(middle[from], along);
    CutBefore(driven, corner, road);
    if (road.size() > 2) roads.push_back(std::move(road));
  };
  const int last = static_cast<int>(driven.size()) - 1;
  add(0, -Along(driven, 0), 0);
  add(last, Along(driven, last), last);
  const int length = static_cast<int>(kCornerLength / kRoadPointStep);
  for (int i = 0; i + length < static_cast<int>(driven.size()); ++i) {
    const Eigen::Vector2d before = Along(driven, i);
    const Eigen::Vector2d after = Along(driven, i + length);
    if (std::acos(std::clamp(before.dot(after), -1.0, 1.0)) < kCornerTurn) continue;
    add(i, before, i + length / 2);
    add(i + length, -after, i + length / 2);
    i += length;
  }
}

}  // namespace

std::vector<RoadPoint> Beside(const std::vector<RoadPoint>& way, double right) {
  std::vector<RoadPoint> beside = way;
  for (int i = 0; i < static_cast<int>(way.size()); ++i) {
    const Eigen::Vector2d along = Along(way, i);
    beside[i].place += right * Eigen::Vector2d(along.y(), -along.x());
  }
  return beside;
}

Eigen::Vector2d Along(const std::vector<RoadPoint>& way, int point) {
  constexpr int kReach = 2;
  const int before = std::max(0, point - kReach);
  const int after = std::min(static_cast<int>(way.size()) - 1, point + kReach);
  return (way[after].place - way[before].place).normalized();
}

Plan MakePlan(Random& random, double seconds) {
  // Never back south, so the way does not meet itself.
  std::vector<Eigen::Vector2d> corners = {{0, 0}};
  Eigen::Vector2d direction(0, 1);
  const double wanted = seconds * kMeanSpeed;
  double length = 0;
  int straight = 1 + random.Below(3);  // which block is the long one
  while (length < wanted) {
    const double block = straight-- == 0 ? random.Uniform(230, 280) : random.Uniform(55, 110);
    length += block;
    corners.emplace_back(corners.back() + block * direction);
    const bool north = direction.y() > 0.5;
    direction = north ? Eigen::Vector2d(random.Chance(0.5) ? 1 : -1, 0) : Eigen::Vector2d(0, 1);
  }
  const double phase = random.Uniform(0, 6);
  Plan plan;
  for (const Eigen::Vector2d& place : RoundCorners(corners, kTurnRadius, kRoadPointStep))
    plan.driven.push_back({place, Hills(place, phase)});
  plan.roads.push_back(Beside(plan.driven, -kMiddle));
  AddSideStreets(plan.driven, plan.roads);

  // A halt before the middle corner.
  const size_t middle = corners.size() / 2;
  const Eigen::Vector2d halt = corners[middle] + 12 * (corners[middle - 1] - corners[middle]).normalized();
  std::vector<Eigen::Vector2d> first(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(middle));
  first.push_back(halt);
  std::vector<Eigen::Vector2d> second(corners.begin() + static_cast<std::ptrdiff_t>(middle), corners.end());
  second.insert(second.begin(), halt);
  for (const std::vector<Eigen::Vector2d>& part : {first, second}) {
    RouteLeg leg;
    leg.points = RoundCorners(part, kTurnRadius, kPointStep);
    leg.speed = kSpeed;
    leg.wait = 2;
    plan.legs.push_back(leg);
  }
  CutLegs(wanted, plan.legs);
  return plan;
}

Plan PlanAlong(const std::vector<Eigen::Vector3d>& path, const std::vector<double>& speeds) {
  Plan plan;
  RouteLeg leg;
  for (const Eigen::Vector3d& point : path) {
    leg.points.emplace_back(point.x(), point.z());
    plan.driven.push_back({leg.points.back(), point.y()});
  }
  leg.speeds = speeds;
  leg.speed = *std::ranges::max_element(speeds);
  plan.legs.push_back(leg);
  plan.driven = Resampled(plan.driven);
  plan.roads.push_back(Beside(plan.driven, -kMiddle));
  AddSideStreets(plan.driven, plan.roads);
  return plan;
}

}  // namespace turnscale::street
