#include <algorithm>

#include "model/mechanism.h"
#include "model/names.h"
#include "model/settings_table.h"
#include "model/validation.h"

namespace sigmafmu {
namespace {

using namespace validation;

// The bodies of one definition, to which its other elements refer.
class Bodies {
 public:
  explicit Bodies(const MultibodyDef& d) : bodies_(d.bodies) {}

  void check(const std::string& name, int body) const {
    if (body < kGround || body >= size()) {
      fail(name, " refers to body ", body, "; allowed are -1 (ground) to ", size() - 1, ".");
    }
  }
  void check_pair(const std::string& name, int body1, int body2) const {
    check(name, body1), check(name, body2);
    if (body1 == body2) fail(name, " connects ", this->name(body1), " with itself; it must connect two bodies.");
  }
  void check_not_ground(const std::string& name, const char* verb, int body) const {
    if (body < 0 || body >= size()) fail(name, " ", verb, " body ", body, "; allowed are 0 to ", size() - 1, ".");
  }
  void check_node(const std::string& name, int body, int node) const {
    if (node == kFloatingFrame) return;
    if (!is_flexible(body)) {
      fail(name, " attaches to node ", node, " of ", this->name(body),
           ", which is not flexible; allowed is -1 (no node).");
    }
    if (node < 0 || node >= nodes(body)) {
      fail(name, " attaches to node ", node, " of ", this->name(body), "; allowed are -1 (floating frame) to ",
           nodes(body) - 1, ".");
    }
  }
  bool is_flexible(int body) const { return body != kGround && bodies_[body].modal; }
  int nodes(int body) const { return bodies_[body].modal->node_count(); }
  std::string name(int body) const { return body == kGround ? "the ground" : bodies_[body].name; }

 private:
  int size() const { return static_cast<int>(bodies_.size()); }
  const std::vector<RigidBodyDef>& bodies_;
};

bool is_rotation(const Matrix3d& R) {
  return (R.transpose() * R - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-12 && R.determinant() > 0;
}

void validate_frame(const std::string& name, const Frame& frame) {
  require_finite(name + ".origin", frame.origin, "m");
  if (frame.axes.allFinite() && is_rotation(frame.axes)) return;
  std::ostringstream columns = text_stream();
  for (int i = 0; i < 3; ++i) {
    const auto a = frame.axes.col(i);
    columns << (i > 0 ? ", (" : "(") << a[0] << ", " << a[1] << ", " << a[2] << ")";
  }
  fail(name, ".axes are ", columns.str(), "; they must be orthonormal and right-handed.");
}

void validate_joint(const JointDef& j) {
  validate_frame(j.name + ".frame1", j.frame1);
  validate_frame(j.name + ".frame2", j.frame2);
  for (double x : {j.initial_coordinate, j.initial_rate}) {
    if (std::isnan(x)) continue;  // not set
    if (!j.has_coordinate()) fail(j.name, " has the initial value ", x, "; joints of its type must not have one.");
    if (!std::isfinite(x)) fail(j.name, " has the initial value ", x, "; it must be finite.");
  }
}

void validate_spring_damper(const SpringDamperDef& s) {
  require_finite(s.name + ".point1", s.point1, "m");
  require_finite(s.name + ".point2", s.point2, "m");
  require_finite(s.name + ".stiffness", s.stiffness, "N/m");
  require_finite(s.name + ".damping", s.damping, "N.s/m");
  for (int i = 0; i < 3; ++i) {
    if (s.stiffness[i] < 0) {
      fail(s.name, ".stiffness[", i + 1, "] is ", s.stiffness[i], " N/m; it must not be negative.");
    }
    if (s.damping[i] < 0) {
      fail(s.name, ".damping[", i + 1, "] is ", s.damping[i], " N.s/m; it must not be negative.");
    }
  }
}

void validate_load(const LoadDef& load) {
  require_finite(load.name + ".force", load.force, "N");
  require_finite(load.name + ".torque", load.torque, "N.m");
}

void validate_station(const StationDef& s, const Bodies& bodies) {
  bodies.check_not_ground(s.name, "is a point of", s.body);
  const std::string body = bodies.name(s.body);
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

void validate_held(const MultibodyDef& d) {
  for (const auto& held : d.held) {
    const InitialValue& what = held.first;
    if (what.component >= 0 && what.component < component_count(d, what)) continue;
    fail("An initial value that is held belongs to object ", what.object, ", component ", what.component,
         "; the mechanism must have it.");
  }
}

void validate_names(const MultibodyDef& d, const std::vector<StationDef>& stations) {
  Names names;
  const auto add = [&](const auto& elements, const char* kind) {
    for (std::size_t i = 0; i < elements.size(); ++i) names.add(elements[i].name, kind, i);
  };
  add(d.bodies, "body");
  add(d.joints, "joint");
  add(d.spring_dampers, "spring-damper");
  add(d.loads, "load");
  add(stations, "station");
  names.check_variables();
}

void require_positive(const char* name, double value) {
  if (value > 0 && std::isfinite(value)) return;
  fail(name, " is ", value, " s; it must be positive and finite.");
}

}  // namespace

void validation::validate_structure(const MultibodyDef& d) {
  if (d.bodies.empty()) fail("The mechanism has no bodies; it must have at least one.");
  validate_names(d, {});
  for (const RigidBodyDef& b : d.bodies) {
    if (b.modal) validate_modal(b.name, *b.modal);
  }
  const Bodies bodies(d);
  for (const JointDef& j : d.joints) {
    bodies.check_pair(j.name, j.body1, j.body2);
    bodies.check_node(j.name, j.body1, j.frame1.node);
    bodies.check_node(j.name, j.body2, j.frame2.node);
  }
  for (const SpringDamperDef& s : d.spring_dampers) {
    bodies.check_pair(s.name, s.body1, s.body2);
    bodies.check_node(s.name, s.body1, s.node1);
    bodies.check_node(s.name, s.body2, s.node2);
  }
  for (const LoadDef& load : d.loads) bodies.check_not_ground(load.name, "acts on", load.body);
  validate_held(d);
}

void validate(const MultibodyDef& d) {
  validate_structure(d);
  require_finite("gravity", d.gravity, "m/s2");
  for (const auto& x : d.bodies) validate_body(x);
  for (const auto& x : d.joints) validate_joint(x);
  for (const auto& x : d.spring_dampers) validate_spring_damper(x);
  for (const auto& x : d.loads) validate_load(x);
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
  validate_names(m.multibody, m.stations);
  for (const StationDef& s : m.stations) validate_station(s, Bodies(m.multibody));
  validate(m.integrator);
  require_positive("The stop time of the experiment", m.stop_time);
  require_positive("The communication step of the experiment", m.communication_step);
}

}  // namespace sigmafmu
