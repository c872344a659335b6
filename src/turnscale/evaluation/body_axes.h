// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "turnscale/evaluation/association.h"
#include "turnscale/evaluation/evaluation.h"

namespace turnscale {

/// How alike two motions are, pose by pose, each seen in the axes of its own body: 1 if they are the same but for a
/// scale, 0 if one does not tell the other.
struct Likeness {
  double way = 0;   ///< mean cosine between directions of travel, weighted with the way
  double turn = 0;  ///< mean cosine between axes of rotation, weighted with the angles
};

/// The body axes of an estimate and of its truth, compared.
struct BodyAxes {
  Eigen::Quaterniond estimate_from_truth = Eigen::Quaterniond::Identity();  ///< constant, as the motions show it
  Likeness as_given;
  Likeness turned;  ///< once the truth's axes are turned by that rotation
};

/// Errors of motions are only meaningful between the same body axes. The direction of travel shows two of the three
/// angles between two bodies on one car, its turns show the third.
BodyAxes CompareBodyAxes(const PosePairs& pairs, const std::vector<Step>& steps);

/// The path of a body with other axes, in a world whose axes are turned likewise: a body that looks along its world's
/// x axis does so afterwards.
RigidTransform WithOtherAxes(const RigidTransform& world_from_body, const Eigen::Quaterniond& other_from_body);

}  // namespace turnscale
