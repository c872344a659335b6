// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/mapping/intrinsics_evidence.h"

namespace turnscale {

/// A change without the correction's higher terms, where pixels keep their shape and rows their time.
inline IntrinsicsChange::Vector Change(double log_focal, double centre_x, double centre_y, double correction) {
  IntrinsicsChange::Vector change;
  change << log_focal, centre_x, centre_y, correction, 0, 0, 0, 0;
  return change;
}

}  // namespace turnscale
