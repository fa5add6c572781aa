// A time integration method for a System: one internal step maps a State to the State at the end of it.
//
// An Integrator owns its work space: one per thread. step() does not allocate.
#pragma once

#include <memory>

#include "integrator/error_measure.h"
#include "integrator/local_coordinates.h"
#include "integrator/state.h"
#include "solve/index1.h"

namespace sigmafmu {

struct StepFailure {
  enum class Reason { none, rotation, singular, not_finite, no_convergence, inaccurate };
  Reason reason = Reason::none;
  double time = 0;       // end of the step that failed [s]
  double step_size = 0;  // [s]
  int body = -1;         // with the largest scaled increment, error or rotation
  double measure = 0;    // rotation in the step [rad]; last increment or estimated error over its tolerance
  int iterations = 0;
};

class Integrator {
 public:
  virtual ~Integrator() = default;

  // Sizes a State; no values but zeros, unit quaternions and zero counters.
  virtual State make_state() const;
  // Completes a state whose q and v are consistent: vdot, lambda, angles and what the method remembers.
  [[nodiscard]] bool initialize(State& state, const InputSignal& input);
  // Adds a jump of vdot (after a jump of inputs or parameters) to all that depends on it.
  virtual void shift_accelerations(State& state, const VectorXd& jump);

  // One internal step of h [s]. Attempts that fail are repeated with halved steps; with error control it is divided
  // into steps whose errors keep the tolerance. When that fails too, false is returned, the state stays where the last
  // good step ended and `failure` tells why. The counters count every attempt.
  [[nodiscard]] bool step(State& state, double h, const InputSignal& input, StepFailure& failure);

 protected:
  Integrator(const System& system, const IntegratorSettings& settings, KktPlans plans);

  // One step of h. On failure the state is as before, but for its counters.
  [[nodiscard]] virtual bool attempt(State& state, double h, const InputSignal& input, StepFailure& failure) = 0;
  // Step size control: an attempt tells its error over the tolerance, which grows as h to this power, in
  // failure.measure, and fails as `inaccurate` where that is above 1. 0: no control.
  virtual int control_order() const { return 0; }
  // How many times longer than a step the next one may be at most.
  virtual double largest_growth() const { return 5.0; }
  // The rest of initialize(): Vdot and its derivative, of the group's velocities V.
  virtual void remember_start(State&, const VectorXd& /*V*/, const VectorXd& /*Vdot*/, const VectorXd& /*jerk*/) {}

  // A jump of vdot as one of Vdot, valid until the next call.
  const VectorXd& jump_of_group(const State& state, const VectorXd& jump);
  // False, with the reason in `failure`, when theta turns a body by pi or more: coordinates are not one-to-one there.
  [[nodiscard]] bool unambiguous(const VectorXd& theta, StepFailure& failure) const;
  // Takes over q, v, the turns of revolute joints, `e` being the evaluation at q and v, and the step's error.
  void commit(State& state, double h, const VectorXd& q, const VectorXd& v, const Evaluation& e, double error);

  const System& system_;
  const IntegratorSettings settings_;
  std::unique_ptr<LocalCoordinates> coordinates_;
  ConsistentSolver solver_;
  ErrorMeasure measure_;

 private:
  bool fixed_step(State& state, double h, const InputSignal& input, StepFailure& failure);
  bool controlled_step(State& state, double h, const InputSignal& input, StepFailure& failure);

  VectorXd jump_;
};

std::unique_ptr<Integrator> make_integrator(const System& system, const IntegratorSettings& settings,
                                            KktPlans plans = {});

}  // namespace sigmafmu
