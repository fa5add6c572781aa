// What an integrator needs of the group it runs on: the motion of all bodies in a step in local coordinates theta,
//
//   q = tau(q_n, theta),   V = T(theta) dtheta/dt                          (Mueller 2022, Eqs. (18), (19), (50))
//
// for one group, one coordinate map and one kind of absolute coordinates; lie/lgt.h lists them. Integrators work with
// the velocities V of the group, the equations of motion with the mixed ones v = (v_WB in W, w_WB_B); here is where the
// two meet. On R^3 x SO(3) they are the same. Modal coordinates of flexible bodies are a vector space: theta is their
// increment and T the identity. Vectors are laid out as in multibody/system.h.
//
// Whatever the absolute coordinates, q holds quaternions. With rotation vectors they are those of the rotation vectors
// that are integrated, with the sign that makes them continuous.
#pragma once

#include <memory>

#include "integrator/implicit/step_equations.h"
#include "model/settings.h"

namespace sigmafmu {

class LocalCoordinates {
 public:
  explicit LocalCoordinates(bool mixed) : mixed(mixed) {}
  virtual ~LocalCoordinates() = default;

  const bool mixed;  // whether V and v are the same

  // V and Vdot at q of mixed velocities and accelerations, and back.
  virtual void to_group(const VectorXd& q, const VectorXd& v, const VectorXd& vdot, VectorXd& V,
                        VectorXd& Vdot) const = 0;
  virtual void to_mixed(const VectorXd& q, const VectorXd& V, const VectorXd& Vdot, VectorXd& v,
                        VectorXd& vdot) const = 0;
  // The same of an iterate, whose vectors may be the same.
  void iterate_to_group(Iterate& at) const {
    if (!mixed) to_group(at.q, at.v(), at.vdot(), at.V, at.Vdot);
  }
  void iterate_to_mixed(Iterate& at) const {
    if (!mixed) to_mixed(at.q, at.V, at.Vdot, at.v(), at.vdot());
  }
  // The group's entries of a mixed vector that is linear in velocities, in place.
  virtual void turn_to_group(const VectorXd& q, VectorXd& x) const = 0;
  // d(Vdot)/dt of d(vdot)/dt.
  virtual void jerk_to_group(const VectorXd& q, const VectorXd& v, const VectorXd& vdot, VectorXd& jerk) const = 0;

  // q = tau(q_n, theta).
  virtual void compose(const VectorXd& q_n, const VectorXd& theta, VectorXd& q) const = 0;
  // Stores q at the end of a step as the absolute coordinates have it; `stored` holds the step before.
  virtual void store(const VectorXd& q, VectorXd& stored) const = 0;
  // Rotation [rad] that theta stands for, largest of all bodies.
  virtual double largest_rotation(const VectorXd& theta, int& body) const = 0;

  // thetadot = T(theta)^-1 V.
  virtual void rate(const VectorXd& theta, const VectorXd& V, VectorXd& thetadot) const = 0;
  // theta after a further motion of the bodies at q = tau(q_n, theta) by dq (W, body axes) to first order.
  virtual void add_motion(const VectorXd& q, const VectorXd& dq, VectorXd& theta) const = 0;

  // Of the equations of a step: V, where b = B(q_n)^T mu may be null;
  virtual void velocities(const StepEquations& e, const VectorXd& theta, const VectorXd* b, VectorXd& V) const = 0;
  // theta += sigma/gamma' (T(theta)^-1 V - V): right side of (12) with (16) for velocities V;
  virtual void modify(const StepEquations& e, const VectorXd& V, VectorXd& theta) const = 0;
  // the derivatives of velocities and accelerations at an iterate; with T = P = I unless `exact`.
  virtual void tangents(const StepEquations& e, const VectorXd& q_n, const Iterate& at, bool exact,
                        BodyTangents& out) const = 0;
};

std::unique_ptr<LocalCoordinates> make_local_coordinates(const System& system, const IntegratorSettings& settings);
// On R^3 x SO(3) and on SE(3), whatever the settings say of the group.
std::unique_ptr<LocalCoordinates> make_r3xso3_coordinates(const System& system, const IntegratorSettings& settings);
std::unique_ptr<LocalCoordinates> make_se3_coordinates(const System& system, const IntegratorSettings& settings);

}  // namespace sigmafmu
