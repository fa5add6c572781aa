// What the equations of a flexible body are written with.
#pragma once

#include "lie/isotropic_operator.h"
#include "multibody/bodies/flexible_body.h"

namespace sigmafmu {

inline auto block(const Matrix3Xd& G, int a) { return G.middleCols<3>(3 * a); }
inline Eigen::Map<VectorXd> flat(Matrix3Xd& G) { return {G.data(), G.size()}; }

}  // namespace sigmafmu
