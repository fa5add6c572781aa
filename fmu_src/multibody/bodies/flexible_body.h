// Flexible body: floating frame of reference with modal coordinates, all inertia terms kept.
//
// Nodal formulation and its few constants after Zwoelfer & Gerstmayr, "A concise nodal-based derivation of the floating
// frame of reference formulation for displacement-based solid finite elements", Multibody Syst Dyn 49 (2020) 291-313,
// and "The nodal-based floating frame of reference formulation with modal reduction", Acta Mech 232 (2021) 835-851.
//
// Node i is at r_i = x + R s_i with s_i = X_i + Phi_i zeta, in B. With U_0 = X, U_a = Phi_a (a = 1..f) and z = (1,
// zeta), y = (0, zeta'), x = (0, zeta'') it is s = U z, s' = U y, and
//
//   r_i'  = v + R (w x s_i + s_i')
//   r_i'' = R (b + P s_i + 2 w x s_i' + U_i x),   b = R^T vdot,   P = hat(wdot) + hat(w)^2.
//
// v in W, w in B. T = 1/2 sum_ij M_ij r_i'^T r_j', and the velocities v = (v, w, zeta') of the body move node i by
// J_i = [I, -R hat(s_i), R Phi_i]. Virtual work sum_ij M_ij J_i^T r_j'' needs nothing of the nodes but
//
//   m = sum_ij M_ij,   S_a = sum_ij M_ij U_a,j  (3),   G_ab = sum_ij M_ij U_a,i U_b,j^T  (3x3),   G_ba = G_ab^T.
//
// An index z, y, x instead of a number stands for the sum with that vector: G_za = sum_b z_b G_ba, S_z = sum_a z_a S_a.
// With ax(A)_k = eps_klm A_lm, so that ax(s t^T) = s x t, and b = R^T (vdot - g), the residual is
//
//   frame, v     m (vdot - g) + R (P S_z + 2 w x S_y + S_x)
//   frame, w     S_z x b + ax(G_zz P^T + 2 G_zy hat(w)^T + G_zx)
//   mode a       S_a . b + tr(P G_za + 2 hat(w) G_ya + G_xa) + (K zeta + D zeta')_a
//
// and the mass matrix, with J = tr(G_zz) I - G_zz and column a of H = ax(G_za),
//
//   [ m I           -R hat(S_z)   R S_f ]
//   [ hat(S_z) R^T   J            H     ]
//   [ S_f^T R^T      H^T          M_ff  ],   (M_ff)_ab = tr(G_ab).
#pragma once

#include "model/modal_constants.h"
#include "multibody/pattern.h"

namespace sigmafmu {

// At (q, v); rows of M belong to (v, w).
struct FlexibleEvaluation {
  VectorXd zeta, zetadot;
  Vector3d S_z, S_y;
  Matrix3Xd G_z, G_y, G_x;  // G_za, G_ya, G_xa side by side, a = 0..f; G_x after linearize
  Matrix3d G_zz, G_zy;
  Matrix6d M;         // frame with itself
  Matrix6Xd M_modal;  // frame with modes
};

class FlexibleBody {
 public:
  // The mass matrix must be positive definite.
  explicit FlexibleBody(const ModalDef& definition);
  // Takes over what may be tuned, the damping; cheap and without allocation.
  void set_values(const ModalDef& definition);

  int modes() const { return static_cast<int>(modal_mass_.rows()); }
  int nodes() const { return static_cast<int>(nodes_.cols()); }
  double mass() const { return mass_; }
  const MatrixXd& modal_mass() const { return modal_mass_; }  // M_ff, constant
  const MatrixXd& stiffness() const { return stiffness_; }
  const MatrixXd& damping() const { return damping_; }  // Rayleigh's share included
  // Highest angular frequency of the free body, undeformed and at rest [rad/s].
  double highest_frequency() const { return highest_frequency_; }

  auto shape(int node) const { return shapes_.middleRows<3>(3 * node); }        // Phi_i, 3 x f
  auto rotation(int node) const { return rotations_.middleRows<3>(3 * node); }  // Psi_i, 3 x f
  // s_i in B [m].
  Vector3d position(int node, const FlexibleEvaluation& e) const {
    return nodes_.col(node) + shape(node).lazyProduct(e.zeta);
  }

  FlexibleEvaluation make_evaluation() const;
  // f coordinates and rates.
  void evaluate(const FrameKinematics& k, const double* zeta, const double* zetadot, FlexibleEvaluation& e) const;
  // r += inertia, gravity g (W), stiffness and damping; rows of the frame and of the modes.
  void add_residual(const FrameKinematics& k, const FlexibleEvaluation& e, const double* vdot, const double* zetaddot,
                    const Vector3d& g, double* r_frame, double* r_modal) const;

  // Blocks of a matrix by (frame, modes).
  struct Blocks {
    PairBlock<6, 6> frame;
    PairBlock<6, Eigen::Dynamic> frame_modal;
    PairBlock<Eigen::Dynamic, 6> modal_frame;
    PairBlock<Eigen::Dynamic, Eigen::Dynamic> modal;
  };
  // C += dr/dv, K += dr/d(motion) of that residual, d(M vdot) included.
  void linearize(const FrameKinematics& k, FlexibleEvaluation& e, const double* vdot, const double* zetaddot,
                 const Vector3d& g, Blocks C, Blocks K) const;

  double kinetic_energy(const FrameKinematics& k, const FlexibleEvaluation& e) const;
  // Of gravity g (W) and of the deformation [J].
  double potential_energy(const FrameKinematics& k, const FlexibleEvaluation& e, const Vector3d& g) const;

 private:
  double mass_ = 0;
  Matrix3Xd nodes_;              // X
  MatrixXd shapes_, rotations_;  // Phi, Psi
  MatrixXd G_;                   // column b: G_b0, G_b1, ... G_bf, each by columns
  Matrix3Xd S_;                  // S_0, S_1, ... S_f
  MatrixXd modal_mass_, stiffness_, damping_;
  double highest_frequency_ = 0;
};

}  // namespace sigmafmu
