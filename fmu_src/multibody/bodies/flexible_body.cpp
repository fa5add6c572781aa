#include "multibody/bodies/flexible_body.h"

#include <algorithm>
#include <cmath>

#include "model/dense.h"
#include "multibody/bodies/flexible_inline.h"

namespace sigmafmu {
using Eigen::Map;
using lie::hat;

FlexibleBody::FlexibleBody(const ModalDef& d)
    : nodes_(d.nodes.transpose()), shapes_(d.shapes), rotations_(d.rotations), stiffness_(d.stiffness) {
  ModalConstants c = modal_constants(d);
  const MatrixXd M = undeformed_mass_matrix(c);
  mass_ = c.mass;
  S_ = std::move(c.S), G_ = std::move(c.G), modal_mass_ = std::move(c.modal_mass);
  if (rotations_.size() == 0) rotations_.setZero(3 * nodes(), modes());
  set_values(d);
  if (modes() == 0) return;  // what is left of M_ff when the frame moves freely
  const MatrixXd free = schur_complement(M.topLeftCorner<6, 6>(), M.bottomLeftCorner(modes(), 6), modal_mass_);
  highest_frequency_ = std::sqrt(std::max(0.0, largest_eigenvalue(stiffness_, free)));
}

void FlexibleBody::set_values(const ModalDef& d) {
  damping_ = d.mass_damping * modal_mass_ + d.stiffness_damping * stiffness_;
  if (d.damping.size() > 0) damping_ += d.damping;
}

FlexibleEvaluation FlexibleBody::make_evaluation() const {
  const int f = modes();
  FlexibleEvaluation e;
  for (VectorXd* x : {&e.zeta, &e.zetadot}) x->setZero(f);
  for (Matrix3Xd* x : {&e.G_z, &e.G_y, &e.G_x}) x->setZero(3, 3 * (f + 1));
  e.M_modal.setZero(6, f);
  return e;
}

void FlexibleBody::evaluate(const FrameKinematics& k, const double* zeta, const double* zetadot,
                            FlexibleEvaluation& e) const {
  const int f = modes();
  e.zeta = Map<const VectorXd>(zeta, f);
  e.zetadot = Map<const VectorXd>(zetadot, f);
  const auto S_f = S_.rightCols(f);
  const auto G_f = G_.rightCols(f);
  e.S_z = S_.col(0) + S_f.lazyProduct(e.zeta);
  e.S_y = S_f.lazyProduct(e.zetadot);
  flat(e.G_z) = G_.col(0);
  flat(e.G_z).noalias() += G_f.lazyProduct(e.zeta);
  flat(e.G_y).noalias() = G_f.lazyProduct(e.zetadot);
  e.G_zz = block(e.G_z, 0);
  e.G_zy.setZero();
  for (int a = 1; a <= f; ++a) {
    e.G_zz += zeta[a - 1] * block(e.G_z, a);
    e.G_zy += zetadot[a - 1] * block(e.G_z, a);
  }

  const Matrix3d RS = k.R_WB * hat(e.S_z);
  e.M.topLeftCorner<3, 3>() = mass_ * Matrix3d::Identity();
  e.M.topRightCorner<3, 3>() = -RS;
  e.M.bottomLeftCorner<3, 3>() = -RS.transpose();
  e.M.bottomRightCorner<3, 3>() = e.G_zz.trace() * Matrix3d::Identity() - e.G_zz;
  for (int a = 0; a < f; ++a) {
    e.M_modal.block<3, 1>(0, a) = k.R_WB * S_f.col(a);
    e.M_modal.block<3, 1>(3, a) = ax(block(e.G_z, a + 1));
  }
}

}  // namespace sigmafmu
