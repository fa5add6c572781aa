// The equations of motion of sigmafmu._core.
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <optional>
#include <stdexcept>

#include "lie/r3xso3.h"
#include "multibody/dense_blocks.h"
#include "multibody/system.h"
#include "solve/index1.h"
#include "solve/start/assembly.h"
#include "solve/start/dependent_equations.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace sigmafmu;

namespace {

// Entries of blocks, for systems that are too large for dense matrices; zeros inside of blocks stay.
struct Entries {
  std::vector<int> rows, columns;
  std::vector<double> values;

  template <typename Block>
  void add(int row, int column, const Block& block) {
    for (int r = 0; r < block.rows(); ++r) {
      for (int c = 0; c < block.cols(); ++c) {
        rows.push_back(row + r);
        columns.push_back(column + c);
        values.push_back(block(r, c));
      }
    }
  }
  nb::tuple tuple() const { return nb::make_tuple(values, nb::make_tuple(rows, columns)); }
};

nb::tuple entries_of_pairs(const System& system, const VectorXd& values) {
  const BlockPattern& pattern = system.pattern();
  Entries entries;
  for (const auto& pair : pattern.pairs) {
    if (pair.offset >= values.size()) break;  // M has only the first ones
    entries.add(pattern.unknowns[pair.row].velocity, pattern.unknowns[pair.column].velocity,
                pair_block(pattern, pair, values));
  }
  return entries.tuple();
}

nb::tuple entries_of_rows(const System& system, const VectorXd& values) {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const BlockPattern& pattern = system.pattern();
  Entries entries;
  for (const auto& [constraint, unknown, offset] : pattern.incidences) {
    entries.add(system.lambda_index(constraint), pattern.unknowns[unknown].velocity,
                Eigen::Map<const Rows>(values.data() + offset, pattern.constraint_sizes[constraint],
                                       pattern.unknowns[unknown].size));
  }
  return entries.tuple();
}

// Dense views of one evaluation, for checking every derivative against differences.
struct PySystem {
  explicit PySystem(const MultibodyDef& d)
      : definition((validate(d), d)),
        system(d, find_compliance(d)),
        start(inputs_at_start(d, system)),
        e(system.make_evaluation()),
        solver(system) {}

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
    system.evaluate(q, v, inputs(u), e);
    system.residual(e, vdot, lambda, inputs(u), r);
    return r;
  }
  nb::tuple constraints(const VectorXd& q, const VectorXd& v) {
    check(q, v);
    system.evaluate(q, v, start, e);
    system.constraint_rates(start, e);
    return nb::make_tuple(e.phi, e.phidot, dense_rows(system, e.B), dense_rows(system, e.Z));
  }
  VectorXd explicit_rate(const VectorXd& q, const VectorXd& v) {
    constraints(q, v);
    return e.W;
  }
  nb::tuple linearization(const VectorXd& q, const VectorXd& v, const VectorXd& lambda, const VectorXd& u,
                          const std::optional<VectorXd>& vdot) {
    check(q, v);
    check_forces(lambda, u);
    system.evaluate(q, v, start, e);
    if (vdot) check(q, *vdot);
    if (!vdot && system.flexible_count() > 0) {
      throw std::invalid_argument("the linearization of flexible bodies needs vdot");
    }
    system.linearize(vdot ? *vdot : VectorXd::Zero(system.velocity_size()), lambda, inputs(u), e);
    return nb::make_tuple(dense_pairs(system, e.M), dense_pairs(system, e.C), dense_pairs(system, e.K));
  }
  // Of rigid bodies.
  nb::tuple entries(const VectorXd& q, const VectorXd& v, const VectorXd& lambda) {
    check(q, v);
    check_forces(lambda, start.u);
    system.evaluate(q, v, start, e);
    system.constraint_rates(start, e);
    system.linearize(VectorXd::Zero(system.velocity_size()), lambda, start, e);
    return nb::make_tuple(entries_of_pairs(system, e.M), entries_of_pairs(system, e.C), entries_of_pairs(system, e.K),
                          entries_of_rows(system, e.B), entries_of_rows(system, e.Z));
  }
  nb::tuple accelerations(const VectorXd& q, const VectorXd& v, const VectorXd& u) {
    check(q, v);
    VectorXd vdot(system.velocity_size()), lambda(system.constraint_size());
    check_forces(lambda, u);
    if (!solver.accelerations(q, v, inputs(u), vdot, lambda)) fail(q);
    return nb::make_tuple(vdot, lambda);
  }
  VectorXd jerk(const VectorXd& q, const VectorXd& v, const VectorXd& u) {
    const VectorXd vdot = nb::cast<VectorXd>(accelerations(q, v, u)[0]);
    InputSignal input = system.make_signal();
    start_prescribed(definition, system, input);
    input.derivative[0] = u;
    VectorXd vddot(system.velocity_size());
    if (!solver.jerk(q, v, vdot, input, start.turned, 0.0, vddot)) fail(q);
    return vddot;
  }
  double energy(const VectorXd& q, const VectorXd& v) {
    check(q, v);
    system.evaluate(q, v, start, e);
    return system.kinetic_energy(e) + system.potential_energy(e, start);
  }
  nb::tuple coordinate(const VectorXd& q, const VectorXd& v, int joint, int k) {
    check(q, v);
    system.evaluate(q, v, start, e);
    const int c = coordinate_of(joint, k);
    if (c < 0) return nb::make_tuple(NAN, NAN);
    return nb::make_tuple(system.coordinate_value(e, c), system.coordinate_rate(e, c));
  }
  double coordinate_acceleration(const VectorXd& q, const VectorXd& v, const VectorXd& vdot, int joint, int k) {
    check(q, v);
    check(q, vdot);
    system.evaluate(q, v, start, e);
    const int c = coordinate_of(joint, k);
    return c < 0 ? NAN : system.coordinate_acceleration(e, c, vdot);
  }
  nb::tuple coordinates(const VectorXd& q, const VectorXd& v) {
    check(q, v);
    system.evaluate(q, v, start, e);
    VectorXd x = VectorXd::Zero(system.coordinate_count()), rate = x;
    for (int c = 0; c < system.coordinate_count(); ++c) {
      x[c] = system.coordinate_value(e, c);
      rate[c] = system.coordinate_rate(e, c);
    }
    return nb::make_tuple(x, rate);
  }
  // Which of them turn, and the joints they belong to.
  nb::tuple kinds_of_coordinates() const {
    std::vector<bool> turns;
    std::vector<int> joints;
    for (int j = 0; j < system.joint_count(); ++j) {
      for (const JointCoordinate& c : system.joint(j).coordinates()) {
        turns.push_back(c.is_angle());
        joints.push_back(j);
      }
    }
    return nb::make_tuple(turns, joints);
  }
  // Coordinate k of a joint among all, -1: it has none.
  int coordinate_of(int joint, int k) const {
    const auto count = static_cast<int>(system.joint(joint).coordinates().size());
    return k >= 0 && k < count ? system.coordinate_index(joint) + k : -1;
  }
  nb::tuple reaction(const VectorXd& q, const VectorXd& v, const VectorXd& lambda, int joint) {
    check(q, v);
    if (lambda.size() != system.constraint_size()) throw std::invalid_argument("lambda has the wrong size");
    system.evaluate(q, v, start, e);
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
    system.evaluate(q, VectorXd::Zero(system.velocity_size()), start, e);
    return system.node_position(e, body, node);
  }
  VectorXd project_positions(VectorXd q) {
    const auto result = solver.project_positions(start, q);
    if (!result.possible) throw std::runtime_error("the mechanism cannot be assembled");
    return q;
  }
  VectorXd project_velocities(const VectorXd& q, VectorXd v) {
    if (!solver.project_velocities(q, start, v)) throw std::runtime_error(describe_singularity(definition, system, q));
    return v;
  }

  Inputs inputs(const VectorXd& u) const {
    Inputs result = start;
    result.u = u;
    return result;
  }
  [[noreturn]] void fail(const VectorXd& q) const {
    throw std::runtime_error(solver.singular() ? describe_singularity(definition, system, q) : "a value overflows");
  }

  MultibodyDef definition;
  System system;
  Inputs start;  // what drives prescribe
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
      .def_prop_ro("degrees", &Freedom::degrees, "Of velocities.")
      .def_prop_ro("degrees_of_positions", &Freedom::degrees_of_positions)
      .def("__str__", &summary);
  m.def("freedom", &initial_freedom, "multibody"_a, "Degrees of freedom and dependent equations at the start.");
  nb::class_<Inputs>(m, "Inputs")
      .def_rw("x", &Inputs::x, "Prescribed coordinates")
      .def_rw("xdot", &Inputs::xdot)
      .def_rw("xddot", &Inputs::xddot)
      .def_rw("time", &Inputs::time, "Since the start [s].")
      .def_rw("turned", &Inputs::turned, "Coordinates near which angles are counted.");
  nb::class_<PySystem>(m, "System", "Equations of motion of a Multibody, as dense arrays.")
      .def(nb::init<const MultibodyDef&>())
      .def_prop_ro("position_size", [](const PySystem& s) { return s.system.position_size(); })
      .def_prop_ro("velocity_size", [](const PySystem& s) { return s.system.velocity_size(); })
      .def_prop_ro("constraint_size", [](const PySystem& s) { return s.system.constraint_size(); })
      .def_prop_ro(
          "velocity_equations", [](const PySystem& s) { return s.system.velocity_equations(); },
          "Indices of the constraints that are of velocities alone.")
      .def_prop_ro("input_size", [](const PySystem& s) { return s.system.input_size(); })
      .def(
          "motor_index",
          [](const PySystem& s, int joint, int coordinate) {
            const int c = s.coordinate_of(joint, coordinate);
            return c < 0 ? -1 : s.system.motor(c).first_input();
          },
          "joint"_a, "coordinate"_a = 0)
      .def_prop_ro("redundant", [](const PySystem& s) { return s.system.compliance().dependent; })
      .def_prop_ro(
          "compliance",
          [](const PySystem& s) {
            nb::list result;
            for (const auto& [constraint, row, force, motion] : s.system.compliance().equations) {
              result.append(nb::make_tuple(s.system.lambda_index(constraint) + row, force, motion));
            }
            return result;
          },
          "(equation, e, d) of each that has a compliance.")
      .def_prop_ro("drive_count", [](const PySystem& s) { return s.system.drive_count(); })
      .def_rw("start", &PySystem::start, "What drives prescribe.")
      .def("actuator_index",
           [](const PySystem& s, int spring) {
             return s.system.force(static_cast<int>(s.definition.loads.size()) + spring).first_input();
           })
      .def("residual", &PySystem::residual, "q"_a, "v"_a, "vdot"_a, "lambda_"_a, "u"_a)
      .def("constraints", &PySystem::constraints, "q"_a, "v"_a, "(Phi, Phi', B, Z)")
      .def("explicit_rate", &PySystem::explicit_rate, "q"_a, "v"_a, "W = d(Phi')/dt at fixed q and v")
      .def("linearization", &PySystem::linearization, "q"_a, "v"_a, "lambda_"_a, "u"_a, "vdot"_a = nb::none(),
           "(M, C, K); with flexible bodies K depends on vdot as well.")
      .def("entries", &PySystem::entries, "q"_a, "v"_a, "lambda_"_a,
           "(M, C, K, B, Z) of rigid bodies without inputs, each (values, (rows, columns)) as for SciPy's sparse "
           "arrays.")
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
      .def("coordinate", &PySystem::coordinate, "q"_a, "v"_a, "joint"_a, "coordinate"_a = 0,
           "(value, rate); NaN for a joint that has none.")
      .def("coordinate_acceleration", &PySystem::coordinate_acceleration, "q"_a, "v"_a, "vdot"_a, "joint"_a,
           "coordinate"_a = 0)
      .def("coordinates", &PySystem::coordinates, "q"_a, "v"_a,
           "Coordinates of all joints and their rates, joint after joint.")
      .def("kinds_of_coordinates", &PySystem::kinds_of_coordinates, "(whether it is an angle, its joint) for each.")
      .def("reaction", &PySystem::reaction, "q"_a, "v"_a, "lambda_"_a, "joint"_a,
           "(force, torque) on body 2, as the joint's definition wants them.")
      .def("compose", &PySystem::compose, "q"_a, "theta"_a)
      .def("project_positions", &PySystem::project_positions, "q"_a)
      .def("project_velocities", &PySystem::project_velocities, "q"_a, "v"_a);
}
