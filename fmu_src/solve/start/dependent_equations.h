// Which of the joints' equations follow from others, and why a position cannot be computed: what a mechanism is told
// when it is assembled or has failed. With allocations: never part of a step that goes well.
#pragma once

#include <string>
#include <vector>

#include "multibody/system.h"

namespace sigmafmu {

// The equations B v = 0 of joints and drives at a position.
struct Freedom {
  int velocities = 0, equations = 0, independent = 0;
  int independent_of_positions = 0;  // without those of velocities alone, as rolling has them
  // Joints whose equations depend on each other, apart from those of other groups: which equations of a joint follow
  // from those before them is a matter of order.
  struct Group {
    std::vector<int> joints;           // and drives: constraints of the System
    int equations = 0, dependent = 0;  // of these joints
  };
  std::vector<Group> groups;
  double margin = 1;              // smallest part of an equation that is perpendicular to those before it
  double independent_margin = 1;  // the same, of those that do not follow from the others

  int degrees() const { return velocities - independent; }
  int degrees_of_positions() const { return velocities - independent_of_positions; }
};

Freedom freedom(const System& system, const VectorXd& q);
// At the initial positions, moved onto the joints' equations as far as that goes.
Freedom initial_freedom(const MultibodyDef& definition);

// For the joints and drives of all groups, as the definition comes: a value that is set makes no equation dependent.
Compliance find_compliance(const MultibodyDef& definition);

// "1 (18 velocities, 17 independent joint equations)", or "3 of velocities, 5 of positions (6 velocities, ...)"
std::string summary(const Freedom& freedom);

// Moves q onto Phi(q) = 0 also where equations are dependent; false when it cannot be reached. The way there is another
// than that of ConsistentSolver: what is found is good for a diagnosis.
bool reach_positions(const System& system, const Inputs& u, VectorXd& q);

// Whether more equations are dependent at q, whose freedom is `f`, than wherever else its joints lead.
bool singular_at(const System& system, const VectorXd& q, const Freedom& f);

// One sentence when a position q, with Phi(q) = 0, is singular: more equations are dependent in it than wherever else
// its joints lead.
std::string describe_singular_position(const MultibodyDef& definition, const System& system, const VectorXd& q);

// One sentence when equations are dependent at q: which joints these are. Empty when all are independent.
std::string describe_dependence(const MultibodyDef& definition, const System& system, const VectorXd& q);

// One sentence when joints leave no motion at q: that they do so. Empty when they do.
std::string describe_rigidity(const MultibodyDef& definition, const System& system, const VectorXd& q);

// One sentence when q is near a position where independent equations become dependent, or empty.
std::string describe_nearness(const System& system, const VectorXd& q);

// One sentence when a rolling disk lies on its plane at q, or is as close to that as the sine `near` of an angle says.
std::string describe_flat_disk(const MultibodyDef& definition, const System& system, const VectorXd& q,
                               double near = 1e-6);

// Why the matrix of the equations of motion cannot be factorized at q: the sentence above, or which mass or inertia is
// too small.
std::string describe_singularity(const MultibodyDef& definition, const System& system, const VectorXd& q);

}  // namespace sigmafmu
