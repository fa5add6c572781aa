// The rows of a sparse matrix A: which follow from others, and the shortest x with A x + r = 0.
//
// Householder reflections of the rows, one after the other, each on the columns where it is not zero: the work is that
// of the fill, small when every row stands next to those that it shares columns with. (Eigen's SparseQR takes a time
// that grows with the cube of the rows that follow from others.)
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <utility>
#include <vector>

namespace sigmafmu {

class RowSpace {
 public:
  // Rows of length 1 or so, as the columns of `transposed`. A row follows from those before it if a part of at most
  // `zero` is perpendicular to them.
  RowSpace(const Eigen::SparseMatrix<double>& transposed, double zero);

  int rank() const { return static_cast<int>(independent_.size()); }
  // The smallest perpendicular part of the rows that do not follow from others; 1 if there are none.
  double smallest_part() const { return smallest_part_; }
  struct Dependence {
    int row;
    double part;
    std::vector<std::pair<int, double>> weights;  // rows before it and their shares in it, if not below `zero`
  };
  // Dependences may reach over all rows: to find the shares takes longer than all else.
  std::vector<Dependence> dependences() const;
  // Of the rows that do not follow from others.
  Eigen::VectorXd solve(const Eigen::VectorXd& r) const;

 private:
  // H = I - 2 v v^T / |v|^2; entries of v, the pivot first.
  struct Reflection {
    std::vector<int> columns;
    std::vector<double> v;
    double length = 0, scale = 0;  // |v| and 2 / |v|^2
    template <typename Vector>
    double along(const Vector& x) const {
      double sum = 0;
      for (std::size_t i = 0; i < columns.size(); ++i) sum += v[i] * x[columns[i]];
      return sum * scale;
    }
  };
  // A row that does not follow from others: its entries in terms of the reflected directions, the last one its own.
  struct Independent {
    int row;
    std::vector<std::pair<int, double>> entries;
  };
  Eigen::Index columns_;
  double zero_, smallest_part_ = 1;
  std::vector<Reflection> reflections_;  // of each independent row
  std::vector<Independent> independent_;
  std::vector<Dependence> dependences_;  // with the rows in terms of reflected directions for weights
};

}  // namespace sigmafmu
