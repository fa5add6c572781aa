// The one table of a mechanism's variables: names, units, limits, causalities, and how each is read or set.
//
// modelDescription.xml, the getters and setters, start values and dependencies all come from it.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "fmi/units.h"
#include "integrator/state.h"
#include "model/mechanism.h"
#include "model/settings_table.h"
#include "multibody/system.h"

namespace sigmafmu {

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

enum class Causality { parameter, input, output, local };
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

  // Where the value is: a parameter lies in a Mechanism, an input in the vector u. Outputs are computed in groups, such
  // as the six scalars of a joint's reaction: `output` writes the values of the group, which OutputValues keeps from
  // `group` on, and this is the one at `component`.
  int object = 0, component = 0, group = 0;
  void (*output)(const View&, int object, double* values) = nullptr;
  double (*rate)(const View&, int object, int component) = nullptr;  // its time derivative, if the output may jump
  double& (*parameter)(Mechanism&, int object, int component) = nullptr;
  int& (*option)(Mechanism&, int object) = nullptr;  // of an integer parameter
  std::optional<InitialValue> initial;               // which of the definition's a parameter is
  int input = -1;

  double value(const Mechanism& mechanism) const;  // of a parameter
  void set_value(Mechanism& mechanism, double value) const;
  // Empty, or one sentence that says what is wrong with a value.
  std::string complaint(double value) const;
};

// Outputs at one point: each group is computed once, when the first of its values is asked for. Allocates nothing after
// the construction.
class OutputValues {
 public:
  explicit OutputValues(const std::vector<Variable>& variables);
  double operator()(const Variable& v, const View& view);  // of an output
  void forget();                                           // the point has changed

 private:
  std::vector<double> values_;
  std::vector<char> known_;  // by the first value of a group
};

// The value reference of a variable is its index.
std::vector<Variable> make_variables(const Mechanism& mechanism, const System& system);

}  // namespace sigmafmu
