#include "model/units.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace sigmafmu {

const std::vector<Unit>& units() {
  constexpr double kDegree = 57.29577951308232, kRpm = 9.549296585513721;
  static const std::vector<Unit> table = {
      // name, kg, m, s, rad
      {"1", 0, 0, 0, 0, {}},
      {"s", 0, 0, 1, 0, {{"ms", 1e3}, {"us", 1e6}}},
      {"1/s", 0, 0, -1, 0, {}},
      {"s/rad", 0, 0, 1, -1, {}},
      {"kg", 1, 0, 0, 0, {}},
      {"kg.m2", 1, 2, 0, 0, {}},
      {"kg/m", 1, -1, 0, 0, {}},
      {"m", 0, 1, 0, 0, {{"mm", 1e3}, {"um", 1e6}}},
      {"s/m", 0, -1, 1, 0, {}},
      {"m/s", 0, 1, -1, 0, {{"mm/s", 1e3}}},
      {"m/s2", 0, 1, -2, 0, {}},
      {"rad", 0, 0, 0, 1, {{"deg", kDegree}}},
      {"rad/s", 0, 0, -1, 1, {{"rpm", kRpm}, {"deg/s", kDegree}}},
      {"rad/s2", 0, 0, -2, 1, {{"deg/s2", kDegree}}},
      {"N", 1, 1, -2, 0, {{"kN", 1e-3}}},
      {"N.m", 1, 2, -2, 0, {{"N.mm", 1e3}}},
      {"N/m", 1, 0, -2, 0, {{"N/mm", 1e-3}}},
      {"N.s/m", 1, 0, -1, 0, {}},
      {"N.m/rad", 1, 2, -2, -1, {}},
      {"N.m.s/rad", 1, 2, -1, -1, {}},
      {"N.s", 1, 1, -1, 0, {}},
      {"N.m.s", 1, 2, -1, 0, {}},
      {"J", 1, 2, -2, 0, {{"mJ", 1e3}}},
      {"W", 1, 2, -3, 0, {{"kW", 1e-3}}},
      {"Pa", 1, -1, -2, 0, {{"MPa", 1e-6}, {"GPa", 1e-9}}},
  };
  return table;
}

Scales scales(const MultibodyDef& definition) {
  Scales s;
  double mass = 0;
  for (const RigidBodyDef& b : definition.bodies) {
    mass += sigmafmu::mass(b);
    s.length = std::max(s.length, b.initial_position.norm());
    if (b.modal) s.length = std::max(s.length, b.modal->nodes.rowwise().norm().maxCoeff());
    s.velocity = std::max(s.velocity, b.initial_velocity.norm());
    s.angular_velocity = std::max(s.angular_velocity, b.initial_angular_velocity.norm());
  }
  for (const JointDef& j : definition.joints) {
    s.length = std::max({s.length, j.frame1.origin.norm(), j.frame2.origin.norm()});
  }
  for_each_force_list(definition, [&](const char*, const auto& forces) {
    for (const auto& force : forces) {
      force.points([&](int, const Vector3d& point, int) { s.length = std::max(s.length, point.norm()); });
    }
  });
  s.force = mass * definition.gravity.norm();
  s.torque = s.force * s.length;
  return s;
}

const std::vector<RealType>& real_types() {
  constexpr double inf = std::numeric_limits<double>::infinity();
  constexpr double kLeastScale = 1e-12;  // of what makes a law smooth
  using S = Scales;
  static const std::vector<RealType> table = {
      // name, quantity, unit, shown in, min, max, nominal
      {"Time", "Time", "s", nullptr, 0, inf, nullptr},
      {"Position", "Length", "m", nullptr, -inf, inf, &S::length},
      {"Displacement", "Length", "m", "mm", -inf, inf, &S::length},
      {"Distance", "Length", "m", "mm", 0, inf, &S::length},
      {"Gap", "Length", "m", "mm", -inf, inf, nullptr},
      {"Velocity", "Velocity", "m/s", nullptr, -inf, inf, &S::velocity},
      {"Deflection", "Length", "m", "mm", -inf, inf, nullptr},
      {"DeflectionRate", "Velocity", "m/s", "mm/s", -inf, inf, nullptr},
      {"Acceleration", "Acceleration", "m/s2", nullptr, -inf, inf, nullptr},
      {"Quaternion", "Dimensionless", "1", nullptr, -inf, inf, nullptr},
      {"Angle", "Angle", "rad", "deg", -inf, inf, nullptr},
      {"AngularVelocity", "AngularVelocity", "rad/s", "rpm", -inf, inf, &S::angular_velocity},
      {"AngularAcceleration", "AngularAcceleration", "rad/s2", nullptr, -inf, inf, nullptr},
      {"Mass", "Mass", "kg", nullptr, 0, inf, nullptr},
      {"MomentOfInertia", "MomentOfInertia", "kg.m2", nullptr, 0, inf, nullptr},
      {"ProductOfInertia", "MomentOfInertia", "kg.m2", nullptr, -inf, inf, nullptr},
      {"Force", "Force", "N", nullptr, -inf, inf, &S::force},
      {"Torque", "Torque", "N.m", nullptr, -inf, inf, &S::torque},
      {"Energy", "Energy", "J", nullptr, -inf, inf, nullptr},
      {"Momentum", "Momentum", "N.s", nullptr, -inf, inf, nullptr},
      {"AngularMomentum", "AngularMomentum", "N.m.s", nullptr, -inf, inf, nullptr},
      {"Power", "Power", "W", nullptr, -inf, inf, nullptr},
      {"Stiffness", "TranslationalSpringConstant", "N/m", nullptr, 0, inf, nullptr},
      {"Damping", "TranslationalDampingConstant", "N.s/m", nullptr, 0, inf, nullptr},
      {"CrossStiffness", "TranslationalSpringConstant", "N/m", nullptr, -inf, inf, nullptr},
      {"CrossDamping", "TranslationalDampingConstant", "N.s/m", nullptr, -inf, inf, nullptr},
      {"Drag", "LinearDensity", "kg/m", nullptr, 0, inf, nullptr},
      {"RotationalDrag", "MomentOfInertia", "kg.m2", nullptr, 0, inf, nullptr},
      {"TorsionalStiffness", "RotationalSpringConstant", "N.m/rad", nullptr, 0, inf, nullptr},
      {"TorsionalDamping", "RotationalDampingConstant", "N.m.s/rad", nullptr, 0, inf, nullptr},
      {"Modulus", "ModulusOfElasticity", "Pa", "MPa", 0, inf, nullptr},
      {"Dissipation", "Slowness", "s/m", nullptr, 0, inf, nullptr},
      {"Coefficient", "Dimensionless", "1", nullptr, 0, inf, nullptr},
      {"SlipVelocity", "Velocity", "m/s", "mm/s", 0, inf, nullptr},
      {"FrictionForce", "Force", "N", nullptr, 0, inf, nullptr},
      {"FrictionTorque", "Torque", "N.m", nullptr, 0, inf, nullptr},
      {"RateScale", "Velocity", "m/s", nullptr, kLeastScale, inf, nullptr},
      {"AngularRateScale", "AngularVelocity", "rad/s", nullptr, kLeastScale, inf, nullptr},
      {"LengthScale", "Length", "m", "mm", kLeastScale, inf, nullptr},
      {"AngleScale", "Angle", "rad", "deg", kLeastScale, inf, nullptr},
      {"StopDamping", "ImpactDamping", "s/m", nullptr, 0, inf, nullptr},
      {"TorsionalStopDamping", "ImpactDamping", "s/rad", nullptr, 0, inf, nullptr},
      {"MassDamping", "DampingCoefficient", "1/s", nullptr, 0, inf, nullptr},
      {"StiffnessDamping", "Time", "s", nullptr, 0, inf, nullptr},
      {"Residual", "Dimensionless", "1", nullptr, 0, inf, nullptr},
      {"Tolerance", "Dimensionless", "1", nullptr, 0, inf, nullptr},
      {"Estimate", "Dimensionless", "1", nullptr, 0, inf, nullptr},
      {"Fraction", "Dimensionless", "1", nullptr, 0, 1, nullptr},
      {"Number", "Dimensionless", "1", nullptr, -inf, inf, nullptr},
  };
  return table;
}

const RealType& real_type(const std::string& name) {
  for (const RealType& type : real_types()) {
    if (type.name == name) return type;
  }
  throw std::logic_error("no type " + name);
}

}  // namespace sigmafmu
