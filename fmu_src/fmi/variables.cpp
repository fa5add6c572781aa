#include "fmi/variables.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "lie/r3xso3.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

constexpr double kTwoPi = 6.28318530717958647692;

Eigen::Map<Vector3d> vector3(double* values) { return Eigen::Map<Vector3d>(values); }

Vector3d rotation_vector(const View& view, int body) {
  return lie::log(lie::quaternion(view.q.data() + kPositionsPerBody * body));
}

// The rotation vector psi jumps where it is pi long; its rate does not: w_WB_B = T(psi) dpsi/dt.
double rotation_vector_rate(const View& view, int body, int i) {
  const Vector3d w_WB_B = view.v.segment<3>(kVelocitiesPerBody * body + 3);
  return lie::tangent_inverse_times(rotation_vector(view, body), w_WB_B)[i];
}

// Force and torque.
void reaction(const View& view, int j, double* values) {
  const Joint::Reaction r = view.system.reaction(view.evaluation, j, view.lambda.data() + view.system.lambda_index(j));
  vector3(values) = r.force;
  vector3(values + 3) = r.torque;
}

void joint_coordinate(const View& view, int c, double* value) {
  *value = view.system.coordinate_value(view.evaluation, c);
  if (!view.system.coordinate(c).is_angle()) return;
  *value += kTwoPi * std::round((view.state.turned[c] - *value) / kTwoPi);  // the state counts turns
}

void joint_rate(const View& view, int c, double* value) { *value = view.system.coordinate_rate(view.evaluation, c); }

int modal_position(const View& view, int body) { return view.system.modal_position(view.system.flexible_index(body)); }

int modal_velocity(const View& view, int body) { return view.system.modal_velocity(view.system.flexible_index(body)); }

void copy(const VectorXd& from, int first, int count, double* to) { std::copy_n(from.data() + first, count, to); }

void station_position(const View& view, int s, double* values) {
  const StationDef& station = view.mechanism.stations[s];
  Vector3d sum = Vector3d::Zero();
  for (int node : station.nodes) sum += view.system.node_position(view.evaluation, station.body, node);
  vector3(values) = sum / static_cast<double>(station.nodes.size());
}

void station_deflection(const View& view, int s, double* values) {
  const StationDef& station = view.mechanism.stations[s];
  const int f = view.system.flexible_index(station.body);
  const VectorXd& zeta = view.evaluation.flexible[f].zeta;
  const std::size_t axes = station.deflection_axes.size();
  std::fill_n(values, axes, 0.0);
  for (int node : station.nodes) {
    const Vector3d displacement = view.system.flexible(f).shape(node).lazyProduct(zeta);
    for (std::size_t i = 0; i < axes; ++i) values[i] += station.deflection_axes[i].dot(displacement);
  }
  for (std::size_t i = 0; i < axes; ++i) values[i] /= static_cast<double>(station.nodes.size());
}

// Kinetic, potential and total energy.
void energies(const View& view, int, double* values) {
  values[0] = view.system.kinetic_energy(view.evaluation);
  values[1] = view.system.potential_energy(view.evaluation);
  values[2] = values[0] + values[1];
}

template <typename Row>
int row_of(const std::vector<Row>& table, const std::string& name) {
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (table[i].name == name) return static_cast<int>(i);
  }
  throw std::logic_error("no row " + name);
}

// Adds variables to the table; one call per row of the interface's tables.
class Table {
 public:
  Table(const Mechanism& m, const System& s) : mechanism_(m), system_(s) {}

  std::vector<Variable> make() {
    const auto& d = mechanism_.multibody;
    for (int i = 0; i < system_.body_count(); ++i) body(i, d.bodies[i].name);
    for (int j = 0; j < system_.joint_count(); ++j) joint(j, d.joints[j].name);
    for (int s = 0; s < system_.spring_damper_count(); ++s) spring_damper(s, d.spring_dampers[s].name);
    for (std::size_t s = 0; s < mechanism_.stations.size(); ++s) station(static_cast<int>(s), mechanism_.stations[s]);
    for (std::size_t l = 0; l < d.loads.size(); ++l) load(static_cast<int>(l), d.loads[l]);
    global();
    integrator();
    return std::move(variables_);
  }

 private:
  using Output = void (*)(const View&, int, double*);
  using Rate = double (*)(const View&, int, int);
  using Parameter = double& (*)(Mechanism&, int, int);

  Variable& add(std::string name, const char* type, std::string description) {
    Variable v;
    v.name = std::move(name);
    v.description = std::move(description);
    if (type) {
      v.type = &real_types()[row_of(real_types(), type)];
      v.unit = v.type->unit;
      v.min = v.type->min;
      v.max = v.type->max;
    }
    variables_.push_back(std::move(v));
    return variables_.back();
  }
  // Calls make(index, suffix) for a vector's elements, named [1], [2], ...
  template <typename Make>
  void elements(int count, Make make) {
    for (int i = 0; i < count; ++i) make(i, "[" + std::to_string(i + 1) + "]");
  }
  // Outputs that are computed together.
  struct Group {
    int object;
    Output compute;
    bool needs_accelerations;
    int start;  // among the values of all outputs
  };
  Group group(int object, int size, Output compute, bool needs_accelerations = false) {
    output_count_ += size;
    return {object, compute, needs_accelerations, output_count_ - size};
  }
  Variable& output(const Group& group, int component, const std::string& name, const char* type,
                   const std::string& description) {
    Variable& v = add(name, type, description);
    v.object = group.object;
    v.output = group.compute;
    v.needs_accelerations = group.needs_accelerations;
    v.group = group.start;
    v.component = component;
    return v;
  }
  void outputs(const Group& group, int first, const std::string& name, int count, const char* type,
               const std::string& description, Rate rate = nullptr) {
    elements(count, [&](int i, const std::string& suffix) {
      output(group, first + i, name + suffix, type, description).rate = rate;
    });
  }
  // A vector or scalar that is a group of its own.
  void outputs(int object, const std::string& name, int count, const char* type, const std::string& description,
               Output compute, bool needs_accelerations = false) {
    outputs(group(object, count, compute, needs_accelerations), 0, name, count, type, description);
  }
  Variable& output_scalar(int object, const std::string& name, const char* type, const std::string& description,
                          Output compute) {
    return output(group(object, 1, compute), 0, name, type, description);
  }
  Variable& parameter(int object, const std::string& name, const char* type, const std::string& description,
                      Parameter access, Variability variability) {
    Variable& v = add(name, type, description);
    v.causality = Causality::parameter;
    v.variability = variability;
    v.object = object;
    v.parameter = access;
    return v;
  }
  void parameters(int object, const std::string& name, int count, const char* type, const std::string& description,
                  Parameter access, Variability variability) {
    elements(count, [&](int i, const std::string& suffix) {
      parameter(object, name + suffix, type, description, access, variability).component = i;
    });
  }
  Variable& initial(const InitialValue& what, const std::string& suffix, const char* type,
                    const std::string& description) {
    Variable& v =
        add(initial_name(mechanism_.multibody, what) + suffix, type, description + "; stays if set, gives way if not");
    v.causality = Causality::parameter;
    v.variability = Variability::fixed;
    v.initial = what;
    return v;
  }
  void initial_vector(InitialValue what, int count, const char* type, const std::string& description) {
    elements(count, [&](int i, const std::string& suffix) {
      what.component = i;
      initial(what, suffix, type, description);
    });
  }
  void input(int index, const std::string& name, const char* type, const std::string& description) {
    Variable& v = add(name, type, description);
    v.causality = Causality::input;
    v.input = index;
  }
  void inputs(int first, const std::string& name, const char* type, const std::string& description) {
    elements(3, [&](int i, const std::string& suffix) { input(first + i, name + suffix, type, description); });
  }

  void body(int b, const std::string& n);
  void inertia(int b, const std::string& n);
  void modal(int b, const std::string& n, const ModalDef& d);
  void joint(int j, const std::string& n);
  void spring_damper(int s, const std::string& n);
  void station(int s, const StationDef& d);
  void load(int l, const LoadDef& d);
  void global();
  void integrator();

  const Mechanism& mechanism_;
  const System& system_;
  std::vector<Variable> variables_;
  int output_count_ = 0;
};

void Table::body(int b, const std::string& n) {
  using V = const View&;
  const auto& definition = mechanism_.multibody.bodies[b];
  const std::string origin = definition.modal ? "the frame's origin" : "the centre of mass";
  outputs(b, n + ".position", 3, "Position", "Position of " + origin + " in W",
          [](V v, int o, double* x) { vector3(x) = v.q.segment<3>(kPositionsPerBody * o); });
  outputs(b, n + ".quaternion", 4, "Quaternion", "Orientation R_WB as unit quaternion (w, x, y, z)",
          [](V v, int o, double* x) { std::copy_n(v.q.data() + kPositionsPerBody * o + 3, 4, x); });
  outputs(group(b, 3, [](V v, int o, double* x) { vector3(x) = rotation_vector(v, o); }), 0, n + ".rotationVector", 3,
          "Angle", "Orientation R_WB as rotation vector, at most pi long", rotation_vector_rate);
  outputs(b, n + ".velocity", 3, "Velocity", "Velocity of " + origin + " in W",
          [](V v, int o, double* x) { vector3(x) = v.v.segment<3>(kVelocitiesPerBody * o); });
  outputs(b, n + ".angularVelocity", 3, "AngularVelocity", "Angular velocity in body axes",
          [](V v, int o, double* x) { vector3(x) = v.v.segment<3>(kVelocitiesPerBody * o + 3); });
  outputs(
      b, n + ".acceleration", 3, "Acceleration", "Acceleration of " + origin + " in W",
      [](V v, int o, double* x) { vector3(x) = v.vdot.segment<3>(kVelocitiesPerBody * o); }, true);
  outputs(
      b, n + ".angularAcceleration", 3, "AngularAcceleration", "Angular acceleration in body axes",
      [](V v, int o, double* x) { vector3(x) = v.vdot.segment<3>(kVelocitiesPerBody * o + 3); }, true);
  inputs(system_.force_index(b), n + ".force", "Force", "Force applied at " + origin + ", in W");
  inputs(system_.force_index(b) + 3, n + ".torque", "Torque", "Torque applied, in body axes");

  if (definition.modal) {
    modal(b, n, *definition.modal);
  } else {
    inertia(b, n);
  }
  using Kind = InitialValue::Kind;
  initial_vector({Kind::position, b}, 3, "Position", "Initial position in W");
  initial_vector({Kind::quaternion, b}, 4, "Quaternion",
                 "Initial orientation R_WB (w, x, y, z), normalized, set as a whole");
  initial_vector({Kind::velocity, b}, 3, "Velocity", "Initial velocity in W");
  initial_vector({Kind::angular_velocity, b}, 3, "AngularVelocity", "Initial angular velocity in body axes");
}

void Table::inertia(int b, const std::string& n) {
  constexpr auto fixed = Variability::fixed;
  Variable& mass = parameter(
      b, n + ".mass", "Mass", "Mass", [](Mechanism& m, int o, int) -> double& { return m.multibody.bodies[o].mass; },
      fixed);
  mass.above_min = true;
  const char* moments[] = {"xx", "yy", "zz"};
  for (int i = 0; i < 3; ++i) {
    Variable& v = parameter(
        b, n + ".inertia." + moments[i], "MomentOfInertia", "Moment of inertia about the centre of mass, body axes",
        [](Mechanism& m, int o, int c) -> double& { return m.multibody.bodies[o].inertia[c]; }, fixed);
    v.component = i;
    v.above_min = true;
  }
  const char* products[] = {"xy", "xz", "yz"};
  for (int i = 0; i < 3; ++i) {
    parameter(
        b, n + ".inertia." + products[i], "ProductOfInertia",
        "Off-diagonal element of the inertia matrix about the centre of mass, body axes",
        [](Mechanism& m, int o, int c) -> double& { return m.multibody.bodies[o].inertia_products[c]; }, fixed)
        .component = i;
  }
}

void Table::modal(int b, const std::string& n, const ModalDef& d) {
  using V = const View&;
  using M = Mechanism&;
  constexpr auto tunable = Variability::tunable;
  const int modes = d.mode_count();
  outputs(b, n + ".modal", modes, "Deflection", "Modal coordinate",
          [](V v, int o, double* x) { copy(v.q, modal_position(v, o), v.system.modes(o), x); });
  outputs(b, n + ".modalRate", modes, "DeflectionRate", "Rate of the modal coordinate",
          [](V v, int o, double* x) { copy(v.v, modal_velocity(v, o), v.system.modes(o), x); });
  initial_vector({InitialValue::Kind::modal, b}, modes, "Deflection", "Initial modal coordinate");
  initial_vector({InitialValue::Kind::modal_rate, b}, modes, "DeflectionRate", "Initial rate of the modal coordinate");
  parameter(
      b, n + ".massDamping", "MassDamping", "Rayleigh damping: this times the modal mass matrix",
      [](M m, int o, int) -> double& { return m.multibody.bodies[o].modal->mass_damping; }, tunable);
  parameter(
      b, n + ".stiffnessDamping", "StiffnessDamping", "Rayleigh damping: this times the modal stiffness matrix",
      [](M m, int o, int) -> double& { return m.multibody.bodies[o].modal->stiffness_damping; }, tunable);
}

void Table::joint(int j, const std::string& n) {
  using Kind = InitialValue::Kind;
  const Joint& joint = system_.joint(j);
  const int c = system_.coordinate_index(j);
  if (joint.type() == JointType::revolute) {
    output_scalar(c, n + ".angle", "Angle", "Joint angle, counting turns", joint_coordinate);
    output_scalar(c, n + ".angularRate", "AngularVelocity", "Rate of the joint angle", joint_rate);
    input(system_.motor_index(c), n + ".motorTorque", "Torque", "Torque about the joint axis on the second body");
    initial({Kind::joint_coordinate, j}, "", "Angle", "Initial joint angle, counting turns");
    initial({Kind::joint_rate, j}, "", "AngularVelocity", "Initial rate of the joint angle");
  } else if (joint.type() == JointType::prismatic) {
    output_scalar(c, n + ".displacement", "Displacement", "Displacement along the joint axis", joint_coordinate);
    output_scalar(c, n + ".rate", "Velocity", "Rate of the displacement", joint_rate);
    input(system_.motor_index(c), n + ".actuatorForce", "Force", "Force along the joint axis on the second body");
    initial({Kind::joint_coordinate, j}, "", "Displacement", "Initial displacement along the joint axis");
    initial({Kind::joint_rate, j}, "", "Velocity", "Initial rate of the displacement");
  }
  const char* force = "Force of the joint on the second body, in W";
  const char* torque = "Torque of the joint on the second body about the joint's point on it, in W";
  const Group both = group(j, 6, reaction, true);
  outputs(both, 0, n + ".reactionForce", 3, "Force", force);
  if (joint.type() == JointType::spherical) {  // exactly zero, not the rounding of a difference
    outputs(j, n + ".reactionTorque", 3, "Torque", torque, [](const View&, int, double* x) { vector3(x).setZero(); });
  } else {
    outputs(both, 3, n + ".reactionTorque", 3, "Torque", torque);
  }
}

void Table::spring_damper(int s, const std::string& n) {
  outputs(s, n + ".position", 3, "Displacement", "Attachment point on the second body, in W",
          [](const View& v, int o, double* x) {
            vector3(x) = v.system.spring_damper(o).position(v.system.spring_damper_kinematics(v.evaluation, o));
          });
  outputs(s, n + ".force", 3, "Force", "Force of spring and damper (actuator excluded) on the second body, in W",
          [](const View& v, int o, double* x) {
            vector3(x) = v.system.spring_damper(o).force(v.system.spring_damper_kinematics(v.evaluation, o));
          });
  inputs(system_.actuator_index(s), n + ".actuatorForce", "Force",
         "Actuator force on the attachment point of the second body, in W");
  parameters(
      s, n + ".stiffness", 3, "Stiffness", "Stiffness along the axes of W",
      [](Mechanism& m, int o, int c) -> double& { return m.multibody.spring_dampers[o].stiffness[c]; },
      Variability::tunable);
  parameters(
      s, n + ".damping", 3, "Damping", "Damping along the axes of W",
      [](Mechanism& m, int o, int c) -> double& { return m.multibody.spring_dampers[o].damping[c]; },
      Variability::tunable);
}

void Table::station(int s, const StationDef& d) {
  outputs(s, d.name + ".position", 3, "Displacement", "Position in W: " + d.description, station_position);
  const int axes = static_cast<int>(d.deflection_axes.size());
  const std::string deflection = "Displacement by deformation, in body axes: " + d.description;
  if (axes == 1) {
    output_scalar(s, d.name + ".deflection", "Deflection", deflection, station_deflection);
  } else {
    outputs(s, d.name + ".deflection", axes, "Deflection", deflection, station_deflection);
  }
}

void Table::load(int l, const LoadDef& d) {
  parameters(
      l, d.name + ".force", 3, "Force", "Constant force at the centre of mass, in W: " + d.description,
      [](Mechanism& m, int o, int c) -> double& { return m.multibody.loads[o].force[c]; }, Variability::tunable);
  parameters(
      l, d.name + ".torque", 3, "Torque", "Constant torque, in W: " + d.description,
      [](Mechanism& m, int o, int c) -> double& { return m.multibody.loads[o].torque[c]; }, Variability::tunable);
}

void Table::global() {
  using V = const View&;
  parameters(
      0, "gravity", 3, "Acceleration", "Gravitational acceleration in W",
      [](Mechanism& m, int, int c) -> double& { return m.multibody.gravity[c]; }, Variability::tunable);
  const Group energy = group(0, 3, energies);
  output(energy, 0, "energy.kinetic", "Energy", "Kinetic energy of all bodies");
  output(energy, 1, "energy.potential", "Energy",
         system_.flexible_count() > 0 ? "Potential energy of gravity (zero at the origin of W), springs and deformation"
                                      : "Potential energy of gravity (zero at the origin of W) and springs");
  output(energy, 2, "energy.total", "Energy", "Kinetic and potential energy");
  output_scalar(0, "constraint.positionResidual", "Residual",
                "Largest violation of a joint equation (m, or 1 for directions)",
                [](V v, int, double* x) { *x = v.system.position_residual(v.evaluation); });
  output_scalar(0, "constraint.velocityResidual", "Residual",
                "Largest violation of the time derivative of a joint equation (m/s, or 1/s for directions)",
                [](V v, int, double* x) { *x = v.system.velocity_residual(v.evaluation); });
}

void Table::integrator() {
  const std::string n = "integrator.";
  auto real = [&](const char* name, const char* type, const char* description) {
    const int row = row_of(real_settings(), name);
    const RealSetting& setting = real_settings()[row];
    Variable& v = parameter(
        row, n + name, type, description,
        [](Mechanism& m, int o, int) -> double& { return m.integrator.*real_settings()[o].value; }, Variability::fixed);
    v.min = setting.min;
    v.max = setting.max;
    v.above_min = setting.above_min;
  };
  real("stepSize", "Time", "Largest internal step");
  real("spectralRadius", "Fraction", "Spectral radius at infinite frequency: 1 no damping, 0 strongest");
  real("sigma", "Number", "Sigma modification: 0 geom1, 1 tangent-free, any real value");
  real("absoluteTolerance", "Tolerance",
       "Allowed velocity increment of Newton's method, error of a step of rkmk54 (m/s and rad/s)");
  real("relativeTolerance", "Tolerance", "The same, relative to a body's velocity");
  real("errorTolerance", "Tolerance",
       "With stepControl error: allowed position error of an internal step, relative to the mechanism's size; of "
       "rotations in rad");

  auto integer = [&](const char* name, const char* description) {
    const int row = row_of(integer_settings(), name);
    const IntegerSetting& setting = integer_settings()[row];
    Variable& v = add(n + name, nullptr, description);
    v.causality = Causality::parameter;
    v.variability = Variability::fixed;
    v.integer = true;
    v.object = row;
    v.option = [](Mechanism& m, int o) -> int& { return m.integrator.*integer_settings()[o].value; };
    v.min = setting.min;
    v.max = setting.max;
    v.enumeration = setting.enumeration;
  };
  integer("maxNewtonIterations", "Newton iterations in one attempt at an internal step");
  integer("maxHalvings",
          "How often an internal step that fails is halved before fmi2DoStep gives up; 0 bounds the time of a step");
  for (const IntegerSetting& setting : integer_settings()) {
    if (setting.enumeration) integer(setting.name, setting.enumeration->description);
  }

  output_scalar(
      0, n + "errorEstimate", "Estimate",
      "Estimated position error of the last internal step, relative to the mechanism's size; of rotations in rad",
      [](const View& v, int, double* x) { *x = v.state.error; });
  output_scalar(0, n + "largestErrorEstimate", "Estimate", "Largest estimate of all internal steps since the start",
                [](const View& v, int, double* x) { *x = v.state.largest_error; });

  auto counter = [&](const char* name, const char* description, Output output) {
    Variable& v = output_scalar(0, n + name, nullptr, description, output);
    v.causality = Causality::local;  // some importers read every output as Real
    v.integer = true;
    v.variability = Variability::discrete;
  };
  counter("steps", "Internal steps since the start",
          [](const View& v, int, double* x) { *x = static_cast<double>(v.state.counters.steps); });
  counter("newtonIterations", "Newton iterations since the start (rkmk: of projections)",
          [](const View& v, int, double* x) { *x = static_cast<double>(v.state.counters.newton_iterations); });
  counter("jacobianEvaluations", "Matrices factorized since the start",
          [](const View& v, int, double* x) { *x = static_cast<double>(v.state.counters.jacobian_evaluations); });
  counter("retries", "Internal steps repeated with half the step since the start",
          [](const View& v, int, double* x) { *x = static_cast<double>(v.state.counters.retries); });
}

}  // namespace

double Variable::value(const Mechanism& mechanism) const {
  if (initial) return initial_value(mechanism.multibody, *initial);
  Mechanism& m = const_cast<Mechanism&>(mechanism);  // the accessors serve reading and writing
  return option ? option(m, object) : parameter(m, object, component);
}

void Variable::set_value(Mechanism& mechanism, double value) const {
  if (initial) {
    set_initial_value(mechanism.multibody, *initial, value);
  } else if (option) {
    option(mechanism, object) = static_cast<int>(value);
  } else {
    parameter(mechanism, object, component) = value;
  }
}

std::string Variable::complaint(double value) const {
  const bool low = above_min ? !(value > min) : !(value >= min);
  if (std::isfinite(value) && !low && value <= max) return {};
  std::ostringstream text = text_stream();
  text << name << " is " << value;
  if (unit && std::string(unit) != "1") text << " " << unit;
  text << "; it must be ";
  if (enumeration) {
    for (std::size_t i = 0; i < enumeration->items.size(); ++i) {
      text << (i == 0                               ? ""
               : i + 1 == enumeration->items.size() ? " or "
                                                    : ", ")
           << i + 1 << " (" << enumeration->items[i].name << ")";
    }
  } else {
    text << "finite";
    if (std::isfinite(min)) text << (above_min ? ", above " : ", at least ") << min;
    if (std::isfinite(max)) text << ", at most " << max;
  }
  text << ".";
  return text.str();
}

OutputValues::OutputValues(const std::vector<Variable>& variables) {
  int count = 0;
  for (const Variable& v : variables) {
    if (v.output) count = std::max(count, v.group + v.component + 1);
  }
  values_.resize(count);
  known_.resize(count);
}

double OutputValues::operator()(const Variable& v, const View& view) {
  double* values = values_.data() + v.group;
  if (!known_[v.group]) {
    v.output(view, v.object, values);
    known_[v.group] = 1;
  }
  return values[v.component];
}

void OutputValues::forget() { std::fill(known_.begin(), known_.end(), char{0}); }

std::vector<Variable> make_variables(const Mechanism& mechanism, const System& system) {
  return Table(mechanism, system).make();
}

}  // namespace sigmafmu
