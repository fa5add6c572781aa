// Local-global transition maps, Mueller 2022, section 6: all eight of Table 1 and those of second order.
//
//   q' = tau(q, X) = alpha^-1(alpha(q) psi(X)),   Eqs. (18), (50)
//
// Absolute is QuaternionPosition (rows 1) or RotationVectorPosition (rows 2) of pose.h, which hold alpha. Group is
// SE3<Map> or R3xSO3<Map>, which hold the product and psi:
//
//   a) SE3<Exponential>     screw coordinates
//   b) R3xSO3<Exponential>  rotation vector, displacement
//   c) R3xSO3<Cayley>       Rodrigues parameters, displacement;  R3xSO3<Cayley2> Wiener-Milenkovic parameters
//   d) SE3<Cayley>          extended Rodrigues parameters;       SE3<Cayley2>
//
// With a quaternion tau is (60)-(66). With a rotation vector it is the composition formulas (74)-(76), (77)-(79): their
// numerators are the product of two quaternions, 1/sinc(Phi/2) is in the logarithm. That takes Phi of atan2: the arccos
// of (76) loses half of the digits at small angles, and sinc(Phi/2) = 0 at 2 pi is never met because |q_r| <= pi.
#pragma once

#include "lie/pose.h"
#include "lie/r3xso3.h"
#include "lie/se3.h"

namespace sigmafmu::lie {

// q, q': 7 or 6 numbers; X: 6 numbers [m], [rad to first order].
template <class Absolute, class Group>
inline typename Absolute::Vector tau(const typename Absolute::Vector& q, const Vector6d& X) {
  return Absolute::coordinates(Group::product(Absolute::pose(q), Group::psi(X)));
}

}  // namespace sigmafmu::lie
