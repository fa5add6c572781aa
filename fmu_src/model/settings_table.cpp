#include "model/settings_table.h"

#include <limits>
#include <stdexcept>

namespace sigmafmu {

const std::vector<Enumeration>& enumerations() {
  static const std::vector<Enumeration> table = {
      {"Formulation",
       "Constraints that a step satisfies",
       {{"index3", "positions"},
        {"index2", "velocities; positions drift slowly"},
        {"stabilizedIndex2", "positions and velocities"}}},
      {"Corrector",
       "Form of the corrector",
       {{"residual", "the discrete equations solved exactly for every sigma; independent of the predictor"},
        {"incremental", "the increments of Algorithms 1 to 3 as printed, for reproducing the paper"}}},
      {"Jacobian",
       "Rotational part of the iteration matrix",
       {{"full", "exact derivative of the velocity with respect to the motion"},
        {"tangentFree", "no tangent operator"}}},
      {"Newton",
       "When the iteration matrix is made anew",
       {{"full", "in every step, and in every iteration that changes it"},
        {"modified", "when convergence becomes slow"}}},
      {"Method",
       "Integration method",
       {{"generalizedAlpha", "sigma-modified generalized-alpha, implicit, order 2"},
        {"rkmk4", "Runge-Kutta-Munthe-Kaas, explicit, order 4"},
        {"rkmk54", "Dormand-Prince as Munthe-Kaas method, explicit, order 5, with error control"},
        {"bliedf2", "BLieDF, backward differentiation on Lie groups, implicit, order 2"}}},
      {"Group",
       "Lie group of a rigid body's motion in a step",
       {{"R3xSO3", "translation in W, rotation"}, {"SE3", "screw motion; keeps lower pairs to the ground"}}},
      {"LocalCoordinates",
       "Coordinates of the motion in a step",
       {{"exp", "canonical: rotation vector or screw coordinates"},
        {"cayley", "Rodrigues parameters, on SE3 extended ones"},
        {"cayley2", "Wiener-Milenkovic parameters, second-order Cayley"}}},
      {"AbsoluteCoordinates",
       "Coordinates of the orientation from step to step",
       {{"quaternion", "unit quaternion"}, {"rotationVector", "rotation vector, at most pi long"}}},
      {"SigmaMode",
       "Which sigma a body has in a step",
       {{"fixed", "integrator.sigma"},
        {"spinOptimal",
         "the optimum of bodies that spin about a slowly turning principal axis; else integrator.sigma"}}},
      {"StepControl",
       "How internal steps are chosen",
       {{"fixed", "equal steps of at most integrator.stepSize"},
        {"error",
         "at most integrator.stepSize, and so that the estimated error of each keeps integrator.errorTolerance"}}},
  };
  return table;
}

using S = IntegratorSettings;

const std::vector<RealSetting>& real_settings() {
  constexpr double inf = std::numeric_limits<double>::infinity();
  static const std::vector<RealSetting> table = {
      // name, value, min, max, above min
      {"stepSize", &S::step_size, 0, inf, true},
      {"spectralRadius", &S::spectral_radius, 0, 1, false},
      {"sigma", &S::sigma, -inf, inf, false},
      {"absoluteTolerance", &S::absolute_tolerance, 0, inf, true},
      {"relativeTolerance", &S::relative_tolerance, 0, 1e-2, false},
      {"errorTolerance", &S::error_tolerance, 0, 0.1, true},
  };
  return table;
}

const std::vector<IntegerSetting>& integer_settings() {
  const auto choice = [](const char* name, int S::* value, const std::string& type) {
    for (const Enumeration& e : enumerations()) {
      if (e.name == type) return IntegerSetting{name, value, 1, static_cast<int>(e.items.size()), &e};
    }
    throw std::logic_error("no enumeration " + type);
  };
  static const std::vector<IntegerSetting> table = {
      {"maxNewtonIterations", &S::max_newton_iterations, 1, 1000, nullptr},
      {"maxHalvings", &S::max_halvings, 0, 20, nullptr},
      choice("method", &S::method, "Method"),
      choice("group", &S::group, "Group"),
      choice("localCoordinates", &S::local_coordinates, "LocalCoordinates"),
      choice("absoluteCoordinates", &S::absolute_coordinates, "AbsoluteCoordinates"),
      choice("formulation", &S::formulation, "Formulation"),
      choice("corrector", &S::corrector, "Corrector"),
      choice("jacobian", &S::jacobian, "Jacobian"),
      choice("newton", &S::newton, "Newton"),
      choice("sigmaMode", &S::sigma_mode, "SigmaMode"),
      choice("stepControl", &S::step_control, "StepControl"),
  };
  return table;
}

}  // namespace sigmafmu
