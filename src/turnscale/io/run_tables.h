// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// First line of trajectory.csv.
std::string FrameTableHeader();

/// A frame's line in trajectory.csv; `pose` is the one to show. Cells without a value are empty.
std::string FrameTableLine(const FrameResult& frame, const std::optional<RigidTransform>& pose);

/// The whole of turns.csv.
std::string TurnTable(const std::vector<TurnResult>& turns);

}  // namespace turnscale
