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

void acceleration(const View& view, int c, int, double* value) {
  *value = view.system.coordinate_acceleration(view.evaluation, c, view.vdot);
}

void coordinate_ports(Ports& ports, int joint, int k) {
  using Kind = InitialValue::Kind;
  const JointDef& definition = ports.mechanism.multibody.joints[joint];
  const std::string number = definition.number(k);
  const auto name = [&](const char* word) { return definition.name + "." + word + number; };
  const int c = ports.system.coordinate_index(joint) + k;
  const Force& motor = ports.system.motor(c);
  const ForcePort& drive = motor.ports()[0];
  const bool angle = ports.system.coordinate(c).is_angle();
  const char *value = angle ? "angle" : "displacement", *rate_of = angle ? "angularRate" : "rate";
  if (angle) {
    ports.output(c, name(value), "Angle", "Joint angle, counting turns", coordinate);
    ports.output(c, name(rate_of), "AngularVelocity", "Rate of the joint angle", rate);
  } else {
    ports.output(c, name(value), "Displacement", "Displacement along the joint axis", coordinate);
    ports.output(c, name(rate_of), "Velocity", "Rate of the displacement", rate);
  }
  const int prescribed = drive_of(ports.mechanism.multibody, joint, k);
  const bool beside_angle = !angle && number.empty() && definition.coordinate_count() > 1;
  ports
      .output(ports.group(c, 1, power, prescribed >= 0, prescribed), 0,
              name(beside_angle ? "displacementPower" : "power"), "Power",
              prescribed >= 0 ? "Power of motor and drive in the joint" : "Power of the motor in the joint")
      .times_velocity = true;
  ports.input(motor.first_input(), name(drive.name), drive.type, drive.description);
  if (angle) {
    ports.initial({Kind::joint_coordinate, joint, k}, "", "Angle", "Initial joint angle, counting turns");
    ports.initial({Kind::joint_rate, joint, k}, "", "AngularVelocity", "Initial rate of the joint angle");
    ports.terminal("Motor in the joint", {value + number, rate_of + number, drive.name + number});
    ports.output(ports.group(c, 1, acceleration, true), 0, name("angularAcceleration"), "AngularAcceleration",
                 "Second derivative of the joint angle");
  } else {
    ports.initial({Kind::joint_coordinate, joint, k}, "", "Displacement", "Initial displacement along the joint axis");
    ports.initial({Kind::joint_rate, joint, k}, "", "Velocity", "Initial rate of the displacement");
    ports.terminal("Actuator in the joint", {value + number, rate_of + number, drive.name + number});
    ports.output(ports.group(c, 1, acceleration, true), 0, name("acceleration"), "Acceleration",
                 "Second derivative of the displacement");
  }
}

}  // namespace

void joint_ports(Ports& ports, int j) {
  const Joint& joint = ports.system.joint(j);
  const std::string& n = ports.mechanism.multibody.joints[j].name;
  ports.owner(n, "joint", joint_type_names()[static_cast<int>(joint.type())]);
  for (std::size_t k = 0; k < joint.coordinates().size(); ++k) coordinate_ports(ports, j, static_cast<int>(k));
  if (joint.type() == JointType::free) return;  // which has no reaction
  if (joint.type() == JointType::distance) {
    Port& length = ports.parameter(
        j, n + ".length", "Position", "Distance of the two points",
        [](Mechanism& m, int o, int, int) -> double& { return m.multibody.joints[o].length; }, Variability::fixed);
    length.min = 0;
    length.above_min = true;
  }
  if (joint.type() == JointType::screw) {
    ports.parameter(
        j, n + ".pitch", "Displacement", "Displacement of a turn, negative for a left-handed thread",
        [](Mechanism& m, int o, int, int) -> double& { return m.multibody.joints[o].pitch; }, Variability::fixed);
  }
  const bool rolls = joint.type() == JointType::rolling_disk;
  if (rolls) {
    Port& radius = ports.parameter(
        j, n + ".radius", "Position", "Radius of the disk",
        [](Mechanism& m, int o, int, int) -> double& { return m.multibody.joints[o].radius; }, Variability::fixed);
    radius.min = 0;
    radius.above_min = true;
    ports.outputs(j, n + ".contactPoint", 3, "Position", "Point where the disk touches the plane, in W",
                  [](const View& v, int o, int, double* x) { vector3(x) = v.system.touching_point(v.evaluation, o); });
  }
  const ReactionDef& tells = ports.mechanism.multibody.joints[j].reaction;
  const std::string axes[] = {"in W", "in the axes of frame 1", "in the axes of frame 2"};
  const std::string in_axes = ", " + axes[static_cast<int>(tells.axes)];
  const std::string frame = tells.at == ReactionDef::At::frame1 ? "frame 1" : "frame 2";
  const bool at_origin = tells.point.isZero(0);
  const std::string point = tells.is_default() ? (rolls ? "the point of contact" : "the joint's point on it")
                                               : (at_origin ? "the origin of " : "a point of ") + frame;
  const std::string force = "Force of the joint on the second body" + in_axes;
  const std::string torque = "Torque of the joint on the second body about " + point + in_axes;
  const Ports::Group both = ports.group(j, 6, reaction, true);
  ports.outputs(both, 0, n + ".reactionForce", 3, "Force", force);
  if (joint.type() == JointType::spherical && at_origin) {  // exactly zero, not the rounding of a difference
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
  ports.output(group, 0, joint.name + "." + joint.word(drive.coordinate, "driveTorque", "driveForce"),
               turns ? "Torque" : "Force",
               turns ? "Torque of the drive about the joint axis on the second body"
                     : "Force of the drive along the joint axis on the second body");
  if (!drive.input) return;
  const char* types[] = {turns ? "Angle" : "Displacement", turns ? "AngularVelocity" : "Velocity",
                         turns ? "AngularAcceleration" : "Acceleration"};
  const char* words[] = {"Coordinate", "Rate", "Acceleration"};
  const auto order = static_cast<int>(drive.motion);
  ports.prescribed(d, order, drive.input_name(ports.mechanism.multibody), types[order],
                   std::string(words[order]) + " of the joint that the drive prescribes", drive.value);
}

namespace {

// Along each coordinate, on the second body of its joint.
void coupling_forces(const View& view, int c, int, double* values) {
  const Coupling& coupling = view.system.coupling(c);
  const Kinematics k = view.system.coupling_kinematics(view.evaluation, c);
  const double lambda = view.lambda[view.system.drive_lambda_index(view.system.drive_count() + c)];
  for (std::size_t i = 0; i < coupling.terms().size(); ++i) {
    values[i] = -lambda * coupling.slope(view.inputs, k, static_cast<int>(i));
  }
}

}  // namespace

namespace {

void coupling_parameters(Ports& ports, int c) {
  const CouplingDef& coupling = ports.mechanism.multibody.couplings[c];
  using Type = CouplingDef::Type;
  const auto ratio = [](Mechanism& m, int o, int, int) -> double& {
    return m.multibody.couplings[o].terms[0].polynomial[1];
  };
  switch (coupling.type) {
    case Type::sum:
      return;
    case Type::gear:
      ports.parameter(c, coupling.name + ".ratio", "Number", "Rate of the second coordinate for that of the first",
                      ratio, Variability::fixed);
      return;
    case Type::rack_and_pinion:
      ports.parameter(c, coupling.name + ".radius", "Displacement", "Radius of the pinion: the rack's way for each rad",
                      ratio, Variability::fixed);
      return;
    case Type::mimic:
      break;
  }
  const auto coefficient = [](Mechanism& m, int o, int, int k) -> double& {
    return m.multibody.couplings[o].terms[1].polynomial[k];
  };
  ports.parameters(c, coupling.name + ".polynomial", static_cast<int>(coupling.terms[1].polynomial.size()), "Number",
                   "Coefficient of the follower's polynomial, from the constant on, in SI units", coefficient,
                   Variability::fixed);
}

}  // namespace

void coupling_ports(Ports& ports, int c) {
  const MultibodyDef& d = ports.mechanism.multibody;
  const CouplingDef& coupling = d.couplings[c];
  const auto terms = static_cast<int>(coupling.terms.size());
  ports.owner(coupling.name, "coupling", "coordinate");
  const Ports::Group group = ports.group(c, terms, coupling_forces, true);
  for (int i = 0; i < terms; ++i) {
    const CouplingDef::Term& term = coupling.terms[i];
    const JointDef& joint = d.joints[term.joint];
    const bool turns = joint.turns(term.coordinate);
    ports.output(
        group, i, coupling.name + (turns ? ".torque" : ".force") + std::to_string(i + 1), turns ? "Torque" : "Force",
        std::string(turns ? "Torque about" : "Force along") + " the axis of " + joint.name + " on its second body");
  }
  coupling_parameters(ports, c);
}

namespace {

void moving_load(const View& view, int m, int, double* values) {
  const System::MovingLoad load = view.system.moving_load(view.evaluation, m, view.vdot, view.lambda, view.inputs);
  vector3(values) = load.force;
  vector3(values + 3) = load.torque;
  values[6] = load.power;
}

}  // namespace

void motion_ports(Ports& ports, int m) {
  const MotionDef& motion = ports.mechanism.multibody.motions[m];
  ports.owner(motion.name, "motion", "frame");
  const Ports::Group load = ports.group(m, 7, moving_load, true);
  ports.outputs(load, 0, motion.name + ".force", 3, "Force", "Force that moves the frame, in W");
  ports.outputs(load, 3, motion.name + ".torque", 3, "Torque", "Torque that moves the frame, about its origin, in W");
  ports.output(load, 6, motion.name + ".power", "Power", "Power that moves the frame").times_velocity = true;
  if (!motion.input) return;
  const int first = ports.system.drive_count() + ports.system.coupling_count() + kPrescribedPerMotion * m;
  for (int i = 0; i < kPrescribedPerMotion; ++i) {
    const std::string number = "[" + std::to_string(i % 3 + 1) + "]";
    if (i < 3) {
      ports.prescribed(first + i, 0, motion.name + ".displacement" + number, "Displacement",
                       "Displacement of the frame in W", motion.start[0][static_cast<std::size_t>(i)]);
    } else {
      ports.prescribed(first + i, 0, motion.name + ".rotation" + number, "Angle",
                       "Rotation vector of the frame, in its axes at rest",
                       motion.start[0][static_cast<std::size_t>(i)]);
    }
  }
}

}  // namespace sigmafmu
