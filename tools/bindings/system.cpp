// The equations of motion of sigmafmu._core.
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <stdexcept>

#include "lie/r3xso3.h"
#include "multibody/system.h"
#include "solve/index1.h"
#include "solve/start/dependent_equations.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace sigmafmu;

namespace {

// Dense views of one evaluation, for checking every derivative against differences.
struct PySystem {
  explicit PySystem(const MultibodyDef& d)
      : definition((validate(d), d)), system(d), e(system.make_evaluation()), solver(system) {}

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
    if (!solver.accelerations(q, v, u, vdot, lambda)) fail(q);
    return nb::make_tuple(vdot, lambda);
  }
  VectorXd jerk(const VectorXd& q, const VectorXd& v, const VectorXd& u) {
    const VectorXd vdot = nb::cast<VectorXd>(accelerations(q, v, u)[0]);
    InputSignal input(system.input_size());
    input.derivative[0] = u;
    VectorXd vddot(system.velocity_size());
    if (!solver.jerk(q, v, vdot, input, 0.0, vddot)) fail(q);
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
  nb::tuple coordinates(const VectorXd& q, const VectorXd& v) {
    check(q, v);
    system.evaluate(q, v, e);
    VectorXd x = VectorXd::Zero(system.joint_count()), rate = x;
    for (int j = 0; j < system.joint_count(); ++j) {
      const Joint& joint = system.joint(j);
      if (!joint.has_motor()) continue;
      const auto &k1 = system.attachment(e, j, 0), &k2 = system.attachment(e, j, 1);
      x[j] = joint.coordinate(k1, k2);
      rate[j] = joint.coordinate_rate(k1, k2);
    }
    return nb::make_tuple(x, rate);
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
    if (!solver.project_velocities(q, v)) throw std::runtime_error(describe_singularity(definition, system, q));
    return v;
  }

  [[noreturn]] void fail(const VectorXd& q) const {
    throw std::runtime_error(solver.singular() ? describe_singularity(definition, system, q) : "a value overflows");
  }

  MultibodyDef definition;
  System system;
  Evaluation e;
  ConsistentSolver solver;
};

}  // namespace

void bind_system(nb::module_& m) {
  nb::class_<Freedom::Group>(m, "DependentGroup", "Joints whose equations depend on each other.")
      .def_ro("joints", &Freedom::Group::joints, "Their indices.")
      .def_ro("equations", &Freedom::Group::equations, "How many these joints have,")
      .def_ro("dependent", &Freedom::Group::dependent, "and how many of them follow from the others.");
  nb::class_<Freedom>(m, "Freedom", "The joints' equations at a position.")
      .def_ro("velocities", &Freedom::velocities)
      .def_ro("equations", &Freedom::equations)
      .def_ro("independent", &Freedom::independent)
      .def_ro("groups", &Freedom::groups)
      .def_ro("margin", &Freedom::margin, "Smallest part of an equation that is perpendicular to those before it.")
      .def_prop_ro("degrees", &Freedom::degrees)
      .def("__str__", &summary);
  m.def("freedom", &initial_freedom, "multibody"_a, "Degrees of freedom and dependent equations at the start.");
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
      .def(
          "freedom",
          [](const PySystem& s, const VectorXd& q) {
            s.check(q, VectorXd::Zero(s.system.velocity_size()));
            return freedom(s.system, q);
          },
          "q"_a)
      .def("accelerations", &PySystem::accelerations, "q"_a, "v"_a, "u"_a, "(vdot, lambda) of the index-1 form")
      .def("jerk", &PySystem::jerk, "q"_a, "v"_a, "u"_a, "d(vdot)/dt along the motion, at constant u")
      .def("energy", &PySystem::energy, "q"_a, "v"_a)
      .def("coordinate", &PySystem::coordinate, "q"_a, "v"_a, "joint"_a)
      .def("coordinates", &PySystem::coordinates, "q"_a, "v"_a,
           "Coordinates of all joints and their rates; zero for joints that have none.")
      .def("reaction", &PySystem::reaction, "q"_a, "v"_a, "lambda_"_a, "joint"_a, "(force, torque) on body 2, in W")
      .def("compose", &PySystem::compose, "q"_a, "theta"_a)
      .def("project_positions", &PySystem::project_positions, "q"_a)
      .def("project_velocities", &PySystem::project_velocities, "q"_a, "v"_a);
}
