// Ports of joints and drives.
#include <cmath>

#include "multibody/ports/ports.h"

namespace sigmafmu {
namespace {

// Force and torque.
void reaction(const View& view, int j, int, double* values) {
  const Joint::Reaction r = view.system.reaction(view.evaluation, j, view.lambda.data() + view.system.lambda_index(j));
  vector3(values) = r.force;
  vector3(values + 3) = r.torque;
}

// Of all joints; angles count turns.
void coordinate(const View& view, int c, int, double* value) {
  *value = view.system.coordinate_value(view.evaluation, c);
  constexpr double kTwoPi = 6.28318530717958647692;
  if (!view.system.coordinate(c).is_angle()) return;
  *value += kTwoPi * std::round((view.inputs.turned[c] - *value) / kTwoPi);
}

void rate(const View& view, int c, int, double* value) { *value = view.system.coordinate_rate(view.evaluation, c); }

// Of the motor and, if there is one, the drive d of coordinate c.
void power(const View& view, int c, int d, double* value) {
  double force = view.inputs.u[view.system.motor(c).first_input()];
  if (d >= 0) force -= view.lambda[view.system.drive_lambda_index(d)];
  *value = force * view.system.coordinate_rate(view.evaluation, c);
}

int drive_of(const MultibodyDef& d, int joint, int coordinate) {
  for (std::size_t i = 0; i < d.drives.size(); ++i) {
    if (d.drives[i].joint == joint && d.drives[i].coordinate == coordinate) return static_cast<int>(i);
  }
  return -1;
}

void coordinate_ports(Ports& ports, int joint, int k) {
  using Kind = InitialValue::Kind;
  const std::string& n = ports.mechanism.multibody.joints[joint].name;
  const int c = ports.system.coordinate_index(joint) + k;
  const Force& motor = ports.system.motor(c);
  const ForcePort& drive = motor.ports()[0];
  const bool angle = ports.system.coordinate(c).is_angle();
  if (angle) {
    ports.output(c, n + ".angle", "Angle", "Joint angle, counting turns", coordinate);
    ports.output(c, n + ".angularRate", "AngularVelocity", "Rate of the joint angle", rate);
  } else {
    ports.output(c, n + ".displacement", "Displacement", "Displacement along the joint axis", coordinate);
    ports.output(c, n + ".rate", "Velocity", "Rate of the displacement", rate);
  }
  const int prescribed = drive_of(ports.mechanism.multibody, joint, k);
  ports
      .output(ports.group(c, 1, power, prescribed >= 0, prescribed), 0, n + (k == 0 ? ".power" : ".displacementPower"),
              "Power", prescribed >= 0 ? "Power of motor and drive in the joint" : "Power of the motor in the joint")
      .times_velocity = true;
  ports.input(motor.first_input(), n + "." + drive.name, drive.type, drive.description);
  if (angle) {
    ports.initial({Kind::joint_coordinate, joint, k}, "", "Angle", "Initial joint angle, counting turns");
    ports.initial({Kind::joint_rate, joint, k}, "", "AngularVelocity", "Initial rate of the joint angle");
    ports.terminal("Motor in the joint", {"angle", "angularRate", "motorTorque"});
  } else {
    ports.initial({Kind::joint_coordinate, joint, k}, "", "Displacement", "Initial displacement along the joint axis");
    ports.initial({Kind::joint_rate, joint, k}, "", "Velocity", "Initial rate of the displacement");
    ports.terminal("Actuator in the joint", {"displacement", "rate", "actuatorForce"});
  }
}

}  // namespace

void joint_ports(Ports& ports, int j) {
  const Joint& joint = ports.system.joint(j);
  const std::string& n = ports.mechanism.multibody.joints[j].name;
  ports.owner(n, "joint", joint_type_names()[static_cast<int>(joint.type())]);
  for (std::size_t k = 0; k < joint.coordinates().size(); ++k) coordinate_ports(ports, j, static_cast<int>(k));
  const char* force = "Force of the joint on the second body, in W";
  const char* torque = "Torque of the joint on the second body about the joint's point on it, in W";
  const Ports::Group both = ports.group(j, 6, reaction, true);
  ports.outputs(both, 0, n + ".reactionForce", 3, "Force", force);
  if (joint.type() == JointType::spherical) {  // exactly zero, not the rounding of a difference
    ports.outputs(j, n + ".reactionTorque", 3, "Torque", torque,
                  [](const View&, int, int, double* x) { vector3(x).setZero(); });
  } else {
    ports.outputs(both, 3, n + ".reactionTorque", 3, "Torque", torque);
  }
}

void drive_ports(Ports& ports, int d) {
  const DriveDef& drive = ports.mechanism.multibody.drives[d];
  const JointDef& joint = ports.mechanism.multibody.joints[drive.joint];
  const bool turns = joint.turns(drive.coordinate);
  ports.owner(joint.name, "joint", "");
  const Ports::Group group = ports.group(
      d, 1, [](const View& v, int o, int, double* x) { *x = -v.lambda[v.system.drive_lambda_index(o)]; }, true);
  ports.output(group, 0, joint.name + (turns ? ".driveTorque" : ".driveForce"), turns ? "Torque" : "Force",
               turns ? "Torque of the drive about the joint axis on the second body"
                     : "Force of the drive along the joint axis on the second body");
}

}  // namespace sigmafmu
