// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/bundle/bundle_state.h"
#include "turnscale/bundle/bundle_structure.h"
#include "turnscale/bundle/kkt_step.h"
#include "turnscale/geometry/pinhole.h"

namespace turnscale {

/// Takes a step from `state` to `trial` and returns the observations' cost there.
///
/// The quadratic model can be far off for single points (tracks with outliers, points that hardly move in the image)
/// while it holds for all others. Such a point would spoil the whole step, so it is treated on its own: where a point's
/// cost rises, or where its model was rough, it is minimised with the cameras held at their new places. Near the
/// solution no point needs this and the step is the model's own. Infinite where a point is left behind a camera.
template <int kDof>
double TakeStep(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
                const NormalEquations<kDof>& equations, const KktStep& step, double huber_threshold,
                BundleState& trial);

}  // namespace turnscale
