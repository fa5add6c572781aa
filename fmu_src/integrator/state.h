// Everything that later steps depend on: a plain value, so that saving, restoring and comparing it is a copy.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "integrator/block_lu.h"

namespace sigmafmu {

struct StepCounters {
  std::int64_t steps = 0;                 // internal steps done
  std::int64_t newton_iterations = 0;     // linear systems solved, those of rejected attempts included
  std::int64_t jacobian_evaluations = 0;  // matrices assembled and factorized
  std::int64_t retries = 0;               // attempts rejected and repeated with half the step
};

struct State {
  double time = 0;         // [s]
  Eigen::VectorXd q;       // per body p_WB [m], quat_WB (w, x, y, z)
  Eigen::VectorXd v;       // per body v_WB in W [m/s], w_WB_B in B [rad/s]
  Eigen::VectorXd vdot;    // [m/s2], [rad/s2]
  Eigen::VectorXd a;       // algorithmic acceleration, approximates vdot(time + (alpha_m - alpha_f) a_step)
  Eigen::VectorXd lambda;  // multipliers [N or N m], joint after joint
  Eigen::VectorXd angle;   // per joint: angle of a revolute joint with its turns [rad], 0 for other joints
  double a_step = 0;       // step size for which `a` holds [s]
  StepCounters counters;
  // Modified Newton alone: the matrix it keeps from step to step, and the step size it was made for (0: none yet).
  Factorization jacobian;
  double jacobian_step = 0;
  // Predictor extrapolated alone: vdot and lambda one step before.
  Eigen::VectorXd vdot_old, lambda_old;
};

}  // namespace sigmafmu
