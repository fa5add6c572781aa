// Inertias of joint coordinates in the equations of a System: beside the bodies they alone take part in M.
#include "multibody/bodies/rigid_body_inline.h"
#include "multibody/system.h"

namespace sigmafmu {

void System::add_armature_masses(Evaluation& e) const {
  for (const auto& [offset, body] : armature_blocks_) {
    PairBlock<6, 6> M(e.M.data() + offset);
    M.setZero();
    if (!body) continue;
    M.diagonal().head<3>().setConstant(body->mass);
    M.bottomRightCorner<3, 3>() = body->J;
  }
  for (const auto& [element, force] : armatures_) {
    element->add_mass(force_kinematics(e, force), pairs(forces_[force].at, e.M, e.M));
  }
}

JointArmature::Accelerations System::accelerations(const Evaluation& e, const Attachment& at,
                                                   const VectorXd& vdot) const {
  const auto of = [&](int frame) { return frame_acceleration(e, frame, vdot, vdot); };  // no node, no velocities
  return {of(at.frames[0]), of(at.frames[1])};
}

void System::add_armature_forces(const Evaluation& e, const VectorXd& vdot, VectorXd& r) const {
  for (const auto& [element, force] : armatures_) {
    const Attachment& at = forces_[force].at;
    element->add_inertial_force(kinematics(e, at), accelerations(e, at, vdot), {r.data(), at.force.data()});
  }
}

void System::linearize_armatures(const VectorXd& vdot, Evaluation& e) const {
  for (const auto& [element, force] : armatures_) {
    const Attachment& at = forces_[force].at;
    element->linearize(kinematics(e, at), accelerations(e, at, vdot), pairs(at, e.K, e.K), pairs(at, e.C, e.C));
  }
}

}  // namespace sigmafmu
