// Parameters of the generalized-alpha family.
#pragma once

#include "solve/newton_matrix.h"

namespace sigmafmu {

struct AlphaParameters {
  double alpha_m, alpha_f, beta, gamma;

  // Chung and Hulbert's for a spectral radius rho at infinite frequency.
  explicit AlphaParameters(double rho) : alpha_m((2 * rho - 1) / (rho + 1)), alpha_f(rho / (rho + 1)) {
    gamma = 0.5 + alpha_f - alpha_m;
    beta = 0.25 * (gamma + 0.5) * (gamma + 0.5);
  }
  // The trapezoidal rule, whose algorithmic acceleration is vdot itself.
  static AlphaParameters trapezoidal() {
    AlphaParameters p(1.0);
    p.alpha_m = p.alpha_f = 0.0;
    return p;
  }
  // gamma' and beta' of a step of h: Eq. (64).
  StepScales scales(double h) const {
    return {gamma / (h * beta), (1 - alpha_m) / (h * h * beta * (1 - alpha_f)), beta * h * h};
  }
  // a_n approximates vdot(t_n + shift h).
  double shift() const { return alpha_m - alpha_f; }
  // A step's error in positions over h^3 and the derivative of vdot: C_q of (41).
  double position_error() const { return (1 - 6 * beta - 3 * shift()) / 6; }
};

}  // namespace sigmafmu
