#include "multibody/cubic_table.h"

#include <algorithm>
#include <cstddef>

namespace sigmafmu {
namespace {

// Second derivatives of the natural spline at its points, by elimination without pivots in the dominant tridiagonal
// matrix of the continuity of first derivatives.
std::vector<double> curvatures(const std::vector<double>& t, const std::vector<double>& x) {
  const std::size_t n = t.size();
  std::vector<double> m(n, 0.0), upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h0 = t[i] - t[i - 1], h1 = t[i + 1] - t[i];
    const double right = 6 * ((x[i + 1] - x[i]) / h1 - (x[i] - x[i - 1]) / h0);
    const double diagonal = 2 * (h0 + h1) - h0 * upper[i - 1];
    upper[i] = h1 / diagonal;
    m[i] = (right - h0 * m[i - 1]) / diagonal;
  }
  for (std::size_t i = n - 1; i-- > 1;) m[i] -= upper[i] * m[i + 1];
  return m;
}

}  // namespace

CubicTable::CubicTable(const std::vector<double>& t, const std::vector<double>& x, int integrals)
    : integrals_(integrals) {
  const std::vector<double> m = curvatures(t, x);
  const std::size_t last = t.size() - 1;
  for (std::size_t i = 0; i < last; ++i) {
    const double h = t[i + 1] - t[i];
    pieces_.push_back({t[i], x[i], (x[i + 1] - x[i]) / h - h * (2 * m[i] + m[i + 1]) / 6, m[i] / 2,
                       (m[i + 1] - m[i]) / (6 * h), 0, 0});
  }
  const Piece end = pieces_.back();
  const double h = t[last] - t[last - 1];
  pieces_.push_back({t[last], x[last], end.b + h * (2 * end.c + 3 * h * end.d), 0, 0, 0, 0});
  pieces_.insert(pieces_.begin(), {t[0], x[0], pieces_.front().b, 0, 0, 0, 0});
  // Integrals from the first point on, then from t = 0 on.
  for (std::size_t i = 2; i < pieces_.size(); ++i) {
    const Piece& before = pieces_[i - 1];
    const double s = pieces_[i].start - before.start;
    pieces_[i].first = before.first + s * (before.a + s * (before.b / 2 + s * (before.c / 3 + s * before.d / 4)));
    pieces_[i].second =
        before.second +
        s * (before.first + s * (before.a / 2 + s * (before.b / 6 + s * (before.c / 12 + s * before.d / 20))));
  }
  integrals_ = 2;
  const Value zero = value(piece(0.0), 0.0);
  integrals_ = integrals;
  for (Piece& p : pieces_) {
    p.second -= zero.x + zero.xdot * p.start;
    p.first -= zero.xdot;
  }
}

const CubicTable::Piece& CubicTable::piece(double t) const {
  const auto later = [](double time, const Piece& p) { return time < p.start; };
  const auto found = std::upper_bound(pieces_.begin() + 1, pieces_.end(), t, later);
  return *(found - 1);
}

CubicTable::Value CubicTable::operator()(double t) const {
  if (pieces_.empty()) return {0, 0, 0};
  return value(piece(t), t);
}

CubicTable::Value CubicTable::value(const Piece& p, double t) const {
  const auto& [start, a, b, c, d, first, second] = p;
  const double s = t - start;
  const double x = a + s * (b + s * (c + s * d)), slope = b + s * (2 * c + 3 * s * d);
  if (integrals_ == 0) return {x, slope, 2 * c + 6 * s * d};
  const double integral = first + s * (a + s * (b / 2 + s * (c / 3 + s * d / 4)));
  if (integrals_ == 1) return {integral, x, slope};
  return {second + s * (first + s * (a / 2 + s * (b / 6 + s * (c / 12 + s * d / 20)))), integral, x};
}

}  // namespace sigmafmu
