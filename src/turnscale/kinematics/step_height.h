// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "turnscale/kinematics/vehicle_step.h"

namespace turnscale {

/// A measured height of the camera above the road.
struct PathHeight {
  double time = 0;    ///< as the poses'
  double height = 0;  ///< in the path's unit of length
  double sigma = 0;   ///< relative standard deviation
};

/// Mean height above the road along a step, from those measured along it.
class StepHeight {
 public:
  /// `height` in odometry units, `sigma` its relative standard deviation.
  void Add(double height, double sigma) {
    const double weight = 1 / (sigma * sigma);
    information_ += weight;
    sum_ += weight * std::log(height);
    ++count_;
  }

  /// Leaves a step without heights as it is.
  void SetOn(VehicleStep& step) const {
    if (count_ == 0) return;
    step.height = std::exp(sum_ / information_);
    // Heights along one step share most of their errors.
    step.height_sigma = std::sqrt(count_ / information_);
  }

 private:
  double information_ = 0;
  double sum_ = 0;  // of the weighted logarithms
  int count_ = 0;
};

}  // namespace turnscale
