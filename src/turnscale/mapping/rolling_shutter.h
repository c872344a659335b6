// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// How far a point at `position` (in W) moves in the image of a keyframe while its row waits to be read, at the speed
/// that the keyframes before and after show, as far as no gap in the tracking and neither end of the map lies between:
/// undistorted pixels per second of the readout, to first order. The time of an image is that of its middle row.
/// `pixel`: of the image with its distortion. `direction`: in which rows follow one another. Zero where the size of the
/// image is not known or the point is not in front.
Eigen::Vector2d RowMotion(const Map& map, int keyframe, const Eigen::Vector3d& position, const Eigen::Vector2d& pixel,
                          const ReadDirection& direction);

/// Moves all pixels of valid landmarks to where they would be if all rows were read together, by the camera's readout
/// (CameraModel); nothing where it is 0. Poses and landmarks stay: they tell the motion. A landmark's observations have
/// to be in the order of their keyframes.
void CorrectRows(Map& map);

}  // namespace turnscale
