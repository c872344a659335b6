// SPDX-License-Identifier: MIT
#include "turnscale/odometry/results.h"

#include <initializer_list>

namespace turnscale {
namespace {

template <class State>
std::optional<State> Named(std::string_view name, std::initializer_list<State> states, const char* (*name_of)(State)) {
  for (const State state : states)
    if (name == name_of(state)) return state;
  return std::nullopt;
}

}  // namespace

const char* ScaleStateName(ScaleState state) {
  switch (state) {
    case ScaleState::kPending:
      return "pending";
    case ScaleState::kObserved:
      return "observed";
    case ScaleState::kHeld:
      return "held";
    case ScaleState::kFromRoad:
      return "road";
  }
  return "unknown";
}

const char* TrackingStateName(TrackingState state) {
  switch (state) {
    case TrackingState::kInitializing:
      return "initializing";
    case TrackingState::kTracked:
      return "tracked";
    case TrackingState::kRepeated:
      return "repeated";
    case TrackingState::kBridged:
      return "bridged";
    case TrackingState::kUnreadable:
      return "unreadable";
  }
  return "unknown";
}

std::optional<ScaleState> ScaleStateNamed(std::string_view name) {
  return Named(name, {ScaleState::kPending, ScaleState::kObserved, ScaleState::kHeld, ScaleState::kFromRoad},
               ScaleStateName);
}

std::optional<TrackingState> TrackingStateNamed(std::string_view name) {
  return Named(name,
               {TrackingState::kInitializing, TrackingState::kTracked, TrackingState::kRepeated,
                TrackingState::kBridged, TrackingState::kUnreadable},
               TrackingStateName);
}

AxlePose RearAxle(const FrameResult& frame, double lever_arm) {
  const RigidTransform& camera = *frame.world_from_camera;
  const Eigen::Vector3d forward = camera.rotation * (frame.vehicle_from_camera.conjugate() * Eigen::Vector3d::UnitZ());
  return {camera.translation - lever_arm * forward, forward};
}

}  // namespace turnscale
