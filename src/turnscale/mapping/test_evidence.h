// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include "turnscale/geometry/random_vector.h"
#include "turnscale/mapping/intrinsics_estimate.h"

namespace turnscale {

/// Standard deviations with which a window of a turn shows the entries, without what it gets wrong beyond its noise.
inline IntrinsicsChange::Vector SigmasOfWindow() {
  IntrinsicsChange::Vector sigmas;
  sigmas << 0.005, 2, 2, 0.005, 0.02, 0.02, 0.03, 0.001;
  return sigmas;
}

/// The covariance of a window whose entries go together: half of each variance is common to all.
inline IntrinsicsChange::Matrix CovarianceOfWindow() {
  const IntrinsicsChange::Vector sigmas = SigmasOfWindow();
  const IntrinsicsChange::Matrix own = sigmas.array().square().matrix().asDiagonal();
  return 0.5 * own + 0.5 * sigmas * sigmas.transpose();
}

/// What a window shows that has its minimum there.
inline WindowEvidence EvidenceAt(const IntrinsicsChange::Vector& minimum) {
  const IntrinsicsChange::Matrix information = CovarianceOfWindow().inverse();
  return {information, information * minimum, minimum[IntrinsicsChange::kLogAspect]};
}

/// Windows of a drive with this change, each with errors of its own that are as large as it says.
inline std::vector<WindowEvidence> EvidenceAround(const IntrinsicsChange::Vector& truth, int windows, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  const IntrinsicsChange::Vector sigmas = SigmasOfWindow();
  std::vector<WindowEvidence> evidence;
  for (int i = 0; i < windows; ++i) {
    const double common = noise(random);
    const auto own = DrawVector<IntrinsicsChange::kEntries>([&] { return noise(random); });
    evidence.push_back(
        EvidenceAt(truth + std::sqrt(0.5) * sigmas.cwiseProduct(own + common * IntrinsicsChange::Vector::Ones())));
  }
  return evidence;
}

}  // namespace turnscale
