// Ports of forces: their parameters by the tables of their definitions, inputs and outputs by those of Force.
#include "multibody/ports/ports.h"

namespace sigmafmu {
namespace {

// Definitions of one type: where a Mechanism has them.
template <typename Def>
std::vector<Def>& list(Mechanism& mechanism) {
  std::vector<Def>* found = nullptr;
  for_each_force_list(mechanism.multibody, [&](const char*, auto& forces) {
    if constexpr (std::is_same_v<std::decay_t<decltype(forces)>, std::vector<Def>>) found = &forces;
  });
  return *found;
}

template <typename Def>
double& parameter(Mechanism& mechanism, int object, int port, int component) {
  return Def::parameters()[port].values(list<Def>(mechanism)[object])[component];
}

void output(const View& view, int object, int port, double* values) {
  const Force& force = view.system.force(object);
  force.ports()[port].output(force, view.system.force_kinematics(view.evaluation, object), view.inputs, values);
}

void tendon_coefficients(Ports& ports, const TendonDef& tendon, int index) {
  for (std::size_t i = 0; i < tendon.terms.size(); ++i) {
    const TendonDef::Term& term = tendon.terms[i];
    const JointDef& joint = ports.mechanism.multibody.joints[term.joint];
    const bool turns = joint.turns(term.coordinate);
    const std::string name = tendon.name + ".coefficient[" + std::to_string(i + 1) + "]";
    Port& p = ports.parameter(
        index, name, turns ? "Displacement" : "Number",
        "Length for each " + std::string(turns ? "rad of the angle of " : "m of the displacement of ") + joint.name,
        [](Mechanism& m, int o, int, int k) -> double& { return m.multibody.tendons[o].terms[k].coefficient; },
        Variability::tunable);
    p.component = static_cast<int>(i);
  }
}

// `index` among the forces of its type, `f` among all of the System.
template <typename Def>
void ports_of(Ports& ports, const Def& def, int index, int f) {
  const MultibodyDef& d = ports.mechanism.multibody;
  const Force& force = ports.system.force(f);
  const std::string some = variable_name(d, def, "");
  ports.owner(some.substr(0, some.rfind('.')), "force", Def::kKind);
  int input = force.first_input();
  for (std::size_t k = 0; k < force.ports().size(); ++k) {
    const ForcePort& p = force.ports()[k];
    const std::string name = variable_name(d, def, p.name);
    if (p.output) {
      const int size = std::max(1, p.size);
      const auto first = ports.ports().size();
      ports.outputs(ports.group(f, size, output, false, static_cast<int>(k)), 0, name, p.size, p.type, p.description);
      if (p.times_velocity) ports.set_times_velocity(first);
    } else {
      ports.inputs(input, name, p.size, p.type, p.description);
      input += std::max(1, p.size);
    }
  }
  if constexpr (std::is_same_v<Def, RotationMotorDef>) {
    ports.terminal("Motor in the joint", {"rotationVector", "relativeAngularVelocity", "motorTorque"});
  } else if (force.input_count() > 0) {
    ports.terminal(
        force.frame_count() == 1 ? "Actuator" : "Actuator beside the spring",
        {"position", "length", "rate", "angle", "angularRate", "force", "torque", "actuatorForce", "actuatorTorque"});
  }
  for (std::size_t k = 0; k < Def::parameters().size(); ++k) {
    const Parameter<Def>& p = Def::parameters()[k];
    std::string description = p.description;
    if constexpr (HasDescription<Def>::value) description = with_note(description, def.description);
    const auto first = ports.ports().size();
    ports.parameters(index, variable_name(d, def, p.name), p.size, type_of(d, def, p), description, parameter<Def>,
                     Variability::tunable);
    ports.set_port(first, static_cast<int>(k));
  }
  if constexpr (std::is_same_v<Def, TendonDef>) tendon_coefficients(ports, def, index);
}

}  // namespace

// First of those that have inputs or outputs, then of those that have parameters alone.
void force_ports(Ports& ports) {
  for (const bool alone : {false, true}) {
    int f = 0;
    for_each_force_list(ports.mechanism.multibody, [&](const char*, const auto& forces) {
      for (std::size_t i = 0; i < forces.size(); ++i, ++f) {
        if (ports.system.force(f).ports().empty() == alone) ports_of(ports, forces[i], static_cast<int>(i), f);
      }
    });
  }
}

}  // namespace sigmafmu
