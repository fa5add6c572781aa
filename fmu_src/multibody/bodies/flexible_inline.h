// What the equations of a flexible body are written with.
#pragma once

#include "lie/isotropic_operator.h"
#include "multibody/bodies/flexible_body.h"

namespace sigmafmu {

// ax(s t^T) = s x t.
inline Vector3d ax(const Matrix3d& A) { return {A(1, 2) - A(2, 1), A(2, 0) - A(0, 2), A(0, 1) - A(1, 0)}; }

inline auto block(const Matrix3Xd& G, int a) { return G.middleCols<3>(3 * a); }
inline Eigen::Map<VectorXd> flat(Matrix3Xd& G) { return {G.data(), G.size()}; }

}  // namespace sigmafmu
