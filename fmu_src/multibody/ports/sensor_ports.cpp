// Ports of sensors.
#include "lie/so3.h"
#include "multibody/point_motion.h"
#include "multibody/ports/ports.h"

namespace sigmafmu {
namespace {

PointMotion absolute(const View& view, const SensorDef& s) {
  return point_motion(view.system, view.evaluation, view.vdot, s.body, s.frame);
}

// With the matrix that maps W's axes to those of the sensor's outputs.
struct Seen {
  PointMotion motion;
  Matrix3d axes;
};
Seen seen(const View& view, const SensorDef& s) {
  const PointMotion point = absolute(view, s);
  const PointMotion reference = point_motion(view.system, view.evaluation, view.vdot, s.reference, s.reference_frame);
  Matrix3d axes = Matrix3d::Identity();
  if (s.axes == SensorAxes::reference) axes = reference.R.transpose();
  if (s.axes == SensorAxes::sensor) axes = point.R.transpose();
  return {seen_from(reference, point), axes};
}

// Position, rotation vector, velocity, angular velocity.
void sensor_motion(const View& view, int i, int, double* x) {
  const auto [m, axes] = seen(view, view.mechanism.sensors[i]);
  vector3(x) = axes * m.p;
  vector3(x + 3) = lie::log(lie::Quaterniond(m.R));
  vector3(x + 6) = axes * m.v;
  vector3(x + 9) = axes * m.w;
}

// Acceleration, angular acceleration.
void sensor_acceleration(const View& view, int i, int, double* x) {
  const auto [m, axes] = seen(view, view.mechanism.sensors[i]);
  vector3(x) = axes * m.vdot;
  vector3(x + 3) = axes * m.wdot;
}

// The rotation vector psi jumps where it is pi long; its rate does not: with the angular velocity in the sensor's axes,
// T(psi) psi' = w.
double rotation_rate(const View& view, int i, int component) {
  const SensorDef& s = view.mechanism.sensors[i];
  const PointMotion m = seen(view, s).motion;
  const Vector3d w = absolute(view, s).R.transpose() * m.w;
  return lie::tangent_inverse_times(lie::log(lie::Quaterniond(m.R)), w)[component - 3];
}

void specific_force(const View& view, int i, int, double* x) {
  const PointMotion m = absolute(view, view.mechanism.sensors[i]);
  vector3(x) = m.R.transpose() * (m.vdot - view.mechanism.multibody.gravity);
}

void sensor_rate(const View& view, int i, int, double* x) {
  const PointMotion m = absolute(view, view.mechanism.sensors[i]);
  vector3(x) = m.R.transpose() * m.w;
}

}  // namespace

void sensor_ports(Ports& ports, int i) {
  const SensorDef& s = ports.mechanism.sensors[i];
  const std::string n = s.name + ".";
  const auto noted = [&](const std::string& text) { return with_note(text, s.description); };
  ports.owner(s.name, "sensor", s.type == SensorType::imu ? "inertial" : "motion");
  if (s.type == SensorType::imu) {
    ports.outputs(i, n + "specificForce", 3, "Acceleration", noted("Acceleration less gravity, in the sensor's axes"),
                  specific_force, true);
    ports.outputs(i, n + "angularVelocity", 3, "AngularVelocity", noted("Angular velocity, in the sensor's axes"),
                  sensor_rate);
    return;
  }
  const std::string axes = s.axes == SensorAxes::ground      ? ", in W"
                           : s.axes == SensorAxes::reference ? ", in the reference frame's axes"
                                                             : ", in the sensor's axes";
  const Ports::Group group = ports.group(i, 12, sensor_motion);
  ports.outputs(group, 0, n + "position", 3, "Displacement", noted("Position seen from the reference" + axes));
  ports.outputs(group, 3, n + "rotationVector", 3, "Angle",
                noted("Orientation seen from the reference as rotation vector, at most pi long"), rotation_rate);
  ports.outputs(group, 6, n + "velocity", 3, "Velocity", noted("Velocity seen from the reference" + axes));
  ports.outputs(group, 9, n + "angularVelocity", 3, "AngularVelocity",
                noted("Angular velocity seen from the reference" + axes));
  const Ports::Group second = ports.group(i, 6, sensor_acceleration, true);
  ports.outputs(second, 0, n + "acceleration", 3, "Acceleration", noted("Acceleration seen from the reference" + axes));
  ports.outputs(second, 3, n + "angularAcceleration", 3, "AngularAcceleration",
                noted("Angular acceleration seen from the reference" + axes));
}

}  // namespace sigmafmu
