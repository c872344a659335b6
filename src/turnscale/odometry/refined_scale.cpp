// SPDX-License-Identifier: MIT
#include "turnscale/odometry/refined_scale.h"

#include <cmath>

namespace turnscale {
namespace {

// Change of the log-scale that an error of the calibration may cause: per relative error of the focal length, per rad
// of the principal point, per unit of radial correction, per relative error of the aspect. About the largest that the
// turns of benchmarks/variants show by themselves; the aspect changes heights by as much.
constexpr double kScalePerFocalLength = 2;
constexpr double kScalePerAngle = 3;
constexpr double kScalePerCorrection = 15;
constexpr double kScalePerAspect = 1;

void AddToSigmas(double sigma, RefinedScale& refined) {
  if (sigma == 0 || !refined.estimate) return;
  for (KeyframeScale& keyframe : refined.keyframes) keyframe.sigma = std::hypot(keyframe.sigma, sigma);
  refined.estimate->length_sigma = std::hypot(refined.estimate->length_sigma, sigma);
}

}  // namespace

ScaleState StateAtEnd(const RefinedScale& refined) {
  return refined.keyframes.empty() ? ScaleState::kPending : refined.keyframes.back().state;
}

double CalibrationSigma(const std::vector<ParameterEstimate>& contradictions, const CameraModel& camera) {
  const Pinhole& pinhole = camera.pinhole;
  double variance = std::pow(kScalePerFocalLength * (camera.focal_sigma / pinhole.fx), 2);
  for (const ParameterEstimate& estimate : contradictions) {
    const double off = estimate.found - estimate.given;
    double sigma = 0;
    switch (estimate.parameter) {
      case IntrinsicsParameter::kFocalLength:
        sigma = kScalePerFocalLength * off / pinhole.fx;
        break;
      case IntrinsicsParameter::kCentreX:
        sigma = kScalePerAngle * off / pinhole.fx;
        break;
      case IntrinsicsParameter::kCentreY:
        sigma = kScalePerAngle * off / pinhole.fy;
        break;
      case IntrinsicsParameter::kDistortion:
        sigma = kScalePerCorrection * off;
        break;
      case IntrinsicsParameter::kPixelAspect:
        sigma = kScalePerAspect * off / estimate.given;
        break;
      case IntrinsicsParameter::kReadout:
        // The one that was found is corrected.
        break;
    }
    variance += sigma * sigma;
  }
  return std::sqrt(variance);
}

double CalibrationSigma(const std::vector<ParameterEstimate>& contradictions,
                        const std::vector<ParameterEstimate>& doubts, const CameraModel& camera) {
  return CalibrationSigma(contradictions.empty() ? doubts : contradictions, camera);
}

void WidenScale(double sigma, RefinedScale& refined) {
  refined.calibration_sigma = std::hypot(refined.calibration_sigma, sigma);
  AddToSigmas(sigma, refined);
}

void WidenForCalibration(const std::vector<ParameterEstimate>& contradictions,
                         const std::vector<ParameterEstimate>& doubts, const CameraModel& camera,
                         RefinedScale& refined) {
  refined.contradicted_calibration = contradictions;
  if (contradictions.empty()) {
    refined.doubtful_calibration = doubts;
    CameraModel exact = camera;
    exact.focal_sigma = 0;
    refined.doubt_sigma = CalibrationSigma(doubts, exact);
  }
  WidenScale(CalibrationSigma(contradictions, doubts, camera), refined);
}

void WidenForHeight(RefinedScale& refined) {
  if (!refined.estimate) return;
  const double sigma = HeightSigma(*refined.estimate, std::hypot(refined.calibration_sigma, refined.aspect_sigma));
  refined.unusual_height = FindUnusualHeight(HeightByScale(*refined.estimate), sigma);
  if (!refined.unusual_height) return;
  AddToSigmas(refined.unusual_height->scale_error, refined);
  refined.estimate->is_doubtful = true;
}

}  // namespace turnscale
