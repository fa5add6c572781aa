#include "integrator/methods/bliedf.h"

namespace sigmafmu {

// A mean over a short step has the error of its positions, as far as constraints hold them, over h: that of the method
// in index 3, else rounding.
BLieDF::BLieDF(Problem& problem)
    : IntegrationMethod(StepEnds::error_control(problem.settings)),
      memory_(problem.settings.is(Formulation::index3) ? StepEnds::kMemory : 1e4),
      ends_(problem),
      newton_(problem),
      start_(problem.system),
      equations_(problem.system, false, 1.0),
      at_(problem.system, problem.coordinates->mixed) {}

void BLieDF::make_state(State& s) const {
  for (VectorXd* x : {&s.mean_velocity, &s.mean_acceleration}) *x = s.v;
  newton_.make_state(s);
}

// The step before the first: the motion continued backwards to second order.
void BLieDF::start(State& s, const VectorXd& V, const VectorXd& Vdot, const VectorXd& jerk) const {
  const double h = s.last_step;
  s.mean_velocity = V - (h / 2) * Vdot + (h * h / 6) * jerk;
  s.mean_acceleration = Vdot - (h / 2) * jerk;
  s.jacobian_step = 0;
}

// As if the loads after the jump had acted before it as well.
void BLieDF::jump(State& s, const VectorXd& dVdot) const {
  s.mean_acceleration += dVdot;
  s.mean_velocity -= (s.last_step / 2) * dVdot;
}

bool BLieDF::attempt(State& s, double h, const InputSignal& input, StepFailure& failure) {
  if (h < StepEnds::kDrift) {
    if (!ends_.drift(s, h, input, failure)) return false;
    s.mean_velocity += ends_.dV();
    s.mean_acceleration += ends_.dVdot();
    return true;
  }
  if (!ends_.begin(s, h, memory_, input, start_, failure)) return false;
  set_equations(s);
  // The prediction: Vdot_n at the end as well.
  const auto& [scales, transported, sigma, c, offset, slope] = equations_;
  at_.theta = c + (start_.V + (start_.Vdot - offset) / slope) / slope;
  at_.lambda = start_.lambda;
  if (!newton_.solve(start_, equations_, s, at_, failure)) return false;
  const double position_error = start_.fresh ? 1.0 / 12.0 : 2.0 / 9.0;
  if (!ends_.complete(start_, position_error, newton_, at_, s, failure)) return false;
  s.mean_velocity = at_.theta / h;
  s.mean_acceleration = (at_.V - start_.V) / h;
  return true;
}

void BLieDF::set_equations(const State& s) {
  const double h = start_.h;
  StepEquations& e = equations_;
  if (start_.fresh) {  // the trapezoidal rule
    e.slope = 2 / h;
    e.offset = -start_.Vdot;
    e.c = (h / 2) * start_.V;
  } else {
    const double omega = h / (h + s.last_step);
    e.slope = (1 + omega) / h;
    e.offset = -omega * s.mean_acceleration;
    e.c = (omega / e.slope) * s.mean_velocity;
  }
  e.scales = {e.slope, e.slope * e.slope, 1 / (e.slope * e.slope)};
}

}  // namespace sigmafmu
