// The iteration matrix of one Newton step of an implicit method, scaled so that its condition does not grow as h -> 0
// (Bottasso, Dopico, Trainelli 2008). Unknowns: motion increments Delta q of the bodies (translation in W, rotation in
// body axes), Delta lambda times `scale` and, for the stabilized index-2 form, Delta mu. With
//
//   gamma' U_i = dv/d(motion),   beta' (U_i + E_i) = dvdot/d(motion),
//   gamma' P_i^-1 = dv/d(B_n^T mu),   beta' (P_i^-1 + F_i) = dvdot/d(B_n^T mu)
//
// of the mixed velocities, kappa = scale beta', D P^-1 = kappa M (P^-1 + F) + scale gamma' C P^-1:
//
//   dynamics   [ kappa M (U + E) + scale gamma' C U + scale K     B^T   D P^-1 B_n^T ]
//   Phi        [ B                                                 0     0            ]
//   Phi'/gamma'[ Z/gamma' + B U                                    0     B P^-1 B_n^T ]
//
// (U = P = I, E = F = 0 for modal coordinates), which are Eqs. (67) and (D.2), scaled; in the stabilized form the
// second row is subtracted from the third, so that only small terms couple mu to the motion. Index 2 has the third row
// in place of the second.
//
// Equations of velocities alone have the third row in place of the second in every form, and their mu is zero: B_n has
// no rows for them (System::clear_velocity_rows), and what their third row would have in the columns of mu is in the
// second.
//
// Constraints whose equations depend on each other have a compliance (multibody/constraints/compliance.h): -e in the
// second row's column of lambda, d in the third one's of mu, and after the subtraction e in that of lambda.
#pragma once

#include <algorithm>

#include "model/settings.h"
#include "multibody/system.h"
#include "solve/kkt_layout.h"

namespace sigmafmu {

// The step size enters an implicit method by these alone: V and Vdot are affine functions of theta and V.
struct StepScales {
  double gamma_prime;  // dV/dtheta at theta = 0 [1/s]
  double beta_prime;   // dVdot/dV gamma' [1/s2]
  double scale;        // of dynamics and multipliers, about 1/beta' [s2]
};

// What the matrix needs of each body; E and F are translational rows. On R^3 x SO(3) U and P differ from the identity
// in rotations alone, and E = F = 0: then only the lower right 3x3 of U and P^-1 is read.
struct BodyTangents {
  using Rows = Eigen::Matrix<double, 3, 6>;
  std::vector<Matrix6d> U, P_inverse;
  std::vector<Rows> E, F;
  bool rotations_only = false;
  bool identity_P = false;

  explicit BodyTangents(int bodies) : U(bodies, Matrix6d::Identity()), P_inverse(U), E(bodies, Rows::Zero()), F(E) {}
};

class NewtonMatrix {
 public:
  // `least_scale`: of steps in which constraints do not get stiffer, in place of step.scale where that is smaller [s2].
  NewtonMatrix(const System& system, Formulation formulation, KktPlans plans = {}, double least_scale = 0);

  Factorization make_factorization() const { return lu_->make_factorization(); }
  // `e` holds C, K, B, Z at the iterate, `start` B_n, the constraint gradients at the start of the step without those
  // of velocity equations.
  [[nodiscard]] bool factorize(const Evaluation& e, const Evaluation& start, const StepScales& step,
                               const BodyTangents& tangents, Factorization& f);
  // Unknowns: motion increments, laid out as v, then those of lambda, then those of mu.
  int size() const { return lu_->size(); }
  void solve(const Factorization& f, VectorXd& x) const { lu_->solve(f, x.data()); }
  // The right side of an iteration with residual r; if some constraints are soft, what lambda and mu add to it.
  void right_side(const Evaluation& e, const VectorXd& r, const StepScales& step, VectorXd& x) const;
  void add_compliance(const VectorXd& lambda, const VectorXd& mu, const StepScales& step, VectorXd& x) const;
  bool soft() const { return !soft_.empty(); }
  // lambda and mu plus their increments in a solution x.
  void add_multipliers(const VectorXd& x, const StepScales& step, VectorXd& lambda, VectorXd& mu) const;

 private:
  // N: in how many of a body's last velocities the tangents differ from the identity.
  template <int N>
  [[nodiscard]] bool factorize_of(const Evaluation& e, const Evaluation& start, const StepScales& step,
                                  const BodyTangents& tangents, Factorization& f);
  template <int N>
  void write_pairs(const Evaluation& e, const StepScales& step, const BodyTangents& tangents, Factorization& f);
  template <int N, int Size>
  void write_incidence(int k, const Evaluation& e, const Evaluation& start, const StepScales& step,
                       const BodyTangents& tangents, Factorization& f);
  template <int N, int Size>
  void add_shared(int a, int b, const Evaluation& e, const Evaluation& start, const BodyTangents& tangents,
                  double* block);

  void place_velocity_equations();
  template <int N>
  void write_velocity_equations(const Evaluation& e, const StepScales& step, const BodyTangents& tangents,
                                Factorization& f) const;

  void add_compliance(const StepScales& step, Factorization& f) const;
  // What e is multiplied by.
  double softening(const StepScales& step) const { return std::max(1.0, least_scale_ / step.scale); }

  bool stabilized() const { return formulation_ == Formulation::stabilized_index2; }
  // In the vector of unknowns.
  int first_lambda() const { return system_.velocity_size(); }
  int first_mu() const { return system_.velocity_size() + system_.constraint_size(); }
  bool pose(const BlockPattern::Incidence& incidence) const {
    return system_.pattern().unknowns[incidence.unknown].pose;
  }

  // Where blocks are in a Factorization: of each pair; of the columns and rows of each incidence, for lambda and for
  // mu; of two incidences with the same unknown, and of what an incidence adds to the columns of another unknown of the
  // same body.
  struct Incident {
    int column, row, column_mu, row_mu;
    int inertia;  // offset of the unknown's block of M in S_
  };
  struct Shared {
    int incidence1, incidence2, block;
  };
  struct Mixed {
    int incidence, pair, column;
  };
  // An equation with compliance: its index in lambda, what its multipliers add to it, and where it is in a
  // Factorization.
  struct SoftEquation {
    int index;
    double force, motion;
    int diagonal, diagonal_mu, below;  // (lambda, lambda), (mu, mu), (mu, lambda)
    bool of_velocities;                // alone: with none of the last two
  };
  // Rows of a (mu, mu) block that belong into the (lambda, mu) block.
  struct MovedRows {
    int from, to, count;
  };
  const System& system_;
  Formulation formulation_;
  double least_scale_;
  std::shared_ptr<const BlockLU> lu_;
  std::vector<SoftEquation> soft_;
  std::vector<int> velocity_incidences_;  // of constraints with velocity equations, but in index 2
  std::vector<MovedRows> moved_;
  std::vector<int> unit_diagonals_;  // (mu, mu)
  std::vector<int> pairs_;
  std::vector<Incident> incidences_;
  std::vector<Shared> shared_;
  std::vector<Mixed> mixed_;
  VectorXd S_;  // kappa M + scale gamma' C, then for the pairs of M D P^-1
};

}  // namespace sigmafmu
