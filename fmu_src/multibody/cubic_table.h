// A function of time through given points: the natural cubic spline, which goes on along straight lines beyond its ends
// and so has continuous second derivatives everywhere; or its first or second integral from t = 0 on.
#pragma once

#include <vector>

namespace sigmafmu {

class CubicTable {
 public:
  struct Value {
    double x, xdot, xddot;
  };

  CubicTable() = default;  // zero
  // Times ascend; at least two.
  CubicTable(const std::vector<double>& t, const std::vector<double>& x, int integrals);
  Value operator()(double t) const;

 private:
  // a + b s + c s^2 + d s^3, s = t - start, and its integrals from t = 0 to the start: the first and, of what the first
  // one is, the second.
  struct Piece {
    double start, a, b, c, d, first, second;
  };
  const Piece& piece(double t) const;
  Value value(const Piece& piece, double t) const;

  std::vector<Piece> pieces_;  // the first and the last one are the lines beyond the ends
  int integrals_ = 0;
};

}  // namespace sigmafmu
