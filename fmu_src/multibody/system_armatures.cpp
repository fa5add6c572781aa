// Inertias of joint coordinates in the equations of a System: beside the bodies they alone take part in M.
#include "multibody/system.h"

namespace sigmafmu {

void System::add_armature_masses(Evaluation& e) const {
  for (const auto& [pair, rigid, modes] : armature_blocks_) {
    auto M = pair_block(pattern_, pair, e.M);
    M.setZero();
    if (rigid) {
      M.diagonal().head<3>().setConstant(rigid->mass);
      M.bottomRightCorner<3, 3>() = rigid->J;
    }
    if (modes) M = modes->modal_mass();
  }
  for (const auto& [element, force] : armatures_) {
    const Attachment& at = forces_[force].at;
    if (at.at_node) e.frame_K.setZero();
    element->add_mass(kinematics(e, at), pairs(at, e.M, e.frame_K));
    if (at.at_node) pull_back_masses(at, e);
  }
}

JointArmature::Accelerations System::accelerations(const Evaluation& e, const Attachment& at,
                                                   const VectorXd& vdot) const {
  return {frame_acceleration(e, at.frames[0], vdot), frame_acceleration(e, at.frames[1], vdot)};
}

void System::add_armature_forces(Evaluation& e, const VectorXd& vdot, VectorXd& r) const {
  for (const auto& [element, force] : armatures_) {
    const Attachment& at = forces_[force].at;
    if (at.at_node) e.frame_forces.setZero();
    double* forces = at.at_node ? e.frame_forces.data() : r.data();
    element->add_inertial_force(kinematics(e, at), accelerations(e, at, vdot), {forces, at.force.data()});
    if (at.at_node) pull_back_forces(at, e, r);
  }
}

void System::linearize_armatures(const VectorXd& vdot, Evaluation& e) const {
  for (const auto& [element, force] : armatures_) {
    const Attachment& at = forces_[force].at;
    const Kinematics k = kinematics(e, at);
    const JointArmature::Accelerations a = accelerations(e, at, vdot);
    if (at.at_node) {
      e.frame_K.setZero();
      e.frame_C.setZero();
    }
    element->linearize(k, a, pairs(at, e.K, e.frame_K), pairs(at, e.C, e.frame_C));
    if (!at.at_node) continue;
    e.frame_forces.setZero();
    element->add_inertial_force(k, a, {e.frame_forces.data(), at.force.data()});
    pull_back_pairs(at, e);
    // What these derivatives hold fixed, the accelerations of nodes, depends on motions and velocities as well.
    e.frame_K.setZero();
    element->add_mass(k, pairs(at, e.K, e.frame_K));
    pull_back_accelerations(at, vdot, e);
  }
}

}  // namespace sigmafmu
