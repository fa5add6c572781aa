// Equations Phi(q, t) = 0 between frames. Time enters by what drives prescribe (Inputs) alone.
//
// With Phi' = B v + Phi_t and, at fixed velocities, Z = d(Phi')/d(motion) and W = d(Phi')/dt (explicit time alone),
//
//   Phi'' = B vdot + Z v + W.
//
// Its last equations may be of velocities alone, as rolling without slip: B v + Phi_t = 0 with a B that is no gradient,
// and a Phi that is always zero. Every formulation holds them as index 2 holds all.
//
// A constraint sees the kinematics of its frames and writes rows for their velocities and motions; the System turns
// them into rows for the unknowns (frame.h). The multipliers act with the forces -B^T lambda.
#pragma once

#include <vector>

#include "multibody/input_signal.h"
#include "multibody/kinematics.h"

namespace sigmafmu {

class Constraint {
 public:
  virtual ~Constraint() = default;

  int equations() const { return equations_; }
  // The first ones [m], the others of directions or angles [1].
  int length_equations() const { return length_equations_; }
  int velocity_equations() const { return velocity_equations_; }
  // Whether d(B^T lambda)/d(motion) has blocks between different frames.
  bool couples_frames() const { return couples_frames_; }
  virtual int frame_count() const = 0;

  // Phi, Phi' [m or 1 and per s] and B.
  virtual void evaluate(const Inputs& u, const Kinematics& k, double* phi, double* phidot,
                        const FrameRows& B) const = 0;
  // Z and W; W is zero before.
  virtual void rates(const Inputs& u, const Kinematics& k, const FrameRows& Z, double* W) const = 0;
  // K += d(B^T lambda)/d(motion).
  virtual void stiffness(const Inputs& u, const Kinematics& k, const double* lambda, const FramePairs& K) const = 0;

 protected:
  int equations_ = 0, length_equations_ = 0, velocity_equations_ = 0;
  bool couples_frames_ = false;
};

}  // namespace sigmafmu
