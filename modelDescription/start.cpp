#include "start.h"

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "fmi/set_parameter.h"
#include "multibody/dense_blocks.h"
#include "multibody/moving_frame.h"
#include "solve/index1.h"
#include "solve/start/assembly.h"
#include "solve/start/dependent_equations.h"

namespace sigmafmu {
namespace {

using Json = nlohmann::json;

Json numbers(const VectorXd& x) { return std::vector<double>(x.data(), x.data() + x.size()); }

Json rows(const MatrixXd& a) {
  Json result = Json::array();
  for (Eigen::Index i = 0; i < a.rows(); ++i) result.push_back(numbers(a.row(i)));
  return result;
}

// What answers are made from.
struct Posed {
  explicit Posed(const MultibodyDef& d)
      : definition((validate(d), d)),
        system(d, find_compliance(d)),
        inputs(inputs_at_start(d, system)),
        e(system.make_evaluation()),
        solver(system) {}

  std::pair<VectorXd, VectorXd> assembled() {
    VectorXd q(system.position_size()), v(system.velocity_size());
    assemble(definition, system, solver, q, v);
    return {q, v};
  }
  void check(const std::vector<int>& coordinates) const {
    for (int c : coordinates) {
      if (c < 0 || c >= system.coordinate_count()) throw std::invalid_argument("there is no such coordinate");
    }
  }

  const MultibodyDef& definition;
  System system;
  Inputs inputs;
  Evaluation e;
  ConsistentSolver solver;
};

}  // namespace

std::string start(Mechanism mechanism, const std::map<std::string, double>& values) {
  validate(mechanism);
  for (const auto& [name, value] : values) set_parameter(mechanism, name, value);
  Posed posed(mechanism.multibody);
  const auto [q, v] = posed.assembled();
  const System& system = posed.system;
  system.evaluate(q, v, posed.inputs, posed.e);
  VectorXd x(system.coordinate_count()), rate(system.coordinate_count());
  for (int c = 0; c < system.coordinate_count(); ++c) {
    x[c] = system.coordinate_value(posed.e, c);
    rate[c] = system.coordinate_rate(posed.e, c);
  }
  return Json({{"q", numbers(q)}, {"v", numbers(v)}, {"coordinates", numbers(x)}, {"rates", numbers(rate)}}).dump();
}

std::string closure(const Mechanism& mechanism, const std::vector<double>& q, const std::vector<int>& coordinates) {
  validate(mechanism);
  Posed posed(mechanism.multibody);
  const System& system = posed.system;
  posed.check(coordinates);
  if (static_cast<int>(q.size()) != system.position_size()) throw std::invalid_argument("q has the wrong size");
  const VectorXd at = Eigen::Map<const VectorXd>(q.data(), system.position_size());
  const auto size = static_cast<Eigen::Index>(coordinates.size());
  VectorXd values(size), v = VectorXd::Zero(system.velocity_size());
  MatrixXd gradients(size, v.size());
  for (Eigen::Index column = 0; column < (size > 0 ? v.size() : 0); ++column) {
    v[column] = 1;
    system.evaluate(at, v, posed.inputs, posed.e);
    for (Eigen::Index i = 0; i < size; ++i) gradients(i, column) = system.coordinate_rate(posed.e, coordinates[i]);
    v[column] = 0;
  }
  system.evaluate(at, v, posed.inputs, posed.e);
  system.clear_velocity_rows(posed.e);
  for (Eigen::Index i = 0; i < size; ++i) values[i] = system.coordinate_value(posed.e, coordinates[i]);
  return Json({{"gaps", numbers(posed.e.phi)},
               {"rows", rows(dense_rows(system, posed.e.B))},
               {"values", numbers(values)},
               {"value_rows", rows(gradients)}})
      .dump();
}

std::string mobility(const Mechanism& mechanism, const std::vector<int>& coordinates) {
  validate(mechanism);
  Posed posed(mechanism.multibody);
  const System& system = posed.system;
  posed.check(coordinates);
  const auto [q, v] = posed.assembled();
  Inputs inputs = posed.inputs;
  inputs.u = VectorXd::Zero(system.input_size());
  const auto accelerations = [&, q = q, v = v] {
    VectorXd vdot(system.velocity_size()), lambda(system.constraint_size());
    if (!posed.solver.accelerations(q, v, inputs, vdot, lambda)) {
      throw std::runtime_error(posed.solver.singular() ? describe_singularity(posed.definition, system, q)
                                                       : "a value overflows");
    }
    return vdot;
  };
  const VectorXd at_rest = accelerations();
  std::vector<double> found;
  for (int c : coordinates) {
    inputs.u[system.motor(c).first_input()] = 1;
    const VectorXd moved = accelerations();
    inputs.u[system.motor(c).first_input()] = 0;
    system.evaluate(q, v, inputs, posed.e);
    found.push_back(system.coordinate_acceleration(posed.e, c, moved) -
                    system.coordinate_acceleration(posed.e, c, at_rest));
  }
  return Json({{"mobility", found}}).dump();
}

std::string poses(const Mechanism& mechanism, int motion, const std::vector<double>& times,
                  const std::vector<double>& added) {
  const std::vector<MotionDef>& motions = mechanism.multibody.motions;
  if (motion < 0 || motion >= static_cast<int>(motions.size())) throw std::invalid_argument("there is no such motion");
  if (added.size() != kPrescribedPerMotion * times.size())
    throw std::invalid_argument("what is added has another size");
  const MovingFrame frame(motions[motion], 0);
  Inputs u(0, kPrescribedPerMotion, 0);
  Json positions = Json::array(), quaternions = Json::array();
  for (std::size_t i = 0; i < times.size(); ++i) {
    u.time = times[i];
    u.x = Eigen::Map<const Eigen::Matrix<double, kPrescribedPerMotion, 1>>(added.data() + i * kPrescribedPerMotion);
    const FrameKinematics k = frame.kinematics(u);
    const Eigen::Quaterniond quaternion(k.R_WB);
    positions.push_back(numbers(k.p_WB));
    quaternions.push_back(Json::array({quaternion.w(), quaternion.x(), quaternion.y(), quaternion.z()}));
  }
  return Json({{"positions", positions}, {"quaternions", quaternions}}).dump();
}

std::string freedom_and_masses(const Mechanism& mechanism) {
  validate(mechanism);
  const Freedom freedom = initial_freedom(mechanism.multibody);
  Json groups = Json::array(), masses = Json::array();
  for (const Freedom::Group& group : freedom.groups) {
    groups.push_back({{"joints", group.joints}, {"equations", group.equations}, {"dependent", group.dependent}});
  }
  for (const RigidBodyDef& body : mechanism.multibody.bodies) masses.push_back(mass(body));
  return Json({{"freedom", summary(freedom)}, {"groups", groups}, {"masses", masses}}).dump();
}

}  // namespace sigmafmu
