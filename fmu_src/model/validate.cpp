#include <algorithm>
#include <set>
#include <utility>

#include "model/mechanism.h"
#include "model/names.h"
#include "model/settings_table.h"
#include "model/units.h"
#include "model/validation.h"

namespace sigmafmu {
namespace {

using namespace validation;

bool is_rotation(const Matrix3d& R) {
  return (R.transpose() * R - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-12 && R.determinant() > 0;
}

void validate_length(const MultibodyDef& d, const JointDef& j) {
  if (j.type != JointType::distance) {
    if (!std::isnan(j.length)) fail(j.name, " has the length ", j.length, " m; joints of its type must have none.");
    return;
  }
  const bool moving = (j.body1 == kGround && j.frame1.node >= 0) || (j.body2 == kGround && j.frame2.node >= 0);
  if (std::isnan(j.length) && moving) fail(j.name, " holds to a moving frame of the ground; its length must be set.");
  const double length = rod_length(d, j);
  if (length > 0 && std::isfinite(length)) return;
  if (std::isnan(j.length)) fail(j.name, " keeps points apart that coincide at the start; they must have a distance.");
  fail(j.name, ".length is ", length, " m; it must be finite, above 0.");
}

void validate_pitch(const JointDef& j) {
  if (j.type == JointType::screw) {
    if (std::isnan(j.pitch)) fail(j.name, " is a screw without a pitch; it must have one.");
    if (j.pitch == 0 || !std::isfinite(j.pitch)) {
      fail(j.name, ".pitch is ", j.pitch, " m; it must be finite, and not 0.");
    }
  } else if (!std::isnan(j.pitch)) {
    fail(j.name, " has the pitch ", j.pitch, " m; joints of its type must have none.");
  }
}

void validate_radius(const JointDef& j) {
  if (j.type == JointType::rolling_disk) {
    if (std::isnan(j.radius)) fail(j.name, " is a rolling disk without a radius; it must have one.");
    if (!(j.radius > 0) || !std::isfinite(j.radius)) {
      fail(j.name, ".radius is ", j.radius, " m; it must be finite, above 0.");
    }
  } else if (!std::isnan(j.radius)) {
    fail(j.name, " has the radius ", j.radius, " m; joints of its type must have none.");
  }
}

void validate_joint(const MultibodyDef& d, const JointDef& j) {
  check_frame(j.name + ".frame1", j.frame1);
  check_frame(j.name + ".frame2", j.frame2);
  for (const auto& values : {j.initial_coordinates, j.initial_rates}) {
    for (std::size_t c = 0; c < values.size(); ++c) {
      const double x = values[c];
      if (std::isnan(x)) continue;  // not set
      if (static_cast<int>(c) >= j.coordinate_count()) {
        fail(j.name, " has the initial value ", x, "; joints of its type must not have ",
             c == 0   ? "one."
             : c == 1 ? "a second."
                      : "a third.");
      }
      if (!std::isfinite(x)) fail(j.name, " has the initial value ", x, "; it must be finite.");
    }
  }
  validate_length(d, j);
  validate_pitch(j);
  validate_radius(j);
  check_point(j.name + ".reaction.point", j.reaction.point);
}

// The parameters of a force against what their types allow.
template <typename Def>
void validate_force(const MultibodyDef& d, const Def& force) {
  for (const Parameter<Def>& p : Def::parameters()) {
    const RealType& type = real_type(type_of(d, force, p));
    const double* values = p.values(const_cast<Def&>(force));  // the accessors serve reading and writing
    for (int i = 0; i < std::max(1, p.size); ++i) {
      const bool finite = std::isfinite(values[i]);
      if (finite && values[i] >= type.min && values[i] <= type.max) continue;
      const std::string component = p.size > 0 ? "[" + std::to_string(i + 1) + "]" : "";
      const std::string name = variable_name(d, force, p.name) + component;
      if (finite && type.min > 0) {
        std::ostringstream least = text_stream(6);
        least << type.min;
        fail(name, " is ", values[i], " ", type.unit, "; it must be at least ", least.str(), ".");
      }
      fail(name, " is ", values[i], " ", type.unit, finite ? "; it must not be negative." : "; it must be finite.");
    }
  }
}

void validate_table(const std::string& name, const TableDef& table) {
  const std::size_t points = table.times.size();
  if (points != table.values.size() || points < 2) {
    fail(name, " has a table of ", points, " times and ", table.values.size(),
         " values; it must have as many of both, at least two.");
  }
  for (std::size_t i = 0; i < points; ++i) {
    if (!std::isfinite(table.times[i]) || !std::isfinite(table.values[i])) {
      fail("Point ", i + 1, " of the table of ", name, " is ", table.values[i], " at ", table.times[i],
           " s; both must be finite.");
    }
    if (i > 0 && !(table.times[i] > table.times[i - 1])) {
      fail("Times ", i, " and ", i + 1, " of the table of ", name, " are ", table.times[i - 1], " s and ",
           table.times[i], " s; they must ascend.");
    }
  }
}

void validate_drive(const MultibodyDef& d, const DriveDef& drive) {
  const std::string name = "the drive of " + d.joints[drive.joint].name;
  for (double x : {drive.value, drive.first_derivative, drive.second_derivative}) {
    if (!std::isfinite(x)) fail("The value of ", name, " is ", x, "; it must be finite.");
  }
  if (!drive.table) return;
  if (drive.input) fail("The drive of ", d.joints[drive.joint].name, " has a table and is an input; it must be one.");
  validate_table(name, *drive.table);
}

void validate_motion(const MotionDef& m) {
  check_frame(m.name, {m.position, m.axes});
  for (const auto& table : m.tables) {
    if (!table) continue;
    if (m.input) fail(m.name, " has a table and is an input; it must be one of them.");
    validate_table(m.name, *table);
  }
}

void validate_station(const StationDef& s, const References& bodies) {
  bodies.not_ground(s.name, "is a point of", s.body);
  const std::string body = bodies.name_of(s.body);
  if (!bodies.is_flexible(s.body)) fail(s.name, " is a point of ", body, "; it must be one of a flexible body.");
  if (s.nodes.empty()) fail(s.name, " has no nodes of ", body, "; there must be at least one.");
  for (int node : s.nodes) {
    if (node >= 0 && node < bodies.nodes(s.body)) continue;
    fail(s.name, " is at node ", node, " of ", body, "; allowed are 0 to ", bodies.nodes(s.body) - 1, ".");
  }
  for (std::size_t i = 0; i < s.deflection_axes.size(); ++i) {
    const double length = s.deflection_axes[i].norm();
    if (std::abs(length - 1) < 1e-9) continue;
    fail(s.name, ".deflectionAxes[", i + 1, "] has the length ", length, "; it must be 1.");
  }
}

void validate_sensor(const SensorDef& s, const References& bodies) {
  bodies.body(s.name, s.body);
  bodies.node(s.name, s.body, s.frame.node);
  check_frame(s.name + ".frame", s.frame);
  bodies.body(s.name, s.reference);
  bodies.node(s.name, s.reference, s.reference_frame.node);
  check_frame(s.name + ".referenceFrame", s.reference_frame);
}

// No coordinate has two of these.
template <typename Def>
void validate_once(const std::vector<Def>& elements, const MultibodyDef& d, const char* what) {
  std::set<std::pair<int, int>> known;
  for (const Def& element : elements) {
    if (known.emplace(element.joint, element.coordinate).second) continue;
    fail(d.joints[element.joint].name, " has two ", what, " on the same coordinate; one is allowed.");
  }
}

void validate_motors(const std::vector<RotationMotorDef>& motors, const MultibodyDef& d) {
  std::set<int> known;
  for (const RotationMotorDef& motor : motors) {
    if (!known.insert(motor.joint).second)
      fail(d.joints[motor.joint].name, " has two rotation motors; one is allowed.");
  }
}

void validate_held(const MultibodyDef& d) {
  for (const auto& held : d.held) {
    const InitialValue& what = held.first;
    if (what.component >= 0 && what.component < component_count(d, what)) continue;
    fail("An initial value that is held belongs to object ", what.object, ", component ", what.component,
         "; the mechanism must have it.");
  }
}

void validate_names(const MultibodyDef& d, const std::vector<StationDef>& stations,
                    const std::vector<SensorDef>& sensors) {
  Names names;
  const auto add = [&](const auto& elements, const char* kind) {
    for (std::size_t i = 0; i < elements.size(); ++i) names.add(elements[i].name, kind, i);
  };
  add(d.bodies, "body");
  add(d.joints, "joint");
  add(d.couplings, "coupling");
  add(d.motions, "motion");
  for_each_force_list(d, [&](const char*, const auto& forces) {
    using Def = typename std::decay_t<decltype(forces)>::value_type;
    if constexpr (HasName<Def>::value) add(forces, Def::kKind);
  });
  add(stations, "station");
  add(sensors, "sensor");
  names.check_variables();
}

}  // namespace

void validation::check_point(const std::string& name, const Vector3d& point) { require_finite(name, point, "m"); }

void validation::check_frame(const std::string& name, const Frame& frame) {
  check_point(name + ".origin", frame.origin);
  if (frame.axes.allFinite() && is_rotation(frame.axes)) return;
  std::ostringstream columns = text_stream();
  for (int i = 0; i < 3; ++i) {
    const auto a = frame.axes.col(i);
    columns << (i > 0 ? ", (" : "(") << a[0] << ", " << a[1] << ", " << a[2] << ")";
  }
  fail(name, ".axes are ", columns.str(), "; they must be orthonormal and right-handed.");
}

void validation::check_positive(const std::string& name, double value, const char* unit) {
  if (value > 0 && std::isfinite(value)) return;
  fail(name, " is ", value, " ", unit, "; it must be positive and finite.");
}

void validation::validate_structure(const MultibodyDef& d) {
  if (d.bodies.empty()) fail("The mechanism has no bodies; it must have at least one.");
  validate_names(d, {}, {});
  for (const RigidBodyDef& b : d.bodies) {
    if (b.modal) validate_modal(b.name, *b.modal);
  }
  const References of(d);
  for (const JointDef& j : d.joints) {
    of.pair(j.name, j.body1, j.body2);
    of.node(j.name, j.body1, j.frame1.node);
    of.node(j.name, j.body2, j.frame2.node);
  }
  for_each_force_list(d, [&](const char*, const auto& forces) {
    for (const auto& force : forces) force.check(of);
  });
  for (const DriveDef& drive : d.drives) of.coordinate("A drive", drive.joint, drive.coordinate);
  for_each_force_list(d, [&](const char*, const auto& forces) {
    using Def = typename std::decay_t<decltype(forces)>::value_type;
    if constexpr (std::is_base_of_v<OnCoordinate, Def>) validate_once(forces, d, Def::kSeveral);
    if constexpr (std::is_same_v<RotationMotorDef, Def>) validate_motors(forces, d);
  });
  validate_once(d.drives, d, "drives");
  for (const CouplingDef& coupling : d.couplings) coupling.check(d);
  validate_held(d);
}

void validate(const MultibodyDef& d) {
  validate_structure(d);
  require_finite("gravity", d.gravity, "m/s2");
  for (const auto& x : d.bodies) validate_body(d, x);
  for (const auto& x : d.joints) validate_joint(d, x);
  for_each_force_list(d, [&](const char*, const auto& forces) {
    for (const auto& force : forces) {
      validate_force(d, force);
      force.check_values();
    }
  });
  for (const auto& x : d.drives) validate_drive(d, x);
  for (const auto& x : d.motions) validate_motion(x);
}

void validate(const IntegratorSettings& settings) {
  for (const RealSetting& s : real_settings()) {
    const double value = settings.*s.value;
    if (std::isfinite(value) && (s.above_min ? value > s.min : value >= s.min) && value <= s.max) continue;
    std::ostringstream allowed = text_stream();
    if (std::isfinite(s.min)) allowed << (s.above_min ? ", above " : ", at least ") << s.min;
    if (std::isfinite(s.max)) allowed << ", at most " << s.max;
    fail("integrator.", s.name, " is ", value, "; it must be finite", allowed.str(), ".");
  }
  for (const IntegerSetting& s : integer_settings()) {
    const int value = settings.*s.value;
    if (value < s.min || value > s.max) {
      fail("integrator.", s.name, " is ", value, "; it must be ", s.min, " to ", s.max, ".");
    }
  }
}

void validate(const Mechanism& m) {
  if (!is_identifier(m.name)) {
    fail("The name of the mechanism is \"", m.name, "\"; allowed are letters, digits and _, no digit first.");
  }
  validate(m.multibody);
  validate_names(m.multibody, m.stations, m.sensors);
  for (const StationDef& s : m.stations) validate_station(s, References(m.multibody));
  for (const SensorDef& s : m.sensors) validate_sensor(s, References(m.multibody));
  validate(m.integrator);
  check_positive("The stop time of the experiment", m.stop_time, "s");
  check_positive("The communication step of the experiment", m.communication_step, "s");
}

}  // namespace sigmafmu
