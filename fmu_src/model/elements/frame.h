// A right-handed frame fixed in a body.
#pragma once

#include <Eigen/Core>

#include "model/elements/body_references.h"

namespace sigmafmu {

// Origin [m] and axes (columns x, y, z) in body coordinates. In a node of a flexible body it moves and turns with the
// node: origin and axes are then seen from the undeformed node, in B.
struct Frame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  int node = kFloatingFrame;
};

}  // namespace sigmafmu
