#include "dependencies.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "fmi/slave.h"

namespace sigmafmu {
namespace {

// What makes derivatives of outputs by inputs comparable: with a length torques become forces and angular accelerations
// linear ones.
struct Comparable {
  double length;

  static std::string unit(const std::string& unit) { return unit == "rad/s2" ? "m/s2" : unit == "N.m" ? "N" : unit; }
  double factor(const std::string& output, const std::string& input) const {
    const double of_output = output == "rad/s2" ? length : output == "N.m" ? 1 / length : 1;
    return of_output * (input == "N.m" ? length : 1);
  }
};

// Derivatives of the same kind are those of outputs of one unit by inputs of one unit.
struct Kind {
  std::size_t index, comparable;  // of the kind, and of the unit with which its outputs compare
  double factor;
};

class Kinds {
 public:
  Kinds(const std::vector<Port>& variables, const std::vector<unsigned>& outputs, const std::vector<unsigned>& inputs,
        const Comparable& comparable) {
    for (unsigned i : outputs) outputs_.push_back(number(variables[i].unit));
    for (unsigned j : inputs) inputs_.push_back(number(variables[j].unit));
    const std::vector<std::string> told = units_;
    for (const std::string& output : told) {
      for (const std::string& input : told) {
        kinds_.push_back({kinds_.size(), number(Comparable::unit(output)), comparable.factor(output, input)});
      }
    }
    side_ = told.size();
  }

  std::size_t count() const { return std::max(kinds_.size(), units_.size()); }
  const Kind& operator()(std::size_t output, std::size_t input) const {
    return kinds_[outputs_[output] * side_ + inputs_[input]];
  }

 private:
  std::size_t number(const std::string& unit) {
    const auto found = std::find(units_.begin(), units_.end(), unit);
    const auto place = static_cast<std::size_t>(found - units_.begin());
    if (found == units_.end()) units_.push_back(unit);
    return place;
  }

  std::vector<std::string> units_;
  std::vector<std::size_t> outputs_, inputs_;
  std::vector<Kind> kinds_;
  std::size_t side_ = 0;
};

// Of a mechanism that does not move far enough to be asked.
Dependencies every_dependency(const std::vector<Port>& variables) {
  Dependencies depends(variables.size(), std::vector<bool>(variables.size(), false));
  for (std::size_t i = 0; i < variables.size(); ++i) {
    if (!variables[i].output || variables[i].integer) continue;
    for (std::size_t j = 0; j < variables.size(); ++j) depends[i][j] = variables[j].is_input();
  }
  return depends;
}

}  // namespace

Dependencies probe_dependencies(Mechanism mechanism) {
  constexpr int kPoints = 3;
  constexpr double kMostPairs = 1e6;     // of an input and an output: seconds, and megabytes of lists
  constexpr double kSteps = 20000;       // of one body between points: a large mechanism is not worth minutes
  constexpr double kSignificant = 1e-9;  // against the largest derivative of its kind; rounding leaves 1e-13
  // The same points in every build: the C++ standard fixes the sequence.
  std::mt19937 generator(1);  // NOLINT(bugprone-random-generator-seed)
  const auto random = [&] { return 2.0 * (static_cast<double>(generator()) / 4294967295.0) - 1.0; };

  for (RigidBodyDef& body : mechanism.multibody.bodies) {
    if (body.modal) {  // a body without symmetry, and modes that couple every direction
      ModalDef& modal = *body.modal;
      const double size = modal.nodes.cwiseAbs().maxCoeff(), shape = modal.shapes.cwiseAbs().maxCoeff();
      for (double& x : modal.nodes.reshaped()) x += 0.1 * size * random();
      for (double& x : modal.shapes.reshaped()) x += 0.1 * shape * random();
      continue;
    }
    // Mass is added whose second moments A A^T do not know the body's axes: what a body can have, however thin it is.
    const Matrix3d A = Matrix3d::NullaryExpr([&] { return random(); });
    const Matrix3d moments = 0.2 * body.inertia.sum() * A * A.transpose();
    body.inertia.array() += moments.trace() - moments.diagonal().array();
    body.inertia_products -= Vector3d(moments(0, 1), moments(0, 2), moments(1, 2));
  }
  const double length = scales(mechanism.multibody).length;
  const Comparable comparable{length > 0 ? length : 1.0};
  double force = 1;  // [N] that no body takes amiss
  for (const RigidBodyDef& body : mechanism.multibody.bodies) force = std::min(force, 10 * mass(body));
  Slave slave(mechanism, "");
  const auto& variables = slave.variables();
  std::vector<unsigned> inputs, outputs;
  for (unsigned i = 0; i < variables.size(); ++i) {
    if (variables[i].is_input()) inputs.push_back(i);
    if (variables[i].output && !variables[i].integer) outputs.push_back(i);
  }
  if (static_cast<double>(inputs.size()) * static_cast<double>(outputs.size()) > kMostPairs) return {};
  slave.enter_initialization();
  slave.exit_initialization();

  Dependencies depends(variables.size(), std::vector<bool>(variables.size(), false));
  if (inputs.empty()) return depends;
  const Kinds kinds(variables, outputs, inputs, comparable);
  const double longest =
      kSteps / static_cast<double>(mechanism.multibody.bodies.size()) * mechanism.integrator.step_size;
  const double H = std::min(0.1 * mechanism.stop_time / kPoints, longest);
  for (int point = 0; point < kPoints; ++point) {
    std::vector<double> values;
    std::vector<unsigned> loads;  // what is prescribed stays
    for (unsigned i : inputs) {
      if (variables[i].input < 0) continue;
      loads.push_back(i);
      values.push_back(force * (variables[i].unit == std::string("N") ? 1 : comparable.length) * random());
    }
    slave.set(loads.data(), loads.size(), false, values.data());
    if (!slave.do_step(slave.time(), H)) return every_dependency(variables);

    // Rounding is measured against the largest derivative of the same kind: an input that the joints take up entirely
    // leaves nothing but rounding in all accelerations. A kind may consist of rounding alone, which is told from all
    // derivatives that compare with it.
    std::vector<double> largest(kinds.count()), largest_of_all(kinds.count());  // the second by comparable unit
    std::vector<std::vector<double>> derivative(inputs.size(), std::vector<double>(outputs.size()));
    for (std::size_t j = 0; j < inputs.size(); ++j) {
      const double direction = 1.0;
      slave.directional_derivative(outputs.data(), outputs.size(), &inputs[j], 1, &direction, derivative[j].data());
      for (std::size_t i = 0; i < outputs.size(); ++i) {
        const Kind& kind = kinds(i, j);
        double &x = largest[kind.index], &y = largest_of_all[kind.comparable];
        x = std::max(x, std::abs(derivative[j][i]));
        y = std::max(y, kind.factor * std::abs(derivative[j][i]));
      }
    }
    for (std::size_t j = 0; j < inputs.size(); ++j) {
      for (std::size_t i = 0; i < outputs.size(); ++i) {
        const Kind& kind = kinds(i, j);
        const double x = largest[kind.index], y = largest_of_all[kind.comparable];
        if (kind.factor * x <= kSignificant * y) continue;
        if (std::abs(derivative[j][i]) > kSignificant * x) depends[outputs[i]][inputs[j]] = true;
      }
    }
  }
  return depends;
}

}  // namespace sigmafmu
