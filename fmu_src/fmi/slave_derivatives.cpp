// Derivatives of inputs and outputs in time, and of outputs by inputs.
#include <algorithm>
#include <cmath>

#include "fmi/slave.h"
#include "text/text.h"

namespace sigmafmu {

void Slave::set_input_derivatives(const unsigned* references, std::size_t count, const int* orders,
                                  const double* values) {
  for (std::size_t i = 0; i < count; ++i) {
    const Port& v = variable(references[i]);
    if (!v.is_input()) fail<Refused>(v.name, " is no input; derivatives can be set for inputs alone.");
    if (orders[i] < 1 || orders[i] > InputSignal::kMaxDerivative) {
      fail<Refused>("The derivative order of ", v.name, " is ", orders[i], "; it must be 1 to ",
                    InputSignal::kMaxDerivative, ".");
    }
    if (!std::isfinite(values[i])) {
      fail<Refused>("Derivative ", orders[i], " of ", v.name, " is ", values[i], "; it must be finite.");
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Port& v = variables_[references[i]];
    if (v.input >= 0) {
      data_.input.derivative[orders[i]][v.input] = values[i];
    } else {
      data_.input.drive[v.derivative + orders[i]][v.prescribed] = values[i];
    }
  }
  data_.state.elapsed = 0;
  if (data_.phase != Phase::step) data_.stale = true;
}

const Port& Slave::real_output(unsigned reference, const char* purpose) const {
  const Port& v = variable(reference);
  if (!v.output || v.integer) fail<Refused>(v.name, " is no Real output; ", purpose, " of Real outputs alone.");
  return v;
}

void Slave::get_output_derivatives(const unsigned* references, std::size_t count, const int* orders, double* values) {
  bool accelerations = false;
  for (std::size_t i = 0; i < count; ++i) {
    const Port& v = real_output(references[i], "derivatives can be had");
    if (orders[i] != 1) fail<Refused>("The derivative order of ", v.name, " is ", orders[i], "; it must be 1.");
    accelerations = accelerations || v.needs_accelerations;
  }
  evaluate(true);  // vdot
  const State& s = data_.state;
  const System& system = engine_->system;
  VectorXd q(s.q.size()), v(s.v.size()), vdot(s.v.size()), lambda(s.lambda.size());
  Inputs u = system.make_inputs();
  Evaluation e = system.make_evaluation();
  OutputValues outputs(variables_);
  std::fill_n(values, count, 0.0);
  const double step = engine_->solver.difference_time(s.v);
  for (double sign : {-1.0, 1.0}) {  // central difference along the motion; outputs are functions of (q, v, u) alone
    engine_->solver.displace(s.q, s.v, engine_->vdot, sign * step, q, v);
    data_.input.value(s.elapsed + sign * step, s.turned, u);
    if (accelerations) accelerations_or_discard(q, v, u, vdot, lambda);
    system.evaluate(q, v, u, e);
    const SlaveView displaced{{mechanism_, system, q, v, u, e, vdot, lambda}, s};
    outputs.forget();
    for (std::size_t i = 0; i < count; ++i) {
      values[i] += sign * outputs(variables_[references[i]], displaced) / (2 * step);
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Port& variable = variables_[references[i]];
    if (variable.rate) values[i] = variable.rate(view(), variable.object, variable.component);
  }
}

void Slave::directional_derivative(const unsigned* outputs, std::size_t output_count, const unsigned* inputs,
                                   std::size_t input_count, const double* direction, double* derivative) {
  evaluate(false);
  const State& s = data_.state;
  const System& system = engine_->system;
  Inputs du = engine_->u;
  for (VectorXd* x : {&du.u, &du.xdot, &du.xddot}) x->setZero();
  for (std::size_t i = 0; i < input_count; ++i) {
    const Port& v = variable(inputs[i]);
    if (!v.is_input())
      fail<Refused>(v.name, " is no input; directional derivatives exist with respect to inputs alone.");
    if (!std::isfinite(direction[i])) fail<Refused>("The direction of ", v.name, " must be finite.");
    if (v.input >= 0) {
      du.u[v.input] += direction[i];
    } else if (v.derivative == 2) {  // positions and rates that are prescribed are those of the present point
      du.xddot[v.prescribed] += direction[i];
    }
  }
  for (std::size_t i = 0; i < output_count; ++i) real_output(outputs[i], "directional derivatives exist");
  // Accelerations and multipliers are affine in u with a slope that q alone determines: a difference over any length is
  // exact, and without velocities it loses no digits to the gyroscopic terms.
  const VectorXd rest = VectorXd::Zero(s.v.size());
  VectorXd vdot(s.v.size()), lambda(s.lambda.size());
  Evaluation e = system.make_evaluation();
  system.evaluate(s.q, rest, du, e);
  // Powers are these times the velocities that there are.
  Evaluation moving = system.make_evaluation();
  system.evaluate(s.q, s.v, du, moving);
  OutputValues values(variables_), powers(variables_);
  std::fill_n(derivative, output_count, 0.0);
  for (double sign : {1.0, -1.0}) {
    accelerations_or_discard(s.q, rest, du, vdot, lambda);
    const SlaveView probed{{mechanism_, system, s.q, rest, du, e, vdot, lambda}, s};
    const SlaveView with_velocities{{mechanism_, system, s.q, s.v, du, moving, vdot, lambda}, s};
    values.forget();
    powers.forget();
    for (std::size_t i = 0; i < output_count; ++i) {
      const Port& v = variables_[outputs[i]];
      if (v.times_velocity) {
        derivative[i] += 0.5 * sign * powers(v, with_velocities);
      } else if (v.needs_accelerations) {
        derivative[i] += 0.5 * sign * values(v, probed);
      }
    }
    du.u = -du.u;
    du.xddot = -du.xddot;
  }
}

}  // namespace sigmafmu
