// Applied forces between frames. A force sees the kinematics of its frames and its own inputs; the System turns what it
// adds into forces and blocks of the unknowns (frame.h).
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "model/definition.h"
#include "multibody/input_signal.h"
#include "multibody/kinematics.h"

namespace sigmafmu {

class Force;

// An input or output of a force, a vector or, with size 0, a scalar. Inputs are in Inputs::u, in their order.
struct ForcePort {
  const char* name = nullptr;
  int size = 0;
  const char* type = nullptr;  // of real_types()
  const char* description = nullptr;
  void (*output)(const Force&, const Kinematics&, const Inputs&, double* values) = nullptr;  // null: an input
  bool times_velocity = false;                                                               // as Port::times_velocity
};

// Sums of stiffnesses [N/m], [N m/rad].
struct Stiffest {
  double translation = 0, rotation = 0;
};

class Force {
 public:
  virtual ~Force() = default;

  static constexpr int kMostFrames = 2;  // of any force but a Tendon
  virtual int frame_count() const = 0;
  virtual const std::vector<ForcePort>& ports() const = 0;
  // Takes over what may change while the System is in use.
  virtual void set_values(const MultibodyDef&) {}

  // r -= the generalized forces on the frames.
  virtual void add(const Kinematics& k, const Inputs& u, const FrameForces& r) const = 0;
  // K += dr/d(motion), C += dr/dv.
  virtual void linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const = 0;
  // Potential energy [J].
  virtual double energy(const Kinematics&, const Inputs&) const { return 0.0; }
  virtual Stiffest stiffest() const { return {}; }
  // Of its forces on all frames [W].
  virtual double power(const Kinematics& k, const Inputs& u) const {
    constexpr std::array<int, kMostFrames> offsets = {0, 6};
    std::array<double, 6 * kMostFrames> r = {};
    add(k, u, {r.data(), offsets.data()});
    double power = 0;
    for (int i = 0; i < frame_count(); ++i) {
      const Eigen::Map<const Vector6d> f(r.data() + offsets[i]);
      power -= f.head<3>().dot(k[i].v_WB) + f.tail<3>().dot(k[i].w_WB_B);
    }
    return power;
  }

  int input_count() const {
    int count = 0;
    for (const ForcePort& port : ports()) count += port.output ? 0 : std::max(1, port.size);
    return count;
  }
  int first_input() const { return first_input_; }
  void set_first_input(int index) { first_input_ = index; }

 protected:
  const double* own(const Inputs& u) const { return u.u.data() + first_input_; }

 private:
  int first_input_ = 0;
};

// Outputs of forces that have them.
inline void energy_output(const Force& f, const Kinematics& k, const Inputs& u, double* x) { *x = f.energy(k, u); }
inline void power_output(const Force& f, const Kinematics& k, const Inputs& u, double* x) { *x = f.power(k, u); }

}  // namespace sigmafmu
