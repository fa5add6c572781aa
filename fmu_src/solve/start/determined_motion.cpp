#include "solve/start/determined_motion.h"

#include <utility>

namespace sigmafmu {
namespace {

MultibodyDef driven(MultibodyDef definition, const std::vector<int>& coordinates) {
  std::vector<std::pair<int, int>> places;  // of each coordinate: its joint, which of this joint
  for (std::size_t j = 0; j < definition.joints.size(); ++j) {
    for (int c = 0; c < definition.joints[j].coordinate_count(); ++c) places.emplace_back(static_cast<int>(j), c);
  }
  for (int c : coordinates) definition.drives.push_back({places[c].first, places[c].second});
  return definition;
}

}  // namespace

DeterminedMotion::DeterminedMotion(const MultibodyDef& definition, std::vector<int> coordinates, const Inputs& u)
    : coordinates_(std::move(coordinates)),
      driven_(driven(definition, coordinates_)),
      system_(driven_),
      solver_(system_),
      u_(system_.make_inputs()) {
  u_.x.head(u.x.size()) = u.x;
  u_.xdot.head(u.x.size()) = u.xdot;
}

bool DeterminedMotion::positions(const VectorXd& x, VectorXd& q) {
  u_.x.tail(x.size()) = x;
  return solver_.project_positions(u_, q).possible;
}

bool DeterminedMotion::velocities(const VectorXd& q, const VectorXd& rates, VectorXd& v) {
  u_.xdot.tail(rates.size()) = rates;
  for (int repeat = 0; repeat < 2; ++repeat) {  // in long chains the equations cost digits
    if (!solver_.project_velocities(q, u_, v)) return false;
  }
  return true;
}

}  // namespace sigmafmu
