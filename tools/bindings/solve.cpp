// Elimination of blocks in sigmafmu._core.
#include <nanobind/eigen/dense.h>
#include <nanobind/eigen/sparse.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "solve/newton_matrix.h"
#include "solve/start/dependent_equations.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace sigmafmu;

namespace {

nb::tuple eliminate(const std::vector<int>& sizes, const std::vector<std::pair<int, int>>& blocks,
                    const std::vector<std::vector<int>>& after) {
  BlockGraph graph(sizes);
  graph.connect(blocks);
  graph.after = after;
  const std::vector<int> order = elimination_order(graph);
  const auto pattern = factor_pattern(graph, order);
  return nb::make_tuple(order, pattern, factorization_cost(sizes, pattern));
}

// The matrix may have no entries where the solver has no block.
VectorXd solve(const BlockLU& lu, const MatrixXd& A, VectorXd b) {
  if (A.rows() != lu.size() || A.cols() != lu.size() || b.size() != lu.size()) {
    throw std::invalid_argument("A or b has the wrong size");
  }
  const auto rows = [&](int node) {
    return (node + 1 < lu.nodes() ? lu.offset(node + 1) : lu.size()) - lu.offset(node);
  };
  Factorization f = lu.make_factorization();
  for (int i = 0; i < lu.nodes(); ++i) {
    for (int j = 0; j < lu.nodes(); ++j) {
      const auto part = A.block(lu.offset(i), lu.offset(j), rows(i), rows(j));
      if (lu.handle(i, j) >= 0) {
        lu.block(f, i, j) = part;
      } else if ((part.array() != 0).any()) {
        throw std::invalid_argument("A has entries outside the pattern");
      }
    }
  }
  if (!lu.factorize(f)) throw std::runtime_error("singular");
  lu.solve(f, b.data());
  return b;
}

// A step's time in the linear solver: (x, seconds of a factorization, seconds of a solution), the fastest of many. As a
// step would, each factorization starts from a copy of A.
nb::tuple timed(const BlockLU& lu, const Eigen::SparseMatrix<double>& A, const VectorXd& b, int repeats) {
  if (A.rows() != lu.size() || A.cols() != lu.size() || b.size() != lu.size() || repeats < 1) {
    throw std::invalid_argument("A or b has the wrong size, or repeats is below 1");
  }
  std::vector<int> node_of(lu.size());
  for (int node = 0, row = 0; row < lu.size(); ++row) {
    while (node + 1 < lu.nodes() && lu.offset(node + 1) <= row) ++node;
    node_of[row] = node;
  }
  Factorization start = lu.make_factorization();
  std::fill(start.values.begin(), start.values.end(), 0.0);
  for (int column = 0; column < A.outerSize(); ++column) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(A, column); entry; ++entry) {
      const int i = node_of[entry.row()], j = node_of[column];
      if (lu.handle(i, j) < 0) throw std::invalid_argument("A has entries outside the pattern");
      lu.block(start, i, j)(entry.row() - lu.offset(i), column - lu.offset(j)) = entry.value();
    }
  }
  using Clock = std::chrono::steady_clock;
  const auto seconds = [](Clock::duration d) { return std::chrono::duration<double>(d).count(); };
  Factorization f = start;
  VectorXd x = b;
  double factorizing = INFINITY, solving = INFINITY;
  for (int k = 0; k < repeats; ++k) {
    const Clock::time_point t0 = Clock::now();
    f.values = start.values;
    if (!lu.factorize(f)) throw std::runtime_error("singular");
    const Clock::time_point t1 = Clock::now();
    x = b;
    lu.solve(f, x.data());
    factorizing = std::min(factorizing, seconds(t1 - t0));
    solving = std::min(solving, seconds(Clock::now() - t1));
  }
  return nb::make_tuple(x, factorizing, solving);
}

// An iteration of Newton's method with tangents U, P^-1, E, F of each body, whatever they are.
struct NewtonIteration {
  NewtonIteration(const MultibodyDef& d, int formulation)
      : system((validate(d), d), find_compliance(d)),
        matrix(system, static_cast<Formulation>(formulation)),
        u(inputs(d, system)),
        at(system.make_evaluation()),
        start(at),
        tangents(system.body_count()) {}

  static Inputs inputs(const MultibodyDef& d, const System& system) {
    if (!d.drives.empty()) throw std::invalid_argument("drives are left out here");
    return system.make_inputs();
  }
  void check(const VectorXd& q, const VectorXd& v) const {
    if (q.size() != system.position_size() || v.size() != system.velocity_size()) {
      throw std::invalid_argument("q or v has the wrong size");
    }
  }
  void set_tangents(const std::vector<MatrixXd>& U, const std::vector<MatrixXd>& P_inverse,
                    const std::vector<MatrixXd>& E, const std::vector<MatrixXd>& F, bool rotations_only) {
    for (std::size_t i = 0; i < tangents.U.size(); ++i) {
      tangents.U[i] = U.at(i);
      tangents.P_inverse[i] = P_inverse.at(i);
      tangents.E[i] = E.at(i);
      tangents.F[i] = F.at(i);
    }
    tangents.rotations_only = rotations_only;
  }
  // (motion, what lambda and mu become)
  std::tuple<VectorXd, VectorXd, VectorXd> solve(const VectorXd& q_n, const VectorXd& q, const VectorXd& v,
                                                 const VectorXd& vdot, VectorXd lambda, VectorXd mu, double gamma_prime,
                                                 double beta_prime, double scale) {
    check(q_n, v);
    check(q, vdot);
    if (lambda.size() != system.constraint_size() || mu.size() != system.constraint_size()) {
      throw std::invalid_argument("lambda or mu has the wrong size");
    }
    const StepScales scales{gamma_prime, beta_prime, scale};
    VectorXd r(system.velocity_size()), x(matrix.size());
    system.evaluate(q_n, v, u, start);
    system.clear_velocity_rows(start);
    system.evaluate(q, v, u, at);
    system.constraint_rates(u, at);
    system.residual(at, vdot, lambda, u, r);
    system.linearize(vdot, lambda, u, at);
    Factorization f = matrix.make_factorization();
    if (!matrix.factorize(at, start, scales, tangents, f)) throw std::runtime_error("singular");
    matrix.right_side(at, r, scales, x);
    if (matrix.soft()) matrix.add_compliance(lambda, mu, scales, x);
    matrix.solve(f, x);
    matrix.add_multipliers(x, scales, lambda, mu);
    return {x.head(system.velocity_size()), lambda, mu};
  }

  System system;
  NewtonMatrix matrix;
  Inputs u;
  Evaluation at, start;
  BodyTangents tangents;
};

}  // namespace

void bind_solve(nb::module_& m) {
  m.def("eliminate", &eliminate, "sizes"_a, "blocks"_a, "after"_a,
        "(order, neighbours of each node at its turn, multiplications) for a symmetric matrix of blocks.");
  nb::enum_<Kkt>(m, "Kkt")
      .value("index1", Kkt::index1)
      .value("newton", Kkt::newton)
      .value("stabilized", Kkt::stabilized);
  nb::class_<BlockLU>(m, "KktSolver", "Solves the linear equations of a Multibody.")
      .def(
          "__init__",
          [](BlockLU* lu, const MultibodyDef& d, Kkt form) {
            new (lu) BlockLU(*KktPlans().get(System((validate(d), d)).pattern(), form));
          },
          "multibody"_a, "form"_a)
      .def_prop_ro("cost", &BlockLU::cost, "Multiplications of a factorization.")
      .def_prop_ro("values", [](const BlockLU& lu) { return lu.make_factorization().values.size(); })
      .def("offset", &BlockLU::offset, "node"_a)
      .def("solve", &solve, "A"_a, "b"_a)
      .def("timed", &timed, "A"_a, "b"_a, "repeats"_a,
           "(x, seconds of a factorization, seconds of a solution), the fastest of so many; A sparse.");
  nb::class_<NewtonIteration>(m, "NewtonIteration", "The linear equations of newton_matrix.h, at any point.")
      .def(nb::init<const MultibodyDef&, int>(), "multibody"_a, "formulation"_a)
      .def("set_tangents", &NewtonIteration::set_tangents, "U"_a, "P_inverse"_a, "E"_a, "F"_a, "rotations_only"_a,
           "Lists of a 6x6 matrix for each body, E and F 3x6.")
      .def("solve", &NewtonIteration::solve, "q_n"_a, "q"_a, "v"_a, "vdot"_a, "lambda_"_a, "mu"_a, "gamma_prime"_a,
           "beta_prime"_a, "scale"_a, "(motion, lambda and mu after it)");
}
