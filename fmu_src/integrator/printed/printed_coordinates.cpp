#include "integrator/printed/printed_coordinates.h"

#include "integrator/coordinates/tangents_of.h"
#include "lie/lgt.h"

namespace sigmafmu {
namespace {

template <class Group>
class PrintedCoordinatesOf final : public PrintedCoordinates {
  using Part = typename Group::Coupled;
  static constexpr int N = Part::kSize;
  using PartMatrix = PartMatrixOf<Part>;

 public:
  void modify(const StepEquations& e, const VectorXd& V, VectorXd& theta) const override {
    for (int i = 0; i < bodies(e); ++i) {
      part_of<N>(theta, i) -=
          e.sigma[i] / e.scales.gamma_prime * Part::commutator(part_of<N>(V, i), part_of<N>(theta, i));
    }
  }

  void solve_P(const StepEquations& e, const VectorXd& theta, VectorXd& dV) const override {
    for (int i = 0; i < bodies(e); ++i) {
      if (e.sigma[i] == 1.0) continue;
      part_of<N>(dV, i) = (P_inverse<Part>(e.sigma[i], part_of<N>(theta, i)) * part_of<N>(dV, i)).eval();
    }
  }

  void tangents(const StepEquations& e, const VectorXd& q_n, const Iterate& at, BodyTangents& out) const override {
    begin_tangents<Part>(e, out);
    for (int i = 0; i < bodies(e); ++i) {
      PartMatrix P_inv = PartMatrix::Identity();
      if (e.sigma[i] != 1.0) P_inv = P_inverse<Part>(e.sigma[i], part_of<N>(at.theta, i));
      store_tangents<Part>(e.scales, q_n, at, i, P_inv, P_inv, out);
    }
  }

 private:
  static int bodies(const StepEquations& e) { return static_cast<int>(e.sigma.size()); }
};

template <template <class> class Group>
std::unique_ptr<PrintedCoordinates> with_map(const IntegratorSettings& settings) {
  if (settings.is(CoordinateMap::cayley)) return std::make_unique<PrintedCoordinatesOf<Group<lie::Cayley>>>();
  if (settings.is(CoordinateMap::cayley2)) return std::make_unique<PrintedCoordinatesOf<Group<lie::Cayley2>>>();
  return std::make_unique<PrintedCoordinatesOf<Group<lie::Exponential>>>();
}

}  // namespace

std::unique_ptr<PrintedCoordinates> make_printed_coordinates(const IntegratorSettings& settings) {
  return settings.is(LieGroup::se3) ? with_map<lie::SE3>(settings) : with_map<lie::R3xSO3>(settings);
}

}  // namespace sigmafmu
