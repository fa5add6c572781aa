// The one table of a mechanism's variables: names, units, limits, causalities, and how each is read or set.
//
// modelDescription.xml, the getters and setters, start values and dependencies all come from it.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "integrator/state.h"
#include "mechanism.h"
#include "multibody/system.h"

namespace sigmafmu {

// A unit with its SI exponents and the units that people like to see it in: shown = factor * value.
struct Unit {
  const char* name;
  int kg, m, s, rad;
  struct Display {
    const char* name;
    double factor;
  };
  std::vector<Display> displays;
};
const std::vector<Unit>& units();

// Sizes that the definition of a mechanism tells, for nominal values; 0 where it tells nothing.
struct Scales {
  double length = 0;            // farthest body, node, joint or attachment point [m]
  double velocity = 0;          // fastest body at the start [m/s]
  double angular_velocity = 0;  // at the start [rad/s]
  double force = 0;             // weight of all bodies [N]
  double torque = 0;            // that weight at that length [N m]
};
Scales scales(const MultibodyDef& definition);

// What a Real variable measures.
struct RealType {
  const char* name;
  const char* quantity;      // as in the Modelica Standard Library
  const char* unit;          // of units()
  const char* display_unit;  // of that unit's displays, or null
  double min, max;
  double Scales::* nominal;  // or null
};
const std::vector<RealType>& real_types();

struct Enumeration {
  const char* name;
  const char* description;
  struct Item {
    const char* name;
    const char* description;
  };
  std::vector<Item> items;  // values 1, 2, ...
};
const std::vector<Enumeration>& enumerations();

// What outputs are computed from: one consistent point (q, v, u) and all that follows from it.
struct View {
  const Mechanism& mechanism;
  const System& system;
  const State& state;
  const VectorXd& q;
  const VectorXd& v;
  const Evaluation& evaluation;  // at (q, v)
  const VectorXd& vdot;          // index-1 accelerations and multipliers; valid if the variable needs them
  const VectorXd& lambda;
};

enum class Causality { parameter, input, output };
enum class Variability { fixed, tunable, continuous, discrete };

struct Variable {
  std::string name;
  std::string description;
  Causality causality = Causality::output;
  Variability variability = Variability::continuous;
  const RealType* type = nullptr;  // null for integers
  const char* unit = nullptr;      // of that type
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above_min = false;  // min itself is not allowed
  bool integer = false;    // Integer or Enumeration
  const Enumeration* enumeration = nullptr;
  bool needs_accelerations = false;  // reads View::vdot or View::lambda; only these can depend on inputs

  // Where the value is: an output is computed by `output`, a parameter lies in a Mechanism, an input in the vector u.
  int object = 0, component = 0;
  double (*output)(const View&, int object, int component) = nullptr;
  double (*rate)(const View&, int object, int component) = nullptr;  // its time derivative, if the output may jump
  double& (*parameter)(Mechanism&, int object, int component) = nullptr;
  int& (*option)(Mechanism&) = nullptr;  // of an integer parameter
  int input = -1;

  double value(const Mechanism& mechanism) const;  // of a parameter
  void set_value(Mechanism& mechanism, double value) const;
  // Empty, or one sentence that says what is wrong with a value.
  std::string complaint(double value) const;
};

// The value reference of a variable is its index.
std::vector<Variable> make_variables(const Mechanism& mechanism, const System& system);

}  // namespace sigmafmu
