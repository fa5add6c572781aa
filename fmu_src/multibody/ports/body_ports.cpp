// Ports of bodies.
#include <algorithm>

#include "lie/r3xso3.h"
#include "multibody/ports/ports.h"

namespace sigmafmu {
namespace {

Vector3d rotation_vector(const View& view, int body) {
  return lie::log(lie::quaternion(view.q.data() + kPositionsPerBody * body));
}

// The rotation vector psi jumps where it is pi long; its rate does not: w_WB_B = T(psi) dpsi/dt.
double rotation_vector_rate(const View& view, int body, int i) {
  const Vector3d w_WB_B = view.v.segment<3>(kVelocitiesPerBody * body + 3);
  return lie::tangent_inverse_times(rotation_vector(view, body), w_WB_B)[i];
}

int modal_position(const View& view, int body) { return view.system.modal_position(view.system.flexible_index(body)); }

int modal_velocity(const View& view, int body) { return view.system.modal_velocity(view.system.flexible_index(body)); }

void copy(const VectorXd& from, int first, int count, double* to) { std::copy_n(from.data() + first, count, to); }

void inertia_ports(Ports& ports, int b, const std::string& n) {
  constexpr auto fixed = Variability::fixed;
  Port& mass = ports.parameter(
      b, n + ".mass", "Mass", "Mass",
      [](Mechanism& m, int o, int, int) -> double& { return m.multibody.bodies[o].mass; }, fixed);
  mass.above_min = true;
  const char* moments[] = {"xx", "yy", "zz"};
  for (int i = 0; i < 3; ++i) {
    Port& v = ports.parameter(
        b, n + ".inertia." + moments[i], "MomentOfInertia", "Moment of inertia about the centre of mass, body axes",
        [](Mechanism& m, int o, int, int c) -> double& { return m.multibody.bodies[o].inertia[c]; }, fixed);
    v.component = i;
    v.above_min = ports.mechanism.multibody.bodies[b].inertia[i] > 0;  // a thin rod has one that is zero
  }
  const char* products[] = {"xy", "xz", "yz"};
  for (int i = 0; i < 3; ++i) {
    ports
        .parameter(
            b, n + ".inertia." + products[i], "ProductOfInertia",
            "Off-diagonal element of the inertia matrix about the centre of mass, body axes",
            [](Mechanism& m, int o, int, int c) -> double& { return m.multibody.bodies[o].inertia_products[c]; }, fixed)
        .component = i;
  }
}

void modal_ports(Ports& ports, int b, const std::string& n, const ModalDef& d) {
  using V = const View&;
  using M = Mechanism&;
  constexpr auto tunable = Variability::tunable;
  const int modes = d.mode_count();
  ports.outputs(b, n + ".modal", modes, "Deflection", "Modal coordinate",
                [](V v, int o, int, double* x) { copy(v.q, modal_position(v, o), v.system.modes(o), x); });
  ports.outputs(b, n + ".modalRate", modes, "DeflectionRate", "Rate of the modal coordinate",
                [](V v, int o, int, double* x) { copy(v.v, modal_velocity(v, o), v.system.modes(o), x); });
  ports.initial_vector({InitialValue::Kind::modal, b}, modes, "Deflection", "Initial modal coordinate");
  ports.initial_vector({InitialValue::Kind::modal_rate, b}, modes, "DeflectionRate",
                       "Initial rate of the modal coordinate");
  ports.parameter(
      b, n + ".massDamping", "MassDamping", "Rayleigh damping: this times the modal mass matrix",
      [](M m, int o, int, int) -> double& { return m.multibody.bodies[o].modal->mass_damping; }, tunable);
  ports.parameter(
      b, n + ".stiffnessDamping", "StiffnessDamping", "Rayleigh damping: this times the modal stiffness matrix",
      [](M m, int o, int, int) -> double& { return m.multibody.bodies[o].modal->stiffness_damping; }, tunable);
}

}  // namespace

void body_ports(Ports& ports, int b) {
  using V = const View&;
  const auto& definition = ports.mechanism.multibody.bodies[b];
  const std::string& n = definition.name;
  ports.owner(n, "body", definition.modal ? "flexible" : "rigid");
  const std::string origin = definition.modal ? "the frame's origin" : "the centre of mass";
  ports.outputs(b, n + ".position", 3, "Position", "Position of " + origin + " in W",
                [](V v, int o, int, double* x) { vector3(x) = v.q.segment<3>(kPositionsPerBody * o); });
  ports.outputs(b, n + ".quaternion", 4, "Quaternion", "Orientation R_WB as unit quaternion (w, x, y, z)",
                [](V v, int o, int, double* x) { std::copy_n(v.q.data() + kPositionsPerBody * o + 3, 4, x); });
  ports.outputs(ports.group(b, 3, [](V v, int o, int, double* x) { vector3(x) = rotation_vector(v, o); }), 0,
                n + ".rotationVector", 3, "Angle", "Orientation R_WB as rotation vector, at most pi long",
                rotation_vector_rate);
  ports.outputs(b, n + ".velocity", 3, "Velocity", "Velocity of " + origin + " in W",
                [](V v, int o, int, double* x) { vector3(x) = v.v.segment<3>(kVelocitiesPerBody * o); });
  ports.outputs(b, n + ".angularVelocity", 3, "AngularVelocity", "Angular velocity in body axes",
                [](V v, int o, int, double* x) { vector3(x) = v.v.segment<3>(kVelocitiesPerBody * o + 3); });
  ports.outputs(
      b, n + ".acceleration", 3, "Acceleration", "Acceleration of " + origin + " in W",
      [](V v, int o, int, double* x) { vector3(x) = v.vdot.segment<3>(kVelocitiesPerBody * o); }, true);
  ports.outputs(
      b, n + ".angularAcceleration", 3, "AngularAcceleration", "Angular acceleration in body axes",
      [](V v, int o, int, double* x) { vector3(x) = v.vdot.segment<3>(kVelocitiesPerBody * o + 3); }, true);
  ports.inputs(ports.system.force_index(b), n + ".force", 3, "Force", "Force applied at " + origin + ", in W");
  ports.inputs(ports.system.force_index(b) + 3, n + ".torque", 3, "Torque", "Torque applied, in body axes");

  if (definition.modal) {
    modal_ports(ports, b, n, *definition.modal);
  } else {
    inertia_ports(ports, b, n);
  }
  using Kind = InitialValue::Kind;
  ports.initial_vector({Kind::position, b}, 3, "Position", "Initial position in W");
  ports.initial_vector({Kind::quaternion, b}, 4, "Quaternion",
                       "Initial orientation R_WB (w, x, y, z), normalized, set as a whole");
  ports.initial_vector({Kind::velocity, b}, 3, "Velocity", "Initial velocity in W");
  ports.initial_vector({Kind::angular_velocity, b}, 3, "AngularVelocity", "Initial angular velocity in body axes");
  ports.terminal("Load on the body", {"position", "quaternion", "velocity", "angularVelocity", "force", "torque"});
}

}  // namespace sigmafmu
