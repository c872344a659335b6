// SPDX-License-Identifier: MIT
// The constrained optimum against IPOPT, an interior-point solver that shares nothing with ours: automatic derivatives,
// constraints as differences of squares (28).
#include <algorithm>
#include <type_traits>
#include <vector>

#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/bundle/synthetic_drive.h"

namespace turnscale {
namespace {

using Ipopt::Index;
using Ipopt::Number;

/// (26)-(30): unknowns are the centres of all cameras but the first, then the points; rotations are fixed.
class RecoveryProgram : public Ipopt::TNLP {
 public:
  RecoveryProgram(const BundleProblem& problem, double huber_threshold)
      : problem_(problem), huber_threshold_(huber_threshold) {
    for (std::size_t i = 1; i < problem.camera_from_world.size(); ++i) Append(Centre(problem, i));
    for (const Eigen::Vector3d& point : problem.points) Append(point);
  }

  const std::vector<double>& unknowns() const { return unknowns_; }
  double cost() const { return cost_; }

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override {
    n = static_cast<Index>(unknowns_.size());
    m = static_cast<Index>(problem_.distances.size());
    jacobian = 6 * m;
    hessian = 21 * static_cast<Index>(problem_.observations.size()) + 9 * m;
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* c_lower, Number* c_upper) override {
    std::fill(lower, lower + n, -1e19);
    std::fill(upper, upper + n, 1e19);
    for (Index i = 0; i < m; ++i) c_lower[i] = c_upper[i] = Squared(problem_.distances[i].distance);
    return true;
  }

  bool get_starting_point(Index, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    std::copy(unknowns_.begin(), unknowns_.end(), x);
    return true;
  }

  bool eval_f(Index, const Number* x, bool, Number& cost) override {
    cost = 0;
    for (const BundleObservation& seen : problem_.observations) cost += Cost<double>(seen, Offset(seen, x));
    return true;
  }

  bool eval_grad_f(Index n, const Number* x, bool, Number* gradient) override {
    std::fill(gradient, gradient + n, 0.0);
    for (const BundleObservation& seen : problem_.observations) {
      // The cost depends on point minus centre alone.
      const Jet cost = Cost<Jet>(seen, Offset(seen, x).cast<Jet>() + JetUnits());
      for (int k = 0; k < 3; ++k) {
        gradient[PointIndex(seen.point) + k] += cost.v[k];
        if (seen.camera > 0) gradient[CameraIndex(seen.camera) + k] -= cost.v[k];
      }
    }
    return true;
  }

  bool eval_g(Index, const Number* x, bool, Index m, Number* g) override {
    for (Index i = 0; i < m; ++i) g[i] = Difference(problem_.distances[i], x).squaredNorm();
    return true;
  }

  bool eval_jac_g(Index, const Number* x, bool, Index m, Index, Index* rows, Index* columns, Number* values) override {
    for (Index i = 0; i < m; ++i) {
      const DistanceConstraint& held = problem_.distances[i];
      for (int k = 0; k < 6; ++k) {
        if (values == nullptr) {
          rows[6 * i + k] = i;
          columns[6 * i + k] = CameraIndex(k < 3 ? held.camera_a : held.camera_b) + k % 3;
        } else {
          values[6 * i + k] = (k < 3 ? 2.0 : -2.0) * Difference(held, x)[k % 3];
        }
      }
    }
    return true;
  }

  bool eval_h(Index, const Number* x, bool, Number factor, Index m, const Number* multipliers, bool, Index, Index* rows,
              Index* columns, Number* values) override {
    // Entries of the lower triangle; IPOPT adds up those that fall on one place.
    Index next = 0;
    const auto put = [&](Index row, Index column, double value) {
      if (values == nullptr) {
        rows[next] = std::max(row, column);
        columns[next] = std::min(row, column);
      } else {
        values[next] = value;
      }
      ++next;
    };
    for (const BundleObservation& seen : problem_.observations) {
      const Eigen::Matrix3d H = values == nullptr ? Eigen::Matrix3d::Zero().eval() : factor * Hessian(seen, x);
      const Index point = PointIndex(seen.point);
      // The first camera is no unknown: its entries go to the point's diagonal as zeros.
      const bool free = seen.camera > 0;
      const Index camera = free ? CameraIndex(seen.camera) : point;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          put(point + i, camera + j, free ? -H(i, j) : 0.0);
          if (j > i) continue;
          put(point + i, point + j, H(i, j));
          put(camera + i, camera + j, free ? H(i, j) : 0.0);
        }
      }
    }
    for (Index i = 0; i < m; ++i) {
      const Index a = CameraIndex(problem_.distances[i].camera_a);
      const Index b = CameraIndex(problem_.distances[i].camera_b);
      for (int k = 0; k < 3; ++k) {
        put(a + k, a + k, values == nullptr ? 0.0 : 2.0 * multipliers[i]);
        put(b + k, b + k, values == nullptr ? 0.0 : 2.0 * multipliers[i]);
        put(a + k, b + k, values == nullptr ? 0.0 : -2.0 * multipliers[i]);
      }
    }
    return true;
  }

  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* x, const Number*, const Number*, Index,
                         const Number*, const Number*, Number cost, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    unknowns_.assign(x, x + n);
    cost_ = cost;
  }

 private:
  using Jet = ceres::Jet<double, 3>;
  using JetOfJets = ceres::Jet<Jet, 3>;

  static double Squared(double x) { return x * x; }
  static Index CameraIndex(int camera) { return 3 * (camera - 1); }
  Index PointIndex(int point) const {
    return 3 * static_cast<Index>(problem_.camera_from_world.size() - 1) + 3 * point;
  }
  void Append(const Eigen::Vector3d& v) { unknowns_.insert(unknowns_.end(), v.data(), v.data() + 3); }

  Eigen::Vector3d Difference(const DistanceConstraint& held, const Number* x) const {
    return Eigen::Map<const Eigen::Vector3d>(x + CameraIndex(held.camera_a)) -
           Eigen::Map<const Eigen::Vector3d>(x + CameraIndex(held.camera_b));
  }

  /// Point minus centre.
  Eigen::Vector3d Offset(const BundleObservation& seen, const Number* x) const {
    const Eigen::Map<const Eigen::Vector3d> point(x + PointIndex(seen.point));
    if (seen.camera == 0) return point - Centre(problem_, 0);
    return point - Eigen::Map<const Eigen::Vector3d>(x + CameraIndex(seen.camera));
  }

  static Eigen::Matrix<Jet, 3, 1> JetUnits() { return {Jet(0, 0), Jet(0, 1), Jet(0, 2)}; }

  Eigen::Matrix3d Hessian(const BundleObservation& seen, const Number* x) const {
    const Eigen::Vector3d offset = Offset(seen, x);
    Eigen::Matrix<JetOfJets, 3, 1> variables;
    for (int i = 0; i < 3; ++i) variables[i] = JetOfJets(Jet(offset[i], i), i);
    const JetOfJets cost = Cost<JetOfJets>(seen, variables);
    Eigen::Matrix3d H;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) H(i, j) = cost.v[i].v[j];
    }
    return H;
  }

  template <typename T>
  static T Constant(double value) {
    if constexpr (std::is_same_v<T, JetOfJets>) {
      return JetOfJets(Jet(value));
    } else {
      return T(value);
    }
  }

  template <typename T>
  T Cost(const BundleObservation& seen, const Eigen::Matrix<T, 3, 1>& offset) const {
    const Eigen::Matrix3d R = problem_.camera_from_world[seen.camera].rotation.toRotationMatrix();
    Eigen::Matrix<T, 3, 1> in_camera;
    for (int i = 0; i < 3; ++i) {
      in_camera[i] =
          Constant<T>(R(i, 0)) * offset[0] + Constant<T>(R(i, 1)) * offset[1] + Constant<T>(R(i, 2)) * offset[2];
    }
    const Pinhole& pinhole = problem_.pinhole;
    const T inverse_sigma = Constant<T>(1.0 / seen.sigma);
    const T u = (Constant<T>(pinhole.fx) * in_camera[0] / in_camera[2] + Constant<T>(pinhole.cx - seen.pixel.x())) *
                inverse_sigma;
    const T v = (Constant<T>(pinhole.fy) * in_camera[1] / in_camera[2] + Constant<T>(pinhole.cy - seen.pixel.y())) *
                inverse_sigma;
    const T squared_norm = u * u + v * v;
    const T threshold = Constant<T>(huber_threshold_);
    if (squared_norm <= threshold * threshold) return Constant<T>(0.5) * squared_norm;
    return threshold * (sqrt(squared_norm) - Constant<T>(0.5) * threshold);
  }

  BundleProblem problem_;
  double huber_threshold_;
  std::vector<double> unknowns_;
  double cost_ = 0;
};

TEST(Ipopt, FindsTheSameConstrainedOptimum) {
  SyntheticDriveOptions drive_options;
  drive_options.cameras = 6;
  drive_options.points = 40;
  drive_options.observations = 200;
  drive_options.turn_every = 3;
  drive_options.turn_length = 2;
  BundleProblem start = MakeSyntheticDrive(drive_options).truth;
  Disturb(0.02, 0, 0.02, 2, start);
  DriftScale(1.1, 1.1, start);
  // Distances that the images contradict by some percent, so that the multipliers matter.
  start.distances = {{2, 1, 1.03}, {3, 4, 0.96}, {4, 5, 1.05}};

  BundleOptions options;
  options.fix_rotations = true;
  options.max_iterations = 30;
  options.relative_cost_tolerance = 0;
  options.kkt_tolerance = 1e-9;
  BundleProblem ours = start;
  const BundleSummary summary = AdjustBundle(options, ours);
  ASSERT_TRUE(summary.converged) << summary.message;

  auto* program = new RecoveryProgram(start, options.huber_threshold);
  const Ipopt::SmartPtr<Ipopt::TNLP> owner(program);
  Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = IpoptApplicationFactory();
  ipopt->Options()->SetIntegerValue("print_level", 0);
  ipopt->Options()->SetStringValue("sb", "yes");
  ipopt->Options()->SetIntegerValue("max_iter", 300);
  ipopt->Options()->SetNumericValue("tol", 1e-9);
  ASSERT_EQ(ipopt->Initialize(), Ipopt::Solve_Succeeded);
  const Ipopt::ApplicationReturnStatus status = ipopt->OptimizeTNLP(owner);
  ASSERT_TRUE(status == Ipopt::Solve_Succeeded || status == Ipopt::Solved_To_Acceptable_Level) << status;

  EXPECT_NEAR(summary.final_cost, program->cost(), 1e-8 * program->cost());
  for (std::size_t i = 1; i < ours.camera_from_world.size(); ++i) {
    const Eigen::Map<const Eigen::Vector3d> theirs(program->unknowns().data() + 3 * (i - 1));
    EXPECT_LT((Centre(ours, i) - theirs).norm(), 1e-5) << "camera " << i;
  }
  for (std::size_t i = 0; i < ours.points.size(); ++i) {
    const Eigen::Map<const Eigen::Vector3d> theirs(program->unknowns().data() +
                                                   3 * (ours.camera_from_world.size() - 1 + i));
    EXPECT_LT((ours.points[i] - theirs).norm(), 1e-5 * ours.points[i].norm()) << "point " << i;
  }
}

}  // namespace
}  // namespace turnscale
