// What is told of dependent equations, singular positions and masses that are too small.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "solve/start/dependent_equations.h"
#include "solve/start/scaled_equations.h"
#include "text/text.h"

namespace sigmafmu {
namespace {

constexpr double kFlat = 1e-6;  // sine of an angle between disk and plane

std::string list(const MultibodyDef& definition, const std::vector<int>& joints) {
  std::string text;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    text += (k == 0 ? "" : k + 1 == joints.size() ? " and " : ", ") + constraint_name(definition, joints[k]);
  }
  return text;
}

// "2 of the 19 equations of joints a, b and c follow from the others", for each group.
std::string dependences(const MultibodyDef& definition, const Freedom& f) {
  std::string text;
  for (std::size_t k = 0; k < f.groups.size(); ++k) {
    const Freedom::Group& g = f.groups[k];
    text += (k > 0 ? "; " : "") + std::to_string(g.dependent) + " of the " + std::to_string(g.equations) +
            " equations of " + (g.joints.size() == 1 ? "joint " : "joints ") + list(definition, g.joints) +
            (g.dependent == 1 ? " follows from the others" : " follow from the others");
  }
  return text;
}

}  // namespace

std::string summary(const Freedom& f) {
  std::ostringstream text = text_stream(6);
  text << f.degrees();
  if (f.degrees_of_positions() > f.degrees()) text << " of velocities, " << f.degrees_of_positions() << " of positions";
  text << " (" << f.velocities << " velocities, " << f.independent << " independent joint equations";
  if (f.equations > f.independent) text << ", " << f.equations - f.independent << " dependent ones";
  text << ")";
  return text.str();
}

std::string describe_singular_position(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  const Freedom f = freedom(system, q);
  if (!singular_at(system, q, f)) return "";
  return "The position is singular: " + dependences(definition, f) +
         " in it alone; choose a start at some distance from it, or velocities that lead through it.";
}

std::string describe_dependence(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  const Freedom f = freedom(system, q);
  if (f.groups.empty()) return "";
  return "Joint equations are dependent: " + dependences(definition, f) +
         (singular_at(system, q, f) ? " in this position alone" : "") +
         "; the reactions of these joints are one choice of many that fit the motion.";
}

std::string describe_rigidity(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  const Freedom f = freedom(system, q);
  if (f.degrees() > 0) return "";
  std::vector<int> joints(system.constraint_count());
  std::iota(joints.begin(), joints.end(), 0);
  return "The mechanism cannot move, but its bodies have initial velocities: joints " + list(definition, joints) +
         " hold all of them; degrees of freedom: " + summary(f) + ".";
}

std::string describe_nearness(const System& system, const VectorXd& q) {
  constexpr double kNear = 1e-3;
  const Freedom f = freedom(system, q);
  const bool more = f.equations - f.independent > system.compliance().dependent;
  const double margin = more ? f.margin : f.independent_margin;
  if (margin > kNear) return "";
  std::ostringstream text = text_stream(6);
  text << "The mechanism is near a singular position there: of one joint equation a part of " << margin
       << " is all that does not follow from the others.";
  return text.str();
}

std::string describe_flat_disk(const MultibodyDef& definition, const System& system, const VectorXd& q, double near) {
  if (system.velocity_equations().empty()) return "";  // no disk
  const RestPlace at(system, q);
  for (int j = 0; j < system.joint_count(); ++j) {
    const double tilt = system.tilt_of_disk(at.e, j);
    if (!(tilt <= near)) continue;
    return "The disk of joint " + definition.joints[j].name + (tilt > kFlat ? " nearly" : "") +
           " lies flat: with its axis normal to its plane it touches that in no single point.";
  }
  return "";
}

std::string describe_singularity(const MultibodyDef& definition, const System& system, const VectorXd& q) {
  if (const std::string text = describe_flat_disk(definition, system, q); !text.empty()) return text;
  if (const std::string text = describe_singular_position(definition, system, q); !text.empty()) return text;
  const VectorXd length = RestPlace(system, q).lengths.cwiseMax(1e-300);
  double heaviest = 0, least = INFINITY;
  for (const RigidBodyDef& body : definition.bodies) heaviest = std::max(heaviest, mass(body));
  int lightest = 0;
  for (int i = 0; i < system.body_count(); ++i) {
    const RigidBodyDef& body = definition.bodies[i];
    const double inertia = body.modal ? INFINITY : body.inertia.minCoeff() / (length[i] * length[i]);
    const double measure = std::min(mass(body), inertia);
    if (measure < least) least = measure, lightest = i;
  }
  const RigidBodyDef& body = definition.bodies[lightest];
  std::ostringstream text = text_stream(6);
  text << "The mass or inertia of body " << body.name << " is too small for this mechanism: " << mass(body) << " kg";
  if (!body.modal) text << " and at least " << body.inertia.minCoeff() << " kg.m2";
  text << ", where joints act at up to " << length[lightest] << " m and the heaviest body has " << heaviest
       << " kg; digits to tell them apart are missing.";
  return text.str();
}

}  // namespace sigmafmu
