#include "multibody/momentum.h"

namespace sigmafmu {

Momentum momentum(const System& system, const Evaluation& e) {
  Momentum sum;
  for (int i = 0; i < system.body_count(); ++i) {
    const FrameKinematics& k = system.kinematics(e, i);
    double mass = 0;
    Vector3d moment = Vector3d::Zero(), linear, angular;  // first moment in B; angular: about p_WB, in B
    if (const RigidBody* body = system.rigid(i)) {
      mass = body->mass;
      linear = mass * k.v_WB;
      angular = body->J * k.w_WB_B;
    } else {
      const FlexibleEvaluation& at = e.flexible[system.flexible_index(i)];
      Vector6d v;
      v << k.v_WB, k.w_WB_B;
      Vector6d of_body = at.M * v;
      of_body += at.M_modal.lazyProduct(at.zetadot);
      mass = system.flexible(system.flexible_index(i)).mass();
      moment = at.S_z;
      linear = of_body.head<3>();
      angular = of_body.tail<3>();
    }
    sum.mass += mass;
    sum.centre_of_mass += mass * k.p_WB + k.R_WB * moment;
    sum.linear += linear;
    sum.angular += k.p_WB.cross(linear) + k.R_WB * angular;
  }
  sum.centre_of_mass /= sum.mass;
  return sum;
}

}  // namespace sigmafmu
