// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/evaluation/association.h"

namespace turnscale {

/// Whose poses are compared, and what is known of their axes.
struct ComparedPoses {
  std::string estimate;  ///< name for messages, as the following
  std::string truth;
  bool keeps_axes = false;  ///< the estimate's axes are to stay as they are: a rotation refers to them
};

/// Turns the body axes of the poses so that both are the same, and a camera's (x right, y down, z forward) where
/// `keeps_axes` does not forbid it. Nothing changes where both are the same camera's. Gives a warning that says whose
/// axes are turned, or that the motions do not fit each other in any axes; else nothing.
std::string UniteAxes(const ComparedPoses& compared, PosePairs& pairs);

}  // namespace turnscale
