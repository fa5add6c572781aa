// Python module sigmafmu._core: the integrator core without an FMU around it, for tests and studies.
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>

#include "fmi/modal_file.h"
#include "fmi/variables.h"
#include "integrator/integrator.h"
#include "integrator/spin_sigma.h"
#include "lie/r3xso3.h"
#include "mechanism.h"
#include "mechanisms.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace sigmafmu;
using Eigen::MatrixXd;

namespace {

lie::Quaterniond quat(const Vector4d& q) { return {q[0], q[1], q[2], q[3]}; }
Vector4d wxyz(const lie::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

void bind_lie(nb::module_& m) {
  m.def("hat", &lie::hat, "w"_a, "3x3 matrix with hat(w) x = w cross x.");
  m.def(
      "exp", [](const Vector3d& theta) { return wxyz(lie::exp(theta)); }, "theta"_a,
      "Unit quaternion (w, x, y, z) of a rotation vector [rad].");
  m.def(
      "log", [](const Vector4d& q) { return lie::log(quat(q)); }, "quaternion"_a,
      "Rotation vector [rad], at most pi long, of a unit quaternion (w, x, y, z).");
  m.def("rotation_matrix", [](const Vector4d& q) { return quat(q).toRotationMatrix(); }, "quaternion"_a);
  m.def("tangent", &lie::tangent, "theta"_a, "T(theta), 3x3.");
  m.def("tangent_times", &lie::tangent_times, "theta"_a, "c"_a);
  m.def("tangent_inverse", &lie::tangent_inverse, "theta"_a);
  m.def("tangent_inverse_times", &lie::tangent_inverse_times, "theta"_a, "c"_a);
  m.def("tangent_derivative", &lie::tangent_derivative, "theta"_a, "c"_a, "d(T(theta) c)/dtheta, 3x3.");
  m.def(
      "coefficients",
      [](double x) {
        const auto k = lie::so3_coefficients(x);
        return Vector4d(k.a, k.b, k.da, k.db);
      },
      "x"_a, "(a, b, a'/t, b'/t) at t^2 = x.");
  m.def(
      "compose", [](const lie::Vector7d& q, const lie::Vector6d& theta) { return lie::compose(q, theta); }, "q"_a,
      "theta"_a, "q o exp(theta) on R^3 x SO(3).");
}

// Dense views of one evaluation, for checking every derivative against differences.
struct PySystem {
  explicit PySystem(const MultibodyDef& d) : system((validate(d), d)), e(system.make_evaluation()), solver(system) {}

  void check(const VectorXd& q, const VectorXd& v) const {
    if (q.size() != system.position_size() || v.size() != system.velocity_size()) {
      throw std::invalid_argument("q or v has the wrong size");
    }
  }
  void check_forces(const VectorXd& lambda, const VectorXd& u) const {
    if (lambda.size() != system.constraint_size() || u.size() != system.input_size()) {
      throw std::invalid_argument("lambda or u has the wrong size");
    }
  }
  VectorXd residual(const VectorXd& q, const VectorXd& v, const VectorXd& vdot, const VectorXd& lambda,
                    const VectorXd& u) {
    check(q, v);
    check(q, vdot);
    check_forces(lambda, u);
    VectorXd r(system.velocity_size());
    system.evaluate(q, v, e);
    system.residual(e, vdot, lambda, u, r);
    return r;
  }
  nb::tuple constraints(const VectorXd& q, const VectorXd& v) {
    check(q, v);
    system.evaluate(q, v, e);
    system.constraint_rates(e);
    const int m = system.constraint_size(), n = system.velocity_size();
    VectorXd phi(m), phidot(m);
    MatrixXd B = MatrixXd::Zero(m, n), Z = MatrixXd::Zero(m, n);
    for (int j = 0; j < system.joint_count(); ++j) {
      phi.segment(system.lambda_index(j), e.joints[j].phi.size()) = e.joints[j].phi;
      phidot.segment(system.lambda_index(j), e.joints[j].phi.size()) = e.joints[j].phidot;
    }
    for (const auto& [joint, body, side] : system.pattern().incidences) {
      const int rows = system.joint(joint).equations();
      B.block(system.lambda_index(joint), 6 * body, rows, 6) = e.joints[joint].B[side];
      Z.block(system.lambda_index(joint), 6 * body, rows, 6) = e.joints[joint].Z[side];
    }
    for (std::size_t k = 0; k < e.modal_joints.size(); ++k) {
      const auto& [joint, flexible, side] = system.pattern().modal_incidences[k];
      const ModalRows& rows = e.modal_joints[k];
      const int row = system.lambda_index(joint), column = system.modal_velocity(flexible);
      B.block(row, column, rows.B.rows(), rows.B.cols()) = rows.B;
      Z.block(row, column, rows.Z.rows(), rows.Z.cols()) = rows.Z;
    }
    return nb::make_tuple(phi, phidot, B, Z);
  }
  nb::tuple linearization(const VectorXd& q, const VectorXd& v, const VectorXd& lambda, const VectorXd& u,
                          const std::optional<VectorXd>& vdot) {
    check(q, v);
    check_forces(lambda, u);
    system.evaluate(q, v, e);
    if (vdot) {
      check(q, *vdot);
      system.linearize(*vdot, lambda, u, e);
    } else if (system.flexible_count() == 0) {
      system.linearize(lambda, u, e);
    } else {
      throw std::invalid_argument("the linearization of flexible bodies needs vdot");
    }
    const int n = system.velocity_size();
    MatrixXd M = MatrixXd::Zero(n, n), C = MatrixXd::Zero(n, n), K = MatrixXd::Zero(n, n);
    for (int i = 0; i < system.body_count(); ++i) {
      M.block<3, 3>(6 * i, 6 * i).diagonal().setConstant(system.body(i).mass);
      M.block<3, 3>(6 * i + 3, 6 * i + 3) = system.body(i).J;
    }
    for (std::size_t p = 0; p < e.C.size(); ++p) {
      const auto [i, j] = system.pattern().body_pairs[p];
      C.block<6, 6>(6 * i, 6 * j) = e.C[p];
      K.block<6, 6>(6 * i, 6 * j) = e.K[p];
    }
    for (int f = 0; f < system.flexible_count(); ++f) {
      const int i = system.flexible_body(f);
      M.block<6, 6>(6 * i, 6 * i) += e.flexible[f].M;
    }
    const int bodies = system.body_count();
    auto first = [&](int node) { return node < bodies ? 6 * node : system.modal_velocity(node - bodies); };
    for (std::size_t p = 0; p < e.modal_C.size(); ++p) {
      const auto [i, j] = system.pattern().modal_pairs[p];
      const Eigen::Index rows = e.modal_C[p].rows(), columns = e.modal_C[p].cols();
      if (p < e.modal_M.size()) M.block(first(i), first(j), rows, columns) = e.modal_M[p];
      C.block(first(i), first(j), rows, columns) = e.modal_C[p];
      K.block(first(i), first(j), rows, columns) = e.modal_K[p];
    }
    return nb::make_tuple(M, C, K);
  }
  nb::tuple accelerations(const VectorXd& q, const VectorXd& v, const VectorXd& u) {
    check(q, v);
    VectorXd vdot(system.velocity_size()), lambda(system.constraint_size());
    check_forces(lambda, u);
    if (!solver.accelerations(q, v, u, vdot, lambda)) throw std::runtime_error("dependent constraints");
    return nb::make_tuple(vdot, lambda);
  }
  VectorXd jerk(const VectorXd& q, const VectorXd& v, const VectorXd& u) {
    const VectorXd vdot = nb::cast<VectorXd>(accelerations(q, v, u)[0]);
    InputSignal input(system.input_size());
    input.derivative[0] = u;
    VectorXd vddot(system.velocity_size());
    if (!solver.jerk(q, v, vdot, input, 0.0, vddot)) throw std::runtime_error("dependent constraints");
    return vddot;
  }
  double energy(const VectorXd& q, const VectorXd& v) {
    check(q, v);
    system.evaluate(q, v, e);
    return system.kinetic_energy(e) + system.potential_energy(e);
  }
  nb::tuple coordinate(const VectorXd& q, const VectorXd& v, int joint) {
    check(q, v);
    system.evaluate(q, v, e);
    const Joint& j = system.joint(joint);
    const auto &k1 = system.attachment(e, joint, 0), &k2 = system.attachment(e, joint, 1);
    return nb::make_tuple(j.coordinate(k1, k2), j.coordinate_rate(k1, k2));
  }
  nb::tuple reaction(const VectorXd& q, const VectorXd& v, const VectorXd& lambda, int joint) {
    check(q, v);
    if (lambda.size() != system.constraint_size()) throw std::invalid_argument("lambda has the wrong size");
    system.evaluate(q, v, e);
    const auto r = system.reaction(e, joint, lambda.data() + system.lambda_index(joint));
    return nb::make_tuple(r.force, r.torque);
  }
  VectorXd compose(const VectorXd& q, const VectorXd& theta) const {
    VectorXd result = q;
    for (int i = 0; i < system.body_count(); ++i) {
      result.segment<7>(7 * i) = lie::compose(q.segment<7>(7 * i), theta.segment<6>(6 * i));
    }
    result.tail(system.modal_count()) += theta.tail(system.modal_count());
    return result;
  }
  VectorXd node_position(const VectorXd& q, int body, int node) {
    check(q, VectorXd::Zero(system.velocity_size()));
    if (body < 0 || body >= system.body_count() || system.flexible_index(body) < 0) {
      throw std::invalid_argument("there is no such flexible body");
    }
    if (node < 0 || node >= system.flexible(system.flexible_index(body)).nodes()) {
      throw std::invalid_argument("there is no such node");
    }
    system.evaluate(q, VectorXd::Zero(system.velocity_size()), e);
    return system.node_position(e, body, node);
  }
  VectorXd project_positions(VectorXd q) {
    const auto result = solver.project_positions(q);
    if (!result.possible) throw std::runtime_error("the mechanism cannot be assembled");
    return q;
  }
  VectorXd project_velocities(const VectorXd& q, VectorXd v) {
    if (!solver.project_velocities(q, v)) throw std::runtime_error("dependent constraints");
    return v;
  }

  System system;
  Evaluation e;
  ConsistentSolver solver;
};

// One mechanism with its integrator and state.
struct PySimulation {
  explicit PySimulation(const Mechanism& m)
      : mechanism((validate(m.multibody), m)),
        system(mechanism.multibody),
        solver(system),
        integrator(make_integrator(system, mechanism.integrator)),
        state(integrator->make_state()),
        input(system.input_size()) {
    assemble(mechanism.multibody, system, solver, state.q, state.v);
    start();
  }
  void start() {
    if (!integrator->initialize(state, input)) throw std::runtime_error("no consistent accelerations");
  }
  // `steps` equal internal steps up to t_end.
  void run(double t_end, int steps) {
    const double t0 = state.time;
    for (int i = 1; i <= steps; ++i) {
      StepFailure failure;
      if (!integrator->step(state, t0 + (t_end - t0) * i / steps, input, failure)) {
        throw std::runtime_error("step failed at t = " + std::to_string(failure.time));
      }
    }
  }
  // Positions, velocities and multipliers after each of `steps` steps: arrays (steps + 1) x size.
  nb::tuple trajectory(double t_end, int steps) {
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Rows q(steps + 1, state.q.size()), v(steps + 1, state.v.size()), lambda(steps + 1, state.lambda.size());
    VectorXd t(steps + 1);
    const double t0 = state.time;
    for (int i = 0; i <= steps; ++i) {
      if (i > 0) run(t0 + (t_end - t0) * i / steps, 1);
      t[i] = state.time, q.row(i) = state.q, v.row(i) = state.v, lambda.row(i) = state.lambda;
    }
    return nb::make_tuple(t, q, v, lambda);
  }
  void set_input(const VectorXd& u0, const VectorXd& u1, double t0) {
    if (u0.size() != system.input_size() || u1.size() != system.input_size()) {
      throw std::invalid_argument("an input vector has the wrong size");
    }
    input.t0 = t0;
    input.derivative[0] = u0;
    input.derivative[1] = u1;
  }

  Mechanism mechanism;
  System system;
  ConsistentSolver solver;
  std::unique_ptr<Integrator> integrator;
  State state;
  InputSignal input;
};

// A master in C++, given the addresses of an instantiated FMU's fmi2DoStep and component: n communication steps of H,
// without Python in between. With a period > 0 step i starts at i periods of the wall clock, or late if the one before
// took longer. Returns per step when it started after its time and how long it took [s].
using Steps = Eigen::Matrix<double, Eigen::Dynamic, 2>;
Steps do_steps(std::uintptr_t do_step, std::uintptr_t component, double t0, double H, int n, double period) {
  using clock = std::chrono::steady_clock;
  using seconds = std::chrono::duration<double>;
  const auto call = reinterpret_cast<int (*)(void*, double, double, int)>(do_step);
  constexpr seconds kSpin(2e-4);  // sleeping is not exact: the last stretch is waited actively
  Steps result(n, 2);
  const auto start = clock::now();
  for (int i = 0; i < n; ++i) {
    auto due = clock::now();
    if (period > 0) {
      due = start + std::chrono::duration_cast<clock::duration>(seconds(i * period));
      std::this_thread::sleep_until(due - std::chrono::duration_cast<clock::duration>(kSpin));
      while (clock::now() < due) {
      }
    }
    const auto begin = clock::now();
    if (call(reinterpret_cast<void*>(component), t0 + i * H, H, 1) != 0) {
      throw std::runtime_error("fmi2DoStep failed in step " + std::to_string(i));
    }
    result(i, 0) = seconds(begin - due).count();
    result(i, 1) = seconds(clock::now() - begin).count();
  }
  return result;
}

// Sets a parameter by its FMU name, with the FMU's checks.
void set_parameter(Mechanism& mechanism, const std::string& name, double value) {
  for (const Variable& v : make_variables(mechanism, System(mechanism.multibody))) {
    if (v.name != name) continue;
    if (v.causality != Causality::parameter) throw std::invalid_argument(name + " is no parameter");
    const std::string complaint = v.complaint(value);
    if (!complaint.empty()) throw std::invalid_argument(complaint);
    v.set_value(mechanism, value);
    return;
  }
  throw std::invalid_argument(mechanism.name + " has no variable " + name);
}

// The real outputs of a mechanism's FMU as functions of (q, v, u).
struct PyOutputs {
  explicit PyOutputs(const Mechanism& m)
      : mechanism((validate(m.multibody), m)), system(m.multibody), solver(system), e(system.make_evaluation()) {
    state.angle.setZero(system.joint_count());
    for (const Variable& v : make_variables(m, system)) {
      if (v.output && !v.integer) variables.push_back(v);
      if (v.input >= 0) inputs.push_back(v.name);
    }
  }
  VectorXd values(const VectorXd& q, const VectorXd& v, const VectorXd& u) {
    VectorXd vdot(system.velocity_size()), lambda(system.constraint_size());
    if (!solver.accelerations(q, v, u, vdot, lambda)) throw std::runtime_error("dependent constraints");
    system.evaluate(q, v, e);
    const View view{mechanism, system, state, q, v, e, vdot, lambda};
    VectorXd y(static_cast<Eigen::Index>(variables.size()));
    for (std::size_t i = 0; i < variables.size(); ++i) {
      y[static_cast<Eigen::Index>(i)] = variables[i].output(view, variables[i].object, variables[i].component);
    }
    return y;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const Variable& v : variables) result.push_back(v.name);
    return result;
  }

  Mechanism mechanism;
  System system;
  ConsistentSolver solver;
  Evaluation e;
  State state;
  std::vector<Variable> variables;
  std::vector<std::string> inputs;
};

void bind_definitions(nb::module_& m) {
  m.attr("GROUND") = kGround;
  nb::enum_<JointType>(m, "JointType")
      .value("spherical", JointType::spherical)
      .value("revolute", JointType::revolute)
      .value("universal", JointType::universal)
      .value("prismatic", JointType::prismatic)
      .value("fixed", JointType::fixed);
  using Shapes = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
  const auto rows = [](const Shapes& a) -> MatrixXd {  // n x 3 x f -> 3n x f
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    if (a.shape(1) != 3) throw std::invalid_argument("the second dimension of shapes and rotations must be 3");
    return Eigen::Map<const RowMajor>(a.data(), 3 * static_cast<Eigen::Index>(a.shape(0)),
                                      static_cast<Eigen::Index>(a.shape(2)));
  };
  nb::class_<ModalDef>(m, "Modal", "Nodes and modes that make a body flexible.")
      .def(nb::init<>())
      .def_rw("nodes", &ModalDef::nodes)
      .def_rw("masses", &ModalDef::masses)
      .def_rw("mass_matrix", &ModalDef::mass_matrix)
      .def(
          "set_shapes", [rows](ModalDef& d, const Shapes& a) { d.shapes = rows(a); }, "shapes"_a, "Phi, n x 3 x f")
      .def(
          "set_rotations", [rows](ModalDef& d, const Shapes& a) { d.rotations = rows(a); }, "rotations"_a,
          "Psi, n x 3 x f")
      .def_rw("shapes", &ModalDef::shapes, "3n x f")
      .def_rw("rotations", &ModalDef::rotations, "3n x f")
      .def_rw("stiffness", &ModalDef::stiffness)
      .def_rw("damping", &ModalDef::damping)
      .def_rw("mass_damping", &ModalDef::mass_damping)
      .def_rw("stiffness_damping", &ModalDef::stiffness_damping)
      .def_rw("initial_coordinates", &ModalDef::initial_coordinates)
      .def_rw("initial_rates", &ModalDef::initial_rates);
  nb::class_<RigidBodyDef>(m, "RigidBody")
      .def(nb::init<>())
      .def_rw("name", &RigidBodyDef::name)
      .def_rw("modal", &RigidBodyDef::modal, nb::for_setter(nb::arg("modal").none()))
      .def_rw("mass", &RigidBodyDef::mass)
      .def_rw("inertia", &RigidBodyDef::inertia)
      .def_rw("inertia_products", &RigidBodyDef::inertia_products)
      .def_rw("initial_position", &RigidBodyDef::initial_position)
      .def_rw("initial_quaternion", &RigidBodyDef::initial_quaternion)
      .def_rw("initial_velocity", &RigidBodyDef::initial_velocity)
      .def_rw("initial_angular_velocity", &RigidBodyDef::initial_angular_velocity);
  nb::class_<Frame>(m, "Frame")
      .def(
          "__init__",
          [](Frame* f, const Vector3d& origin, const Matrix3d& axes, int node) { new (f) Frame{origin, axes, node}; },
          "origin"_a, "axes"_a, "node"_a = kFloatingFrame)
      .def_rw("node", &Frame::node)
      .def_rw("origin", &Frame::origin)
      .def_rw("axes", &Frame::axes);
  nb::class_<JointDef>(m, "Joint")
      .def(
          "__init__",
          [](JointDef* j, std::string name, JointType type, int body1, const Frame& frame1, int body2,
             const Frame& frame2) { new (j) JointDef{std::move(name), type, body1, frame1, body2, frame2}; },
          "name"_a, "type"_a, "body1"_a, "frame1"_a, "body2"_a, "frame2"_a)
      .def_rw("name", &JointDef::name)
      .def_rw("type", &JointDef::type)
      .def_ro("body1", &JointDef::body1)
      .def_ro("frame1", &JointDef::frame1)
      .def_ro("body2", &JointDef::body2)
      .def_ro("frame2", &JointDef::frame2);
  nb::class_<SpringDamperDef>(m, "SpringDamper")
      .def(
          "__init__",
          [](SpringDamperDef* s, std::string name, int body1, const Vector3d& point1, int body2, const Vector3d& point2,
             const Vector3d& stiffness, const Vector3d& damping, int node1, int node2) {
            new (s) SpringDamperDef{std::move(name), body1, point1, body2, point2, stiffness, damping, node1, node2};
          },
          "name"_a, "body1"_a, "point1"_a, "body2"_a, "point2"_a, "stiffness"_a, "damping"_a,
          "node1"_a = kFloatingFrame, "node2"_a = kFloatingFrame)
      .def_rw("stiffness", &SpringDamperDef::stiffness)
      .def_rw("damping", &SpringDamperDef::damping);
  nb::class_<LoadDef>(m, "Load").def(
      "__init__",
      [](LoadDef* l, std::string name, int body, const Vector3d& force, const Vector3d& torque) {
        new (l) LoadDef{std::move(name), "", body, force, torque};
      },
      "name"_a, "body"_a, "force"_a, "torque"_a);
  nb::class_<MultibodyDef>(m, "Multibody")
      .def(nb::init<>())
      .def_rw("gravity", &MultibodyDef::gravity)
      .def_ro("bodies", &MultibodyDef::bodies)
      .def_ro("joints", &MultibodyDef::joints)
      .def(
          "body", [](MultibodyDef& d, int i) -> RigidBodyDef& { return d.bodies.at(i); },
          nb::rv_policy::reference_internal, "index"_a, "The body itself, to be changed in place.")
      .def("add", nb::overload_cast<RigidBodyDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<JointDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<SpringDamperDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<LoadDef>(&MultibodyDef::add))
      .def("validate", [](const MultibodyDef& d) { validate(d); });
  nb::class_<IntegratorSettings>(m, "IntegratorSettings")
      .def_rw("step_size", &IntegratorSettings::step_size)
      .def_rw("spectral_radius", &IntegratorSettings::spectral_radius)
      .def_rw("sigma", &IntegratorSettings::sigma)
      .def_rw("absolute_tolerance", &IntegratorSettings::absolute_tolerance)
      .def_rw("relative_tolerance", &IntegratorSettings::relative_tolerance)
      .def_rw("max_newton_iterations", &IntegratorSettings::max_newton_iterations)
      .def_rw("max_halvings", &IntegratorSettings::max_halvings)
      .def_rw("method", &IntegratorSettings::method)
      .def_rw("group", &IntegratorSettings::group)
      .def_rw("local_coordinates", &IntegratorSettings::local_coordinates)
      .def_rw("absolute_coordinates", &IntegratorSettings::absolute_coordinates)
      .def_rw("formulation", &IntegratorSettings::formulation)
      .def_rw("corrector", &IntegratorSettings::corrector)
      .def_rw("jacobian", &IntegratorSettings::jacobian)
      .def_rw("newton", &IntegratorSettings::newton)
      .def_rw("sigma_mode", &IntegratorSettings::sigma_mode)
      .def_rw("predictor", &IntegratorSettings::predictor,
              "vdot and lambda that the iterations of the residual form start from: 1 those of the last step "
              "(previous), 2 zero as in Alg. 1, 3 extrapolated linearly from the last two steps. Results agree to "
              "Newton's tolerance; only the number of iterations changes. The incremental form starts from zero.");
  nb::class_<Mechanism>(m, "Mechanism")
      .def(nb::init<>())
      .def_rw("name", &Mechanism::name)
      .def_rw("description", &Mechanism::description)
      .def_rw("multibody", &Mechanism::multibody)
      .def_rw("integrator", &Mechanism::integrator)
      .def_rw("stop_time", &Mechanism::stop_time)
      .def("set", &set_parameter, "name"_a, "value"_a, "Set a parameter by the name it has in the FMU.");
  m.def("axes_with_z", &axes_with_z, "z"_a);
  m.def(
      "assemble",
      [](const MultibodyDef& d) {
        const System system((validate(d), d));
        ConsistentSolver solver(system);
        VectorXd q(system.position_size()), v(system.velocity_size());
        assemble(d, system, solver, q, v);
        return nb::make_tuple(q, v);
      },
      "multibody"_a, "(q, v) of the initial values, moved onto the constraints.");
  m.def("mechanisms", [] {
    std::vector<std::string> names;
    for (const Mechanism& mechanism : mechanisms()) names.push_back(mechanism.name);
    return names;
  });
  m.def(
      "mechanism",
      [](const std::string& name) {
        for (Mechanism& mechanism : mechanisms()) {
          if (mechanism.name != name) continue;
          const auto package = nb::cast<std::string>(nb::str(nb::module_::import_("sigmafmu").attr("__path__")[0]));
          load_modal_files(mechanism, package + "/resources/" + name);
          return mechanism;
        }
        throw std::invalid_argument("unknown mechanism " + name);
      },
      "name"_a, "A fresh copy of a mechanism from models/, with the modal data of the package.");
}

}  // namespace

void bind_lie_groups(nb::module_& lie);  // lie.cpp

NB_MODULE(_core, m) {
  m.doc() = "Core of sigmafmu: Lie group functions, equations of motion, integrator.";
  nb::set_leak_warnings(false);
  auto so3 = m.def_submodule("lie", "SO(3) and R^3 x SO(3).");
  bind_lie(so3);
  bind_lie_groups(so3);
  bind_definitions(m);

  m.def("do_steps", &do_steps, nb::call_guard<nb::gil_scoped_release>(), "do_step"_a, "component"_a, "t0"_a, "H"_a,
        "n"_a, "period"_a = 0.0, "(n, 2): delay of the start and duration [s] of every fmi2DoStep.");
  nb::class_<AlphaParameters>(m, "AlphaParameters")
      .def(nb::init<double>(), "spectral_radius"_a)
      .def_ro("alpha_m", &AlphaParameters::alpha_m)
      .def_ro("alpha_f", &AlphaParameters::alpha_f)
      .def_ro("beta", &AlphaParameters::beta)
      .def_ro("gamma", &AlphaParameters::gamma);

  m.def(
      "spin_sigma",
      [](const MultibodyDef& d, const IntegratorSettings& settings, int body, const Vector3d& w, const Vector3d& wdot,
         double h) {
        const System system((validate(d), d));
        if (body < 0 || body >= system.body_count()) throw std::invalid_argument("there is no such body");
        return SpinSigma(system, settings)(body, w, wdot, h);
      },
      "multibody"_a, "settings"_a, "body"_a, "w"_a, "wdot"_a, "h"_a,
      "sigma that sigma_mode 2 (spinOptimal) gives a body for a step of h [s] that starts with angular velocity w "
      "[rad/s] and its derivative wdot [rad/s2], both in body axes.");

  nb::class_<PySystem>(m, "System", "Equations of motion of a Multibody, as dense arrays.")
      .def(nb::init<const MultibodyDef&>())
      .def_prop_ro("position_size", [](const PySystem& s) { return s.system.position_size(); })
      .def_prop_ro("velocity_size", [](const PySystem& s) { return s.system.velocity_size(); })
      .def_prop_ro("constraint_size", [](const PySystem& s) { return s.system.constraint_size(); })
      .def_prop_ro("input_size", [](const PySystem& s) { return s.system.input_size(); })
      .def("motor_index", [](const PySystem& s, int joint) { return s.system.motor_index(joint); })
      .def("actuator_index", [](const PySystem& s, int spring) { return s.system.actuator_index(spring); })
      .def("residual", &PySystem::residual, "q"_a, "v"_a, "vdot"_a, "lambda_"_a, "u"_a)
      .def("constraints", &PySystem::constraints, "q"_a, "v"_a, "(Phi, Phi', B, Z)")
      .def("linearization", &PySystem::linearization, "q"_a, "v"_a, "lambda_"_a, "u"_a, "vdot"_a = nb::none(),
           "(M, C, K); with flexible bodies K depends on vdot as well.")
      .def_prop_ro("modal_count", [](const PySystem& s) { return s.system.modal_count(); })
      .def(
          "modal_index", [](const PySystem& s, int body) { return s.system.modal_index(body); }, "body"_a,
          "Where a body's modal coordinates start among those of all bodies, the tails of q and v; -1: rigid.")
      .def(
          "modes", [](const PySystem& s, int body) { return s.system.modes(body); }, "body"_a)
      .def("node_position", &PySystem::node_position, "q"_a, "body"_a, "node"_a, "In W.")
      .def("accelerations", &PySystem::accelerations, "q"_a, "v"_a, "u"_a, "(vdot, lambda) of the index-1 form")
      .def("jerk", &PySystem::jerk, "q"_a, "v"_a, "u"_a, "d(vdot)/dt along the motion, at constant u")
      .def("energy", &PySystem::energy, "q"_a, "v"_a)
      .def("coordinate", &PySystem::coordinate, "q"_a, "v"_a, "joint"_a)
      .def("reaction", &PySystem::reaction, "q"_a, "v"_a, "lambda_"_a, "joint"_a, "(force, torque) on body 2, in W")
      .def("compose", &PySystem::compose, "q"_a, "theta"_a)
      .def("project_positions", &PySystem::project_positions, "q"_a)
      .def("project_velocities", &PySystem::project_velocities, "q"_a, "v"_a);

  nb::class_<PyOutputs>(m, "Outputs",
                        "Real outputs of a mechanism's FMU as functions of (q, v, u); angles without turns.")
      .def(nb::init<const Mechanism&>())
      .def_prop_ro("names", &PyOutputs::names)
      .def_ro("inputs", &PyOutputs::inputs, "Names of the entries of u.")
      .def("values", &PyOutputs::values, "q"_a, "v"_a, "u"_a);
  nb::class_<StepCounters>(m, "StepCounters")
      .def_ro("steps", &StepCounters::steps)
      .def_ro("newton_iterations", &StepCounters::newton_iterations)
      .def_ro("jacobian_evaluations", &StepCounters::jacobian_evaluations)
      .def_ro("retries", &StepCounters::retries);
  nb::class_<State>(m, "State", "Plain value; copy it to save, assign it to restore.")
      .def("__copy__", [](const State& s) { return State(s); })
      .def_rw("time", &State::time)
      .def_rw("q", &State::q)
      .def_rw("v", &State::v)
      .def_rw("vdot", &State::vdot)
      .def_rw("a", &State::a)
      .def_rw("lambda_", &State::lambda)
      .def_ro("angle", &State::angle)
      .def_ro("counters", &State::counters);
  nb::class_<PySimulation>(m, "Simulation", "A mechanism, assembled at its initial values, and its integrator.")
      .def(nb::init<const Mechanism&>())
      .def_rw("state", &PySimulation::state)
      .def("start", &PySimulation::start, "Consistent accelerations at the present q, v.")
      .def("run", &PySimulation::run, "t_end"_a, "steps"_a)
      .def("trajectory", &PySimulation::trajectory, "t_end"_a, "steps"_a, "(t, q, v, lambda)")
      .def("set_input", &PySimulation::set_input, "u0"_a, "u1"_a, "t0"_a);
}
