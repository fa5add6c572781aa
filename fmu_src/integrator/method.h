// A time integration method: one internal step maps a State to the State at the end of it. What it remembers from step
// to step is in State. V, Vdot are velocities and accelerations of the group (coordinates/local_coordinates.h).
//
// A method owns its work space: one per thread. attempt() does not allocate.
#pragma once

#include "integrator/state.h"
#include "integrator/step_failure.h"
#include "multibody/input_signal.h"

namespace sigmafmu {

// How step control (step_control.h) chooses the steps of a method that measures its error.
struct ErrorControl {
  int order = 0;                // the error grows as h to this power; 0: no control
  double largest_growth = 5.0;  // how many times longer than a step the next one may be
};

class IntegrationMethod {
 public:
  virtual ~IntegrationMethod() = default;

  // Sizes what the method remembers; no values but zeros.
  virtual void make_state(State& state) const = 0;
  // Remembers a start with V, Vdot and its derivative; state.last_step is the step size to expect.
  virtual void start(State& state, const Eigen::VectorXd& V, const Eigen::VectorXd& Vdot,
                     const Eigen::VectorXd& jerk) const = 0;
  // One step of h. On failure the state is as before, but for its counters, and `failure` tells why. With error control
  // failure.measure is the error over its tolerance, and above 1 a failure as `inaccurate`.
  [[nodiscard]] virtual bool attempt(State& state, double h, const InputSignal& input, StepFailure& failure) = 0;
  // Adds a jump of Vdot (after a jump of loads) to all that is remembered of it.
  virtual void jump(State& state, const Eigen::VectorXd& dVdot) const = 0;

  const ErrorControl error_control;

 protected:
  explicit IntegrationMethod(const ErrorControl& control) : error_control(control) {}
};

}  // namespace sigmafmu
