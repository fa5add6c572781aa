#include <stdexcept>
#include <tuple>

#include "model/definition.h"

namespace sigmafmu {

using Kind = InitialValue::Kind;

bool operator<(const InitialValue& a, const InitialValue& b) {
  return std::tie(a.kind, a.object, a.component) < std::tie(b.kind, b.object, b.component);
}

namespace {

double& modal_value(const ModalDef& modal, VectorXd& values, int mode) {
  if (values.size() == 0) values.setZero(modal.mode_count());  // that is what empty means
  return values[mode];
}

}  // namespace

int component_count(const MultibodyDef& d, const InitialValue& what) {
  const auto object = static_cast<std::size_t>(what.object);
  if (what.object < 0 || object >= (what.of_joint() ? d.joints.size() : d.bodies.size())) return 0;
  if (what.of_joint()) return d.joints[object].coordinate_count();
  if (what.kind == Kind::quaternion) return 4;
  if (what.kind != Kind::modal && what.kind != Kind::modal_rate) return 3;
  return d.bodies[object].modal ? d.bodies[object].modal->mode_count() : 0;
}

double& initial_value(MultibodyDef& d, const InitialValue& what) {
  const auto& [kind, i, c] = what;
  switch (kind) {
    case Kind::position:
      return d.bodies[i].initial_position[c];
    case Kind::quaternion:
      return d.bodies[i].initial_quaternion[c];
    case Kind::velocity:
      return d.bodies[i].initial_velocity[c];
    case Kind::angular_velocity:
      return d.bodies[i].initial_angular_velocity[c];
    case Kind::modal:
      return modal_value(*d.bodies[i].modal, d.bodies[i].modal->initial_coordinates, c);
    case Kind::modal_rate:
      return modal_value(*d.bodies[i].modal, d.bodies[i].modal->initial_rates, c);
    case Kind::joint_coordinate:
      return d.joints[i].initial_coordinates[c];
    case Kind::joint_rate:
      return d.joints[i].initial_rates[c];
  }
  throw std::logic_error("no such initial value");
}

double initial_value(const MultibodyDef& definition, const InitialValue& what) {
  return initial_value(const_cast<MultibodyDef&>(definition), what);
}

void set_initial_value(MultibodyDef& definition, const InitialValue& what, double value) {
  double& present = initial_value(definition, what);
  if (value == present) return;
  const auto entry = definition.held.try_emplace(what, present).first;
  present = value;
  if (value == entry->second) {
    present = entry->second;  // whose zero may have the other sign
    definition.held.erase(entry);
  }
}

MultibodyDef without_held_values(const MultibodyDef& definition) {
  MultibodyDef result = definition;
  for (const auto& [what, value] : definition.held) initial_value(result, what) = value;
  result.held.clear();
  return result;
}

std::string initial_name(const MultibodyDef& definition, const InitialValue& what) {
  if (what.of_joint()) {
    const JointDef& joint = definition.joints[what.object];
    const bool rate = what.kind == Kind::joint_rate;
    return joint.name + "." +
           joint.word(what.component, rate ? "initialAngularRate" : "initialAngle",
                      rate ? "initialRate" : "initialDisplacement");
  }
  const char* names[] = {"Position", "Quaternion", "Velocity", "AngularVelocity", "Modal", "ModalRate"};
  return definition.bodies[what.object].name + ".initial" + names[static_cast<int>(what.kind)];
}

const char* initial_unit(const MultibodyDef& definition, const InitialValue& what) {
  const bool turns = what.of_joint() && definition.joints[what.object].turns(what.component);
  switch (what.kind) {
    case Kind::quaternion:
      return "1";
    case Kind::angular_velocity:
      return "rad/s";
    case Kind::joint_coordinate:
      return turns ? "rad" : "m";
    case Kind::joint_rate:
      return turns ? "rad/s" : "m/s";
    default:
      return what.of_motion() ? "m/s" : "m";
  }
}

}  // namespace sigmafmu
