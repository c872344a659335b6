// SPDX-License-Identifier: MIT
#include "turnscale/bundle/reprojection.h"

#include <random>

#include <gtest/gtest.h>

#include "turnscale/geometry/random_vector.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

const Pinhole kPinhole{718, 702, 607, 185};
constexpr double kThreshold = 2.0;
/// Of first and of second differences.
constexpr double kPoseStep = 1e-6;
constexpr double kLongStep = 1e-4;

/// One random observation; `error` is the length of the residual in sigmas.
struct Sample {
  Sample(unsigned seed, double error) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const auto vector = [&] { return DrawVector<3>([&] { return normal(random); }); };
    rotation = RotationFromVector(vector()).toRotationMatrix();
    Eigen::Vector3d x_in_camera = vector();
    x_in_camera.z() = 4.0 + std::abs(x_in_camera.z());
    offset = rotation.transpose() * x_in_camera;
    inverse_sigma = 1.0 / 1.7;
    const double angle = normal(random);
    pixel = kPinhole.Project(x_in_camera) + 1.7 * error * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }

  Eigen::Vector3d Moved(const Vector6d& step) const {
    return RotationFromVector(step.head<3>()) * (rotation * (offset + step.tail<3>()));
  }
  Eigen::Vector2d Residual(const Vector6d& step) const {
    return ReprojectionResidual(kPinhole, Moved(step), pixel, inverse_sigma);
  }
  double Cost(const Vector6d& step) const { return HuberCost(Residual(step).squaredNorm(), kThreshold); }

  Eigen::Matrix3d rotation;
  Eigen::Vector3d offset;  ///< point minus centre, in the world
  Eigen::Vector2d pixel;
  double inverse_sigma;
};

Eigen::Matrix<double, 2, 6> NumericJacobian(const Sample& sample) {
  Eigen::Matrix<double, 2, 6> J;
  for (int i = 0; i < 6; ++i) {
    const Vector6d h = kPoseStep * Vector6d::Unit(i);
    J.col(i) = (sample.Residual(h) - sample.Residual(-h)) / (2 * kPoseStep);
  }
  return J;
}

Vector6d NumericGradient(const Sample& sample) {
  Vector6d gradient;
  for (int i = 0; i < 6; ++i) {
    const Vector6d h = kPoseStep * Vector6d::Unit(i);
    gradient[i] = (sample.Cost(h) - sample.Cost(-h)) / (2 * kPoseStep);
  }
  return gradient;
}

Matrix6d NumericHessian(const Sample& sample) {
  Matrix6d hessian;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      const Vector6d a = kLongStep * Vector6d::Unit(i);
      const Vector6d b = kLongStep * Vector6d::Unit(j);
      hessian(i, j) = (sample.Cost(a + b) - sample.Cost(a - b) - sample.Cost(b - a) + sample.Cost(-a - b)) /
                      (4 * kLongStep * kLongStep);
    }
  }
  return hessian;
}

TEST(Reprojection, GaussNewtonModelIsTheJacobiansAgainstDifferences) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const double error : {0.7, 1.9, 2.1, 30.0}) {
      const Sample sample(seed, error);
      const Eigen::Matrix<double, 2, 6> J = NumericJacobian(sample);
      const double weight = error <= kThreshold ? 1.0 : kThreshold / error;
      const Matrix6d expected = weight * J.transpose() * J;
      const Vector6d zero = Vector6d::Zero();
      ObservationModel<6> model;
      const double cost = GaussNewtonModel(kPinhole, sample.rotation, sample.Moved(zero), sample.pixel,
                                           sample.inverse_sigma, kThreshold, model);
      EXPECT_NEAR(cost, sample.Cost(zero), 1e-12 * cost);
      EXPECT_LT((model.hessian - expected).norm(), 1e-7 * expected.norm());
      EXPECT_LT((model.gradient - NumericGradient(sample)).norm(), 1e-6 * model.gradient.norm());

      ObservationModel<3> centre_only;
      GaussNewtonModel(kPinhole, sample.rotation, sample.Moved(zero), sample.pixel, sample.inverse_sigma, kThreshold,
                       centre_only);
      EXPECT_LT((centre_only.hessian - expected.bottomRightCorner<3, 3>()).norm(), 1e-7 * expected.norm());
      EXPECT_LT((centre_only.gradient - model.gradient.tail<3>()).norm(), 1e-12 * model.gradient.norm());
    }
  }
}

TEST(Reprojection, NewtonModelIsTheCostsSecondDifferences) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    // Far enough from the bend of the loss, where the second derivative jumps.
    for (const double error : {0.5, 1.5, 6.0, 40.0}) {
      const Sample sample(seed, error);
      const Vector6d zero = Vector6d::Zero();
      ObservationModel<6> model;
      const double cost = NewtonModel(kPinhole, sample.rotation, sample.Moved(zero), sample.pixel, sample.inverse_sigma,
                                      kThreshold, model);
      EXPECT_NEAR(cost, sample.Cost(zero), 1e-12 * cost);
      EXPECT_LT((model.gradient - NumericGradient(sample)).norm(), 1e-6 * model.gradient.norm());
      const Matrix6d expected = NumericHessian(sample);
      EXPECT_LT((model.hessian - expected).norm(), 2e-4 * expected.norm()) << "seed " << seed << " error " << error;

      ObservationModel<3> centre_only;
      NewtonModel(kPinhole, sample.rotation, sample.Moved(zero), sample.pixel, sample.inverse_sigma, kThreshold,
                  centre_only);
      EXPECT_LT((centre_only.hessian - model.hessian.bottomRightCorner<3, 3>()).norm(), 1e-12 * model.hessian.norm());
      EXPECT_LT((centre_only.gradient - model.gradient.tail<3>()).norm(), 1e-12 * model.gradient.norm());
    }
  }
}

TEST(Reprojection, HuberCostIsSmoothAtItsThreshold) {
  EXPECT_DOUBLE_EQ(HuberCost(4.0, 2.0), 2.0);
  EXPECT_NEAR(HuberCost(4.0 + 1e-9, 2.0), 2.0 + 0.5e-9, 1e-15);
  EXPECT_DOUBLE_EQ(HuberCost(100.0, 2.0), 2.0 * (10.0 - 1.0));
  EXPECT_DOUBLE_EQ(HuberCost(100.0, 0.0), 50.0) << "0 is plain least squares";
}

TEST(Reprojection, FrontIsADirectionNotADepth) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    EXPECT_TRUE(IsInFront(scale * Eigen::Vector3d(1, 1, 1)));
    EXPECT_FALSE(IsInFront(scale * Eigen::Vector3d(1, 1, -1)));
    EXPECT_FALSE(IsInFront(scale * Eigen::Vector3d(1, 1, 1e-4)));
  }
  EXPECT_FALSE(IsInFront(Eigen::Vector3d::Zero()));
  EXPECT_FALSE(IsInFront(Eigen::Vector3d::Constant(std::nan(""))));
}

}  // namespace
}  // namespace turnscale
