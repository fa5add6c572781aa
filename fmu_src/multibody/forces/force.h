// Applied forces between frames. A force sees the kinematics of its frames and its own inputs; the System turns what it
// adds into forces and blocks of the unknowns (frame.h).
#pragma once

#include "model/definition.h"
#include "multibody/kinematics.h"

namespace sigmafmu {

class Force {
 public:
  virtual ~Force() = default;

  virtual int frame_count() const = 0;
  virtual int input_count() const { return 0; }
  // Takes over what may change while the System is in use.
  virtual void set_values(const MultibodyDef&) {}

  // r -= the generalized forces on the frames; u: the force's inputs.
  virtual void add(const Kinematics& k, const double* u, const FrameForces& r) const = 0;
  // K += dr/d(motion), C += dr/dv.
  virtual void linearize(const Kinematics& k, const double* u, const FramePairs& K, const FramePairs& C) const = 0;
  // Potential energy [J].
  virtual double energy(const Kinematics&) const { return 0.0; }
};

}  // namespace sigmafmu
