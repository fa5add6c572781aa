// corrector = incremental, for reproducing the paper: Algorithms 1 (index 3), 3 (stabilized index 2) and 2 (sigma != 1)
// of Holzinger, Arnold, Gerstmayr 2025 as printed. They add increments to V and Vdot and never evaluate (12) again, so
// their leading error depends on what they start from (docs/study.md). Of sigma there is one for all bodies.
#pragma once

#include "integrator/implicit/step_ends.h"
#include "integrator/methods/alpha_parameters.h"
#include "integrator/printed/printed_coordinates.h"

namespace sigmafmu {

class PrintedAlgorithms final : public IntegrationMethod {
 public:
  explicit PrintedAlgorithms(Problem& problem);

  void make_state(State& state) const override;
  void start(State& state, const VectorXd& V, const VectorXd& Vdot, const VectorXd& jerk) const override;
  [[nodiscard]] bool attempt(State& state, double h, const InputSignal& input, StepFailure& failure) override;
  void jump(State& state, const VectorXd& dVdot) const override { state.a += dVdot; }

 private:
  void predict(const AlphaParameters& parameters, const State& state);
  bool iterate(State& state, StepFailure& failure);
  void correct(const VectorXd& q_n, const VectorXd& x);
  void find_a(const AlphaParameters& parameters, VectorXd& a) const;

  const Problem& problem_;
  const AlphaParameters alpha_, trapezoidal_ = AlphaParameters::trapezoidal();
  const std::unique_ptr<const PrintedCoordinates> printed_;
  StepEnds ends_;
  NewtonMethod newton_;
  StepStart start_;
  StepEquations equations_;  // scales and sigma alone
  Iterate at_;               // mu: its last increment
  BodyTangents tangents_;
  VectorXd a_n_, a_, dV_;
};

}  // namespace sigmafmu
