// What a user can choose of the integrator.
#pragma once

namespace sigmafmu {

// Values are those of the FMU's enumerations (integrator.formulation, ...), which count from 1.
enum class Formulation { index3 = 1, index2, stabilized_index2 };
enum class Corrector { residual = 1, incremental };
enum class Jacobian { full = 1, tangent_free };
enum class Newton { full = 1, modified };
enum class Method { generalized_alpha = 1, rkmk4, rkmk54, bliedf2 };
enum class LieGroup { r3xso3 = 1, se3 };
enum class CoordinateMap { exponential = 1, cayley, cayley2 };
enum class AbsoluteCoordinates { quaternion = 1, rotation_vector };
enum class SigmaMode { fixed = 1, spin_optimal };
enum class StepControl { fixed = 1, error };

struct IntegratorSettings {
  double step_size = 1e-3;            // h: largest internal step [s]
  double spectral_radius = 0.9;       // rho_inf in [0, 1]
  double sigma = 1.0;                 // Eq. (13); in mode spin_optimal of bodies for which there is no better one
  double absolute_tolerance = 1e-10;  // Newton: velocity increments [m/s], [rad/s]; rkmk54: error of a step
  double relative_tolerance = 1e-8;   // the same, relative to each body's velocity
  int max_newton_iterations = 20;     // per attempt at an internal step, then the step is halved
  int max_halvings = 10;              // of an internal step; the shortest attempt is h / 2^max_halvings
  int method = static_cast<int>(Method::generalized_alpha);
  int group = static_cast<int>(LieGroup::r3xso3);
  int local_coordinates = static_cast<int>(CoordinateMap::exponential);
  int absolute_coordinates = static_cast<int>(AbsoluteCoordinates::quaternion);
  int formulation = static_cast<int>(Formulation::stabilized_index2);
  int corrector = static_cast<int>(Corrector::residual);
  int jacobian = static_cast<int>(Jacobian::full);
  int newton = static_cast<int>(Newton::full);
  int sigma_mode = static_cast<int>(SigmaMode::fixed);
  int step_control = static_cast<int>(StepControl::fixed);
  double error_tolerance = 1e-8;  // of an internal step, with step_control error: position over the mechanism's size

  bool is(Method m) const { return method == static_cast<int>(m); }
  bool is(LieGroup g) const { return group == static_cast<int>(g); }
  bool is(CoordinateMap m) const { return local_coordinates == static_cast<int>(m); }
  bool is(AbsoluteCoordinates a) const { return absolute_coordinates == static_cast<int>(a); }
  bool is(Formulation f) const { return formulation == static_cast<int>(f); }
  bool is(Corrector c) const { return corrector == static_cast<int>(c); }
  bool is(Jacobian j) const { return jacobian == static_cast<int>(j); }
  bool is(Newton n) const { return newton == static_cast<int>(n); }
  bool is(SigmaMode m) const { return sigma_mode == static_cast<int>(m); }
  bool is(StepControl c) const { return step_control == static_cast<int>(c); }
};

}  // namespace sigmafmu
