// What the Python package asks of a mechanism while it reads files and draws, beside its description, as JSON.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "model/mechanism.h"

namespace sigmafmu {

// Positions q and velocities v of the initial values, moved onto the joints' equations, and the joints' coordinates and
// rates there. `values` are parameters to set before, by their names in the FMU. The mechanism has its modal data.
// Throws std::exception with one sentence for one that is wrong or cannot be assembled.
std::string start(Mechanism mechanism, const std::map<std::string, double>& values);

// At positions q: `gaps` of the joints' equations and `rows`, their gradients by velocities, zero for equations of
// velocities alone; then the same of the
// `values` of chosen joint coordinates, `value_rows`. Matrices are lists of rows.
std::string closure(const Mechanism& mechanism, const std::vector<double>& q, const std::vector<int>& coordinates);

// At the start: the acceleration of each of these joint coordinates by a unit of force on it, all other forces held.
std::string mobility(const Mechanism& mechanism, const std::vector<int>& coordinates);

// Of a frame of the ground that moves as prescribed, at n times [s]: `positions` in W, n x 3 [m], and `quaternions`
// R_WB (w, x, y, z), n x 4. Displacements [m] and rotation vectors [rad], n x 6 by rows, are added to its tables.
std::string poses(const Mechanism& mechanism, int motion, const std::vector<double>& times,
                  const std::vector<double>& added);

// Degrees of freedom as a sentence, groups of joints whose equations depend on each other, and the bodies' masses.
std::string freedom_and_masses(const Mechanism& mechanism);

}  // namespace sigmafmu
