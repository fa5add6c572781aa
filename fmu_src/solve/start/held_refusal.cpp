// What HeldProjection says when initial values contradict each other or the joints.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "solve/start/contradiction.h"
#include "solve/start/held_projection.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

using Kind = InitialValue::Kind;

// "a, b and c"; a long list is cut.
std::string list(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 6;
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kMost; ++i) {
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  }
  return names.size() > kMost ? text + " and " + std::to_string(names.size() - kMost) + " more" : text;
}

}  // namespace

// Says which values and joints contradict each other, of the equations in A_ that miss by `gaps`.
void HeldProjection::refuse(const VectorXd& gaps, const Coordinates& coordinates, bool motion) const {
  std::vector<Claim> claims;
  std::vector<std::string> names;
  std::vector<const char*> units(gaps.size(), motion ? "rad/s" : "rad");
  const auto write = [](const auto&... parts) {
    std::ostringstream text = text_stream(6);
    (text << ... << parts);
    return text.str();
  };
  for (const auto& [what, start] : definition_.held) {
    if (what.of_motion() != motion) continue;
    Claim claim;
    std::string name = initial_name(definition_, what);
    if (what.kind == Kind::quaternion) {  // one for all four elements
      if (!names.empty() && names.back() == name) continue;
    } else {
      if (!what.of_joint()) name += "[" + std::to_string(what.component + 1) + "]";
      name += write(" = ", initial_value(definition_, what), " ", initial_unit(definition_, what));
    }
    if (!what.of_joint()) claim.columns = columns(what);
    for (std::size_t i = 0; what.of_joint() && i < coordinates.size(); ++i) {
      if (coordinates[i].index != system_.coordinate_index(what.object) + what.component) continue;
      claim.rows.push_back(system_.constraint_size() + static_cast<int>(i));
      units[claim.rows.back()] = initial_unit(definition_, what);
    }
    claims.push_back(claim);
    names.push_back(name);
  }
  const std::size_t values = claims.size();
  for (int j = 0; j < system_.constraint_count(); ++j) {
    Claim claim;
    for (int i = 0; i < system_.constraint(j).equations(); ++i) claim.rows.push_back(system_.lambda_index(j) + i);
    for (int i = 0; i < system_.constraint(j).length_equations(); ++i) units[claim.rows[i]] = motion ? "m/s" : "m";
    claims.push_back(claim);
    names.push_back(constraint_name(definition_, j));
  }

  const VectorXd weights = lengths_of_units(coordinates);
  const Contradiction found = find_contradiction(weights.asDiagonal() * A_, weights.cwiseProduct(gaps), claims, values);
  std::vector<std::string> parties[2];  // values, joints
  for (int i : found.claims) parties[static_cast<std::size_t>(i) >= values].push_back(names[i]);
  const auto& [of_values, of_joints] = parties;
  // The equations of directions miss by the sine of an angle.
  const bool direction = !motion && found.row < system_.constraint_size() && *units[found.row] == 'r';
  const double missing = found.gap / weights[found.row];
  const double gap = direction ? std::asin(std::min(missing, 1.0)) : missing;
  const std::string joints = (of_joints.size() == 1 ? "joint " : "joints ") + list(of_joints);
  std::string text = list(of_values);
  if (of_values.empty()) {
    text = "The mechanism cannot be assembled from its initial positions: " + joints + " cannot be closed" +
           (of_joints.size() > 1 ? " together, they miss" : ", it misses");
  } else {
    text += (of_values.size() == 1 ? " contradicts " : " contradict ") + (of_joints.empty() ? "each other" : joints);
  }
  throw std::runtime_error(write(text, " by ", gap, " ", units[found.row], "."));
}

}  // namespace sigmafmu
