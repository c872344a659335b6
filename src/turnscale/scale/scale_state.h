// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

/// State of the scale of a pose.
enum class ScaleState {
  kPending,   ///< neither a turn nor a known height has determined the scale yet: the unit is arbitrary
  kObserved,  ///< within a used turn; online, up to the keyframe that ends it
  kHeld,      ///< between turns: propagated from the adjacent turns; online, from earlier ones
  kFromRoad,  ///< between turns, where the height of the camera above the road shows it
};

}  // namespace turnscale
