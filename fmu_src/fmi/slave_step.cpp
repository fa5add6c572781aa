// Communication steps.
#include <algorithm>
#include <cmath>
#include <limits>

#include "fmi/slave.h"
#include "solve/start/dependent_equations.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

constexpr double kMaxInternalSteps = 1e9;  // per communication step

// Communication points come from masters that add them up, multiply or count nanoseconds: their rounding, which grows
// with the time, is no mistake.
bool same_time(double a, double b, double step) {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  return std::abs(a - b) <= 1e-4 * step + 4 * kEpsilon * std::max(std::abs(a), std::abs(b));
}

// Why an internal step failed, as part of a sentence; `body` is the one to blame.
std::string reason(const StepFailure& f, const std::string& body) {
  using Reason = StepFailure::Reason;
  std::ostringstream text = text_stream(10);
  switch (std::isfinite(f.measure) ? f.reason : Reason::not_finite) {
    case Reason::rotation:
      text << "body " << body << " would turn by " << f.measure << " rad in it, less than pi is allowed";
      break;
    case Reason::singular:
      text << "the iteration matrix is singular";
      break;
    case Reason::inaccurate:
      text << "its error is estimated as " << f.measure << " times the tolerance, largest in body " << body;
      break;
    case Reason::not_finite:
      text << "the motion of body " << body << " is not finite";
      break;
    default:
      text << "Newton's method did not converge in " << f.iterations
           << (f.iterations == 1 ? " iteration" : " iterations") << ", the last increment of body " << body << " is "
           << f.measure << " times the tolerance";
  }
  return text.str();
}

}  // namespace

void Slave::check_step(double t, double H) const {
  const State& s = data_.state;
  if (!std::isfinite(t) || !std::isfinite(H) || H < 0) {
    fail<Refused>("The communication step from ", t, " s by ", H, " s is not possible; both must be finite, the step ",
                  "not negative.");
  }
  const double h = mechanism_.integrator.step_size;
  if (!same_time(t, s.time, std::max(H, h))) {
    fail<Refused>("The communication point is ", t, " s, but the FMU is at ", s.time, " s.");
  }
  if (data_.has_stop_time && t + H > data_.stop_time && !same_time(t + H, data_.stop_time, std::max(H, h))) {
    fail<Refused>("The communication step ends at ", t + H, " s, after the stopTime ", data_.stop_time, " s.");
  }
  if (H / h > kMaxInternalSteps) {
    fail<Refused>("The communication step is ", H, " s; with integrator.stepSize ", h, " s at most ",
                  kMaxInternalSteps * h, " s is allowed.");
  }
}

bool Slave::do_step(double t, double H) {
  check_step(t, H);
  State& s = data_.state;
  if (H == 0) {
    s.time = t;
    return true;
  }
  const double ratio = H / mechanism_.integrator.step_size;
  const std::int64_t n = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(ratio * (1 - 1e-9) - 1e-9)));
  s.time = t;
  s.elapsed = 0;
  data_.input.start = t - data_.start_time;
  absorb_jump();
  forget_outputs();
  const std::int64_t retries = s.counters.retries;
  const bool ok = internal_steps(t, H, n);
  data_.input.value(s.elapsed, s.turned, data_.last_input);
  data_.input.continue_from(data_.last_input, s.elapsed);  // where the derivatives led is what holds from here on
  s.elapsed = 0;
  if (ok) remarks_.about_step(mechanism_, s, H / static_cast<double>(n));
  remarks_.about_retries(s.counters.retries - retries, t + H);
  return ok;
}

bool Slave::internal_steps(double t, double H, std::int64_t n) {
  State& s = data_.state;
  const double h = H / static_cast<double>(n);
  for (std::int64_t i = 1; i <= n; ++i) {
    StepFailure failure;
    if (!engine_->integrator->step(s, h, data_.input, failure)) {
      describe_failure(failure);
      return false;
    }
    s.elapsed = H * (static_cast<double>(i) / static_cast<double>(n));  // not a sum of internal steps
    s.time = t + s.elapsed;
  }
  return true;
}

// After a jump of inputs or tunable parameters vdot and the algorithmic acceleration jump with the loads; without
// this a step would take the old loads for half of the new ones.
void Slave::absorb_jump() {
  State& s = data_.state;
  Engine& e = *engine_;
  data_.input.value(s.elapsed, s.turned, e.u);
  if (!data_.parameter_jump && e.u.acts_like(data_.last_input)) return;
  if (data_.parameter_jump) {
    e.vdot_before = data_.vdot_before_jump;
  } else {
    accelerations_or_discard(s.q, s.v, data_.last_input, e.vdot_before, e.lambda_scratch);
  }
  if (!e.u.prescribes_like(data_.last_input)) move_to_prescribed();
  accelerations_or_discard(s.q, s.v, e.u, e.vdot_after, e.lambda_scratch);
  e.vdot_after -= e.vdot_before;
  e.integrator->shift_accelerations(s, e.vdot_after);
  data_.parameter_jump = false;
  data_.last_input = e.u;
}

// Where a master prescribes another position or rate than that of the last step's end, the mechanism moves there by
// the least motion and the least impulses.
void Slave::move_to_prescribed() {
  State& s = data_.state;
  Engine& e = *engine_;
  e.q_scratch = s.q;
  if (e.u.x != data_.last_input.x && !e.solver.project_positions(e.u, e.q_scratch).possible) {
    fail<Discarded>("At t = ", s.time, " s the mechanism cannot follow what is prescribed.");
  }
  e.v_scratch = s.v;
  if (!e.solver.project_velocities(e.q_scratch, e.u, e.v_scratch)) {
    fail<Discarded>("At t = ", s.time, " s the mechanism cannot follow the rates that are prescribed.");
  }
  s.q = e.q_scratch;
  s.v = e.v_scratch;
}

// The step has failed whether or not there is memory to say why.
void Slave::describe_failure(const StepFailure& f) noexcept {
  try {
    const std::string none, &body = f.body >= 0 ? mechanism_.multibody.bodies[f.body].name : none;
    std::ostringstream text = text_stream(10);
    text << "The internal step to t = " << f.time << " s failed even with a step size of " << f.step_size
         << " s: " << reason(f, body) << "; the last successful time is " << data_.state.time << " s.";
    constexpr double kNearlyFlat = 0.05;
    const VectorXd& q = data_.state.q;
    std::string position = describe_flat_disk(mechanism_.multibody, engine_->system, q, kNearlyFlat);
    if (position.empty() && f.reason != StepFailure::Reason::not_finite) position = describe_position();
    if (!position.empty()) text << ' ' << position;
    message_ = text.str();
  } catch (...) {
    message_.clear();  // message() knows
  }
}

// What is to be said of the position from which a step failed; nothing when it is a fair one.
std::string Slave::describe_position() {
  const State& s = data_.state;
  Engine& e = *engine_;
  std::string text = describe_nearness(e.system, s.q);
  if (!text.empty()) return text;
  if (e.solver.accelerations(s.q, s.v, data_.last_input, e.vdot_before, e.lambda_scratch) || !e.solver.singular()) {
    return {};
  }
  return describe_singularity(mechanism_.multibody, e.system, s.q);
}

}  // namespace sigmafmu
