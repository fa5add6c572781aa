// Index-1 form of the equations of motion, and consistent values that follow from it.
//
//   [M  B^T] [vdot  ]   [-g      ]
//   [B  0  ] [lambda] = [-Z v - W]        (Phi'' = B vdot + Z v + W = 0)
//
// The same matrix projects positions and velocities onto the constraints with the least change in the mass metric.
//
// Where equations depend on each other the matrix has -e (multibody/constraints/compliance.h), for accelerations -100
// e, in place of their zeros. To solve again for what the equations then miss, with the same matrix, takes the
// compliance out of all that they agree on: each time that shrinks by e / (e + B M^-1 B^T), while the multipliers stay
// those of the springs. A ConsistentSolver owns its work space: one per thread. Nothing here allocates after
// construction.
#pragma once

#include "multibody/input_signal.h"
#include "multibody/system.h"
#include "solve/kkt_layout.h"

namespace sigmafmu {

class ConsistentSolver {
 public:
  explicit ConsistentSolver(const System& system, KktPlans plans = {});

  // vdot and lambda at (q, v, u). False when the matrix is singular to working precision or a value is not finite.
  [[nodiscard]] bool accelerations(const VectorXd& q, const VectorXd& v, const Inputs& u, VectorXd& vdot,
                                   VectorXd& lambda);
  // Whether it was the matrix that made accelerations() fail, and not a value.
  bool singular() const { return singular_; }
  // At the point of the last call: kinematics and constraints, after accelerations() also Z.
  const Evaluation& evaluation() const { return evaluation_; }

  // A point displaced along the motion by time s: q o exp(s v + s^2/2 vdot), v + s vdot.
  void displace(const VectorXd& q, const VectorXd& v, const VectorXd& vdot, double s, VectorXd& q_s,
                VectorXd& v_s) const;
  // A time [s] small against the motion: central differences along it are accurate to about 1e-8.
  double difference_time(const VectorXd& v) const;
  // d(vdot)/dt along the motion at time t, by central difference.
  [[nodiscard]] bool jerk(const VectorXd& q, const VectorXd& v, const VectorXd& vdot, const InputSignal& input,
                          const VectorXd& turned, double t, VectorXd& vddot);

  // Moves q onto Phi(q) = 0; false when it cannot be reached. `worst_joint` is the one with the largest residual.
  struct Assembly {
    bool possible;
    int worst_joint;
    double residual;  // largest |Phi| [m or 1]
    int iterations;
  };
  Assembly project_positions(const Inputs& u, VectorXd& q);
  // Moves v onto Phi' = 0.
  [[nodiscard]] bool project_velocities(const VectorXd& q, const Inputs& u, VectorXd& v);

 private:
  // `positions`: without the equations of velocities alone, whose rows of B are zero then.
  bool factorize(double compliance = 1, bool positions = false);
  void solve();
  bool soft() const { return !soft_.empty(); }
  double constraint_defect();
  [[nodiscard]] bool solve_accelerations(double compliance, double tolerable, const Inputs& u, VectorXd& vdot,
                                         VectorXd& lambda);
  [[nodiscard]] bool refine(double tolerable, const Inputs& u, VectorXd& vdot, VectorXd& lambda);
  Eigen::Map<VectorXd> motion() { return {x_.data(), system_.velocity_size()}; }
  Eigen::Map<VectorXd> multipliers() { return {x_.data() + system_.velocity_size(), system_.constraint_size()}; }

  const System& system_;
  Evaluation evaluation_;
  std::shared_ptr<const BlockLU> lu_;
  Factorization factorization_;
  bool singular_ = false;
  VectorXd x_, zero_velocity_, zero_lambda_, r_;
  std::vector<int> pairs_, rows_, columns_;  // where blocks of the pattern are in the factorization
  struct SoftEquation {
    int place;  // in the factorization, on the diagonal
    double compliance;
  };
  std::vector<SoftEquation> soft_;
  std::vector<int> velocity_diagonals_;  // in the factorization
  VectorXd gamma_, defect_;              // -Z v - W and what B vdot misses of it
  Inputs u_;
  VectorXd q_s_, v_s_, lambda_s_, vdot_minus_, vdot_plus_;
};

}  // namespace sigmafmu
