#include "start.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "fmi/set_parameter.h"
#include "solve/start/assembly.h"
#include "solve/start/dependent_equations.h"

namespace sigmafmu {
namespace {

using Json = nlohmann::json;

Json numbers(const VectorXd& x) { return std::vector<double>(x.data(), x.data() + x.size()); }

}  // namespace

std::string start(Mechanism mechanism, const std::map<std::string, double>& values) {
  validate(mechanism);
  for (const auto& [name, value] : values) set_parameter(mechanism, name, value);
  const MultibodyDef& definition = mechanism.multibody;
  validate(definition);
  const System system(definition, find_compliance(definition));
  ConsistentSolver solver(system);
  VectorXd q(system.position_size()), v(system.velocity_size());
  assemble(definition, system, solver, q, v);
  Evaluation e = system.make_evaluation();
  system.evaluate(q, v, inputs_at_start(definition, system), e);
  VectorXd x(system.coordinate_count()), rate(system.coordinate_count());
  for (int c = 0; c < system.coordinate_count(); ++c) {
    x[c] = system.coordinate_value(e, c);
    rate[c] = system.coordinate_rate(e, c);
  }
  return Json({{"q", numbers(q)}, {"v", numbers(v)}, {"coordinates", numbers(x)}, {"rates", numbers(rate)}}).dump();
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
