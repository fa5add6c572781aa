#include "multibody/forces/monotone_cubic.h"

#include <algorithm>
#include <cmath>

namespace sigmafmu {
namespace {

// At an end with the interval h, s and the next one, h2, s2.
double end_slope(double h, double s, double h2, double s2) {
  const double d = ((2 * h + h2) * s - h * s2) / (h + h2);
  if (d * s <= 0) return 0;
  return s * s2 <= 0 && std::abs(d) > 3 * std::abs(s) ? 3 * s : d;
}

}  // namespace

MonotoneCubic::MonotoneCubic(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t last = x.size() - 1;
  const auto width = [&](std::size_t i) { return x[i + 1] - x[i]; };
  const auto secant = [&](std::size_t i) { return (y[i + 1] - y[i]) / width(i); };
  for (std::size_t i = 0; i <= last; ++i) knots_.push_back({x[i], y[i], 0, 0});
  for (std::size_t i = 1; i < last; ++i) {
    const double before = secant(i - 1), after = secant(i);
    if (before * after <= 0) continue;
    const double w1 = 2 * width(i) + width(i - 1), w2 = width(i) + 2 * width(i - 1);
    knots_[i].slope = (w1 + w2) / (w1 / before + w2 / after);
  }
  if (last == 1) {
    knots_[0].slope = knots_[1].slope = secant(0);
  } else {
    knots_[0].slope = end_slope(width(0), secant(0), width(1), secant(1));
    knots_[last].slope = end_slope(width(last - 1), secant(last - 1), width(last - 2), secant(last - 2));
  }
  for (std::size_t i = 0; i < last; ++i) {
    const double h = width(i);
    knots_[i + 1].integral =
        knots_[i].integral + h * ((y[i] + y[i + 1]) / 2 + h * (knots_[i].slope - knots_[i + 1].slope) / 12);
  }
}

MonotoneCubic::Value MonotoneCubic::operator()(double x) const {
  if (knots_.empty()) return {0, 0, 0};
  const auto above = std::upper_bound(knots_.begin(), knots_.end(), x, [](double v, const Knot& k) { return v < k.x; });
  const Knot& a = above == knots_.begin() ? *above : *(above - 1);
  const double t = x - a.x;
  if (above == knots_.begin() || above == knots_.end()) {
    return {a.y + a.slope * t, a.slope, a.integral + t * (a.y + a.slope * t / 2)};
  }
  const Knot& b = *above;
  const double h = b.x - a.x, s = (b.y - a.y) / h;
  const double c2 = (3 * s - 2 * a.slope - b.slope) / h, c3 = (a.slope + b.slope - 2 * s) / (h * h);
  return {a.y + t * (a.slope + t * (c2 + t * c3)), a.slope + t * (2 * c2 + t * 3 * c3),
          a.integral + t * (a.y + t * (a.slope / 2 + t * (c2 / 3 + t * c3 / 4)))};
}

double MonotoneCubic::steepest() const {
  double steepest = 0;
  for (const Knot& k : knots_) steepest = std::max(steepest, std::abs(k.slope));
  return steepest;
}

}  // namespace sigmafmu
