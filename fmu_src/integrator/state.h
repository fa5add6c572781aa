// Everything that later steps depend on: a plain value, so that saving, restoring and comparing it is a copy.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "solve/block_lu.h"

namespace sigmafmu {

struct StepCounters {
  std::int64_t steps = 0;                 // internal steps done
  std::int64_t newton_iterations = 0;     // linear systems solved, those of rejected attempts included
  std::int64_t jacobian_evaluations = 0;  // matrices assembled and factorized
  std::int64_t retries = 0;               // attempts rejected and repeated with half the step
};

struct State {
  double time = 0;         // [s]
  double elapsed = 0;      // since the communication point from which InputSignal counts [s]
  Eigen::VectorXd q;       // per body p_WB [m], quat_WB (w, x, y, z)
  Eigen::VectorXd v;       // per body v_WB in W [m/s], w_WB_B in B [rad/s]
  Eigen::VectorXd vdot;    // [m/s2], [rad/s2]
  Eigen::VectorXd a;       // algorithmic acceleration, approximates Vdot(time + (alpha_m - alpha_f) last_step)
  Eigen::VectorXd lambda;  // multipliers [N or N m], joint after joint
  Eigen::VectorXd turned;  // coordinates of joints: angles with their turns [rad], displacements [m]
  double last_step = 0;    // step size for which `a`, the means below and jacobian hold [s]
  StepCounters counters;
  // BLieDF alone: theta/h and the change of V over h in the last step. V, Vdot, a and these belong to the group: on
  // SE(3) their translations are resolved in the body.
  Eigen::VectorXd mean_velocity, mean_acceleration;
  double next_step = 0;      // step size that error control proposes (0: none yet) [s]
  double error = 0;          // estimated position error of the last step, relative to the mechanism's size
  double largest_error = 0;  // of all steps since the start
  // Modified Newton alone: the matrix it keeps from step to step, and the step size it was made for (0: none yet).
  Factorization jacobian;
  double jacobian_step = 0;
};

}  // namespace sigmafmu
