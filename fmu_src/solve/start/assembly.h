// The start of a mechanism: positions and velocities that satisfy its joints, from the initial values of its
// definition.
//
// Where nothing was set all initial values give way, by the least change in the mass metric. Values that were set
// (MultibodyDef::held) stay, and the others give way to them, starting from where they are when nothing is set.
#pragma once

#include <string>

#include "solve/index1.h"

namespace sigmafmu {

// Throws std::runtime_error with one sentence when that cannot be: it names the joints and the values that were set.
void assemble(const MultibodyDef& definition, const System& system, ConsistentSolver& solver, VectorXd& q, VectorXd& v);

// What is prescribed at the start. Of drives: their value, and else the coordinate and rate that were set or that the
// bodies have. Of couplings: their offset, or what their sum is where bodies have their initial values.
Inputs inputs_at_start(const MultibodyDef& definition, const System& system);
// Lets them go on from there.
void start_prescribed(const MultibodyDef& definition, const System& system, InputSignal& input);

// Where angles have been set with whole turns, couplings mesh all the same: they keep what their sums are now.
void mesh_couplings(const MultibodyDef& definition, const VectorXd& turned, InputSignal& input);

// Coordinates of joints at the start, with the whole turns of angles that were set.
VectorXd coordinates_at_start(const MultibodyDef& definition, const System& system, const VectorXd& q);

// What gave way to the values that were set, before and after, as one sentence; empty if nothing did.
std::string describe_moved_values(const MultibodyDef& definition, const System& system, ConsistentSolver& solver,
                                  const VectorXd& q, const VectorXd& v);

// Gives joints the coordinates and rates that they start with when nothing is set, to 12 digits: those that another
// machine computes as well.
void find_joint_values(MultibodyDef& definition, const KktPlans& plans = {});

}  // namespace sigmafmu
