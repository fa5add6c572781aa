// The iteration matrix of one Newton step, scaled with beta h^2 so that its condition does not grow as h -> 0
// (Bottasso, Dopico, Trainelli 2008). Unknowns: motion increments Delta q of the bodies, beta h^2 Delta lambda and,
// for the stabilized index-2 form, Delta mu. With
//
//   U_i = diag(I, U_rot)     dv/d(motion) / gamma',   D_i = kappa M_i + gamma h C_ii,   kappa = beta h^2 beta'
//
//   dynamics   [ kappa M U + gamma h C U + beta h^2 K     B^T   D P^-1 B_n^T ]
//   Phi        [ B                                         0     0            ]
//   Phi'/gamma'[ Z/gamma' + B U                            0     B P^-1 B_n^T ]
//
// which are Eqs. (67) and (D.2), scaled; in the stabilized form the second row is subtracted from the third, so that
// only small terms couple mu to the motion. Index 2 has the third row in place of the second.
#pragma once

#include "integrator/block_lu.h"
#include "integrator/settings.h"
#include "multibody/system.h"

namespace sigmafmu {

class NewtonMatrix {
 public:
  NewtonMatrix(const System& system, Formulation formulation);

  // Per body: U_rot and P^-1, 3x3; set by the corrector before factorize().
  std::vector<Matrix3d> U_rot, P_inverse;
  bool identity_P = true;  // sigma = 1

  Factorization make_factorization() const { return lu_.make_factorization(); }
  // `e` holds C, K, B, Z at the iterate, `B_n` the constraint gradients at the start of the step.
  [[nodiscard]] bool factorize(const Evaluation& e, const std::vector<JointEvaluation>& B_n, double h,
                               const AlphaParameters& alpha, Factorization& f);
  // Offsets into the vector of unknowns.
  int size() const { return lu_.size(); }
  int body_offset(int body) const { return lu_.offset(body); }
  int lambda_offset(int joint) const { return lu_.offset(system_.body_count() + joint); }
  int mu_offset(int joint) const { return lambda_offset(joint) + system_.joint(joint).equations(); }
  void solve(const Factorization& f, VectorXd& x) const { lu_.solve(f, x.data()); }

 private:
  struct SharedBody {
    int joint1, side1, joint2, side2, body;
  };
  const System& system_;
  std::vector<Matrix6d> D_;  // D P^-1 of each body
  Formulation formulation_;
  BlockLU lu_;
  std::vector<SharedBody> shared_;  // all pairs of joints that meet at a body, a joint with itself included
};

}  // namespace sigmafmu
