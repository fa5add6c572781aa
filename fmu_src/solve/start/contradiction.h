// Who is to blame when linear equations A x = -r have no solution.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace sigmafmu {

// One party: it asks for the equations `rows` and forbids the unknowns `columns` to change.
struct Claim {
  std::vector<int> rows, columns;
};

struct Contradiction {
  std::vector<int> claims;  // a smallest part of them: without any of these the others go together
  int row = 0;              // the equation that misses most if all others hold ...
  double gap = 0;           // ... and by how much
};

// r is what is left where the least can be left. Of the first `values` claims, if any, one at least is to blame.
Contradiction find_contradiction(const Eigen::MatrixXd& A, const Eigen::VectorXd& r, const std::vector<Claim>& claims,
                                 std::size_t values);

}  // namespace sigmafmu
