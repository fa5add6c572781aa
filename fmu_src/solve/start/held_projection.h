// Moves a mechanism onto its joints while the initial values that were set (MultibodyDef::held) stay as they are.
//
// What was not set gives way: positions first, then orientations, then modes; velocities likewise. Each changes least
// in the mass metric. Coordinates of joints that were not set keep their value as far as the mechanism allows, in the
// order of the joints.
//
// Dense and with rank-revealing decompositions, since values may be set that say the same twice: for the start alone.
// Where coordinates of joints leave nothing open the sparse solver comes first, whatever the number of bodies.
#pragma once

#include <memory>
#include <vector>

#include "solve/start/determined_motion.h"

namespace sigmafmu {

class HeldProjection {
 public:
  HeldProjection(const MultibodyDef& definition, const System& system);

  // From a q that may violate what is held, on the way of small steps. Throws std::runtime_error with one sentence that
  // names what contradicts what, and by how much.
  void positions(VectorXd& q);
  // The same for velocities at q; those of the definition's start at q0.
  void velocities(const VectorXd& q0, const VectorXd& q, VectorXd& v);

 private:
  // A joint coordinate or its rate that equations ask for.
  struct Coordinate {
    int index;  // among those of all joints
    double from, to;
  };
  using Coordinates = std::vector<Coordinate>;
  // What gives way first: translations of bodies, rotations, modes.
  static constexpr int kLevels = 3;

  bool holds(InitialValue::Kind kind, int object, int component = 0) const;
  Coordinates held_coordinates(InitialValue::Kind kind) const;
  std::vector<int> free_coordinates(InitialValue::Kind kind) const;
  std::vector<int> columns(const InitialValue& what) const;
  void fix(bool motion);
  void impose(const VectorXd& q0, double s, VectorXd& q) const;
  void impose(VectorXd& v) const;
  int steps(const VectorXd& q0, const Coordinates& coordinates) const;
  bool follow(const VectorXd& q0, const Coordinates& coordinates, bool condition, VectorXd& q);
  template <typename Solve>
  bool grant(const Coordinates& held, const Coordinates& wishes, VectorXd& x, Solve solve);
  void count_turns();
  bool axes_agree() const;
  DeterminedMotion* determined(const Coordinates& coordinates);
  bool reach(const Coordinates& coordinates, double s, VectorXd& q);
  bool close(const Coordinates& coordinates, double s, int most_iterations, VectorXd& q);
  void approach(const Coordinates& coordinates, VectorXd& q);
  bool adjust(const VectorXd& q, const Coordinates& rates, VectorXd& v);
  VectorXd gaps(const VectorXd& q, const Coordinates& coordinates, double s);
  VectorXd gaps_of_rates(const VectorXd& q, const VectorXd& v, const Inputs& u, const Coordinates& rates);
  double coordinate(int c) const { return system_.coordinate_value(e_, c); }
  double coordinate_rate(int c) const { return system_.coordinate_rate(e_, c); }
  void linearize(const VectorXd& q, const Coordinates& coordinates, bool motion);
  VectorXd lengths_of_units(const Coordinates& coordinates) const;
  VectorXd least_motion(const VectorXd& gaps) const;
  VectorXd moved(const VectorXd& q, const VectorXd& x) const;
  [[noreturn]] void refuse(const VectorXd& gaps, const Coordinates& coordinates, bool motion) const;

  const MultibodyDef& definition_;
  const System& system_;
  Inputs u_, rest_;  // at the start, and with drives at rest
  VectorXd turned_at_start_;
  Evaluation e_;
  std::vector<int> free_[kLevels];                // velocities that may change, or whose positions may
  MatrixXd A_, M_;                                // equations (joints, then coordinates) by velocities; mass
  std::unique_ptr<DeterminedMotion> determined_;  // of the coordinates that were asked for last
};

}  // namespace sigmafmu
