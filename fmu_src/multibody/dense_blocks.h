// Blocks as whole matrices, where time does not matter: for the start of a mechanism, for tests and linear models.
#pragma once

#include "multibody/system.h"

namespace sigmafmu {

// M, C or K of an evaluation, velocities by velocities.
inline MatrixXd dense_pairs(const System& system, const VectorXd& values) {
  const BlockPattern& pattern = system.pattern();
  MatrixXd result = MatrixXd::Zero(system.velocity_size(), system.velocity_size());
  for (const auto& pair : pattern.pairs) {
    if (pair.offset >= values.size()) break;  // M has only the first ones
    const Unknown &row = pattern.unknowns[pair.row], &column = pattern.unknowns[pair.column];
    result.block(row.velocity, column.velocity, row.size, column.size) = pair_block(pattern, pair, values);
  }
  return result;
}

// B or Z of an evaluation, equations by velocities.
inline MatrixXd dense_rows(const System& system, const VectorXd& values) {
  const BlockPattern& pattern = system.pattern();
  MatrixXd result = MatrixXd::Zero(system.constraint_size(), system.velocity_size());
  for (const auto& incidence : pattern.incidences) {
    const Unknown& unknown = pattern.unknowns[incidence.unknown];
    const int m = pattern.constraint_sizes[incidence.constraint];
    result.block(system.lambda_index(incidence.constraint), unknown.velocity, m, unknown.size) =
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            values.data() + incidence.offset, m, unknown.size);
  }
  return result;
}

}  // namespace sigmafmu
