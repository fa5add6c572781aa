// The piecewise cubic through points (x_i, y_i) that is monotone wherever they are, and continuous with its slope:
// Fritsch and Butland's slopes d_i, SIAM J. Sci. Stat. Comput. 5 (1984) 300, as PCHIP takes them. Inside, with the
// widths h_i and the secants s_i = (y_(i+1) - y_i) / h_i, d_i is zero where s_(i-1) s_i <= 0 and else
//
//   d_i = (w_1 + w_2) / (w_1 / s_(i-1) + w_2 / s_i),   w_1 = 2 h_i + h_(i-1),   w_2 = h_i + 2 h_(i-1);
//
// at the ends it is the slope of the parabola through three points, limited so that the curve stays monotone. Straight
// lines go on from the ends.
#pragma once

#include <vector>

namespace sigmafmu {

class MonotoneCubic {
 public:
  struct Value {
    double y, slope;
    double integral;  // from x_0
  };

  // Zero everywhere.
  MonotoneCubic() = default;
  // At least two points, x increasing.
  MonotoneCubic(const std::vector<double>& x, const std::vector<double>& y);

  Value operator()(double x) const;
  double steepest() const;  // of the slopes at the points

 private:
  struct Knot {
    double x, y, slope, integral;
  };
  std::vector<Knot> knots_;
};

}  // namespace sigmafmu
