// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/bundle/bundle_state.h"
#include "turnscale/bundle/bundle_structure.h"
#include "turnscale/bundle/kkt_step.h"
#include "turnscale/geometry/pinhole.h"

namespace turnscale {

/// Takes `share` of a step from `state` to `trial` and returns the cost there. A point whose step would carry it behind
/// a camera that sees it goes only as far as stays in front; where not even standing still helps, the cost is infinite.
template <int kDof>
double TakeStep(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state, const KktStep& step,
                double share, double huber_threshold, BundleState& trial);

}  // namespace turnscale
