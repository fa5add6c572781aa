#include "fmi/remarks.h"

#include "multibody/system.h"
#include "solve/start/assembly.h"
#include "solve/start/dependent_equations.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kLargeError = 3e-4;  // of an internal step, relative to the mechanism's size: warn
constexpr double kLargeTurn = 1.0;    // of a body in an internal step [rad]: warn

double spin(const State& s, int body) { return s.v.segment<3>(kVelocitiesPerBody * body + 3).norm(); }

template <typename... Parts>
std::string short_text(const Parts&... parts) {
  std::ostringstream stream = text_stream(6);
  (stream << ... << parts);
  return stream.str();
}

}  // namespace

template <typename MakeText>
void Remarks::tell(MakeText make_text) noexcept {
  if (!listener_ || !listener_->wants_events()) return;
  try {
    listener_->event(make_text().c_str());
  } catch (...) {
    listener_->event(kNoMemory);
  }
}

template <typename MakeText>
void Remarks::warn(MakeText make_text) noexcept {
  if (!listener_) return;
  try {
    const std::string text = make_text();
    if (!text.empty()) listener_->warning(text.c_str());
  } catch (...) {
    listener_->warning(kNoMemory);
  }
}

void Remarks::about_start(const Mechanism& mechanism, const System& system, ConsistentSolver& solver,
                          const State& s) noexcept {
  warned_of_error_ = warned_of_spin_ = false;
  warn([&] { return describe_moved_values(mechanism.multibody, system, solver, s.q, s.v); });
  if (system.compliance().dependent > 0) {
    tell([&] { return describe_dependence(mechanism.multibody, system, s.q); });
  }
  const IntegratorSettings& settings = mechanism.integrator;
  for (int i = 0; i < system.body_count(); ++i) {
    const double w = spin(s, i);
    if (!(w * settings.step_size > kPi)) continue;
    warned_of_spin_ = true;
    warn([&] {
      return short_text("integrator.stepSize is ", settings.step_size, " s, but ", mechanism.multibody.bodies[i].name,
                        " spins at ", w,
                        " rad/s: internal steps must be halved until the rotation in one is below pi; ",
                        "choose at most ", kPi / w / 4, " s.");
    });
  }
  if (settings.is(Formulation::index3) && settings.spectral_radius == 1.0 && system.constraint_size() > 0) {
    warn([] {
      return std::string(
          "integrator.formulation index3 with integrator.spectralRadius 1 lets the multipliers oscillate; use a "
          "smaller spectral radius or stabilizedIndex2.");
    });
  }
}

void Remarks::about_step(const Mechanism& mechanism, const State& s, double h) noexcept {
  if (!warned_of_error_ && s.largest_error > kLargeError) {
    warned_of_error_ = true;
    warn([&] {
      return short_text("Up to t = ", s.time, " s the position error of an internal step of ", h, " s is estimated as ",
                        s.largest_error, " of the mechanism's size, more than ", kLargeError,
                        ": choose a smaller integrator.stepSize, or integrator.stepControl error.");
    });
  }
  const auto& bodies = mechanism.multibody.bodies;
  for (std::size_t i = 0; !warned_of_spin_ && i < bodies.size(); ++i) {
    const double w = spin(s, static_cast<int>(i));
    if (!(w * h > kLargeTurn)) continue;
    warned_of_spin_ = true;
    warn([&] {
      return short_text(bodies[i].name, " spins at ", w, " rad/s at t = ", s.time, " s and turns by ", w * h,
                        " rad in an internal step, more than ", kLargeTurn,
                        ": choose an integrator.stepSize of at most ", 0.5 * kLargeTurn / w, " s.");
    });
  }
}

void Remarks::about_retries(std::int64_t retries, double t) noexcept {
  if (retries == 0) return;
  tell([&] {
    return short_text("The communication step to ", t, " s needed ", retries,
                      " repeated internal steps with half the step size.");
  });
}

}  // namespace sigmafmu
