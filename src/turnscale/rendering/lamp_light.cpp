// SPDX-License-Identifier: MIT
#include "turnscale/rendering/lamp_light.h"

#include <algorithm>

namespace turnscale {
namespace {

// Lamps farther away give nothing, metres.
constexpr float kReach = 15;
// What is less than this is left out.
constexpr float kLeastLight = 0.001F;

}  // namespace

LampLight::LampLight(const Lamp& lamp) : centre_(lamp.position), part_strength_(1) {
  // A long lamp is cut across, any other into quarters.
  const bool along_x = lamp.length_x > 2 * lamp.length_z;
  const bool along_z = lamp.length_z > 2 * lamp.length_x;
  for (int i = 0; i < 4; ++i) {
    const float along = 0.25F * (static_cast<float>(i) - 1.5F);
    const float x = along_x ? along : along_z ? 0.0F : (i % 2 == 0 ? -0.25F : 0.25F);
    const float z = along_z ? along : along_x ? 0.0F : (i / 2 == 0 ? -0.25F : 0.25F);
    parts_[i] = lamp.position + Eigen::Vector3f(x * lamp.length_x, 0, z * lamp.length_z);
  }
  const Eigen::Vector3f below = lamp.position + Eigen::Vector3f(0, 1, 0);
  float sum = 0;
  for (const Eigen::Vector3f& part : parts_) sum += From(part, below, Eigen::Vector3f(0, -1, 0));
  part_strength_ = lamp.strength / sum;
}

bool LampLight::Reaches(const Eigen::Vector3f& place, const Eigen::Vector3f& normal) const {
  float sum = 0;
  for (const Eigen::Vector3f& part : parts_) sum += From(part, place, normal);
  return sum > kLeastLight;
}

float LampLight::From(const Eigen::Vector3f& part, const Eigen::Vector3f& place, const Eigen::Vector3f& normal) const {
  const Eigen::Vector3f towards = part - place;
  const float square = towards.squaredNorm();
  // Down is +y, and so is the lamp's side that shines.
  const float cosines = -towards.y() * normal.dot(towards);
  if (towards.y() >= 0 || cosines <= 0 || square >= kReach * kReach) return 0;
  // Fades out towards the reach instead of ending there.
  const float fade = 1 - square / (kReach * kReach);
  return part_strength_ * fade * fade * cosines / std::max(square * square, 1e-4F);
}

}  // namespace turnscale
