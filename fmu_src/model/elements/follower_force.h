// A force [N] at a point of a body and a torque [N m] that turn with it: both in the axes of the body, or of the node
// that the point belongs to. Inputs are added to the constants.
#pragma once

#include <vector>

#include "model/elements/one_point.h"
#include "model/parameter.h"

namespace sigmafmu {

struct FollowerForceDef : OnePoint {
  static constexpr const char *kKind = "follower force", *kType = "follower_force";

  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();

  static const std::vector<Parameter<FollowerForceDef>>& parameters() {
    using Def = FollowerForceDef;
    static const std::vector<Parameter<Def>> table = {
        {"force", "Force", "Constant force at the point, in body axes", 3, [](Def& d) { return d.force.data(); }},
        {"torque", "Torque", "Constant torque, in body axes", 3, [](Def& d) { return d.torque.data(); }},
    };
    return table;
  }
};

}  // namespace sigmafmu
