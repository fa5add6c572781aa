#include "multibody/constraints/coupling.h"

namespace sigmafmu {

Coupling::Coupling(std::vector<Term> terms, int index) : terms_(std::move(terms)), index_(index) {
  equations_ = 1;
  for (const Term& term : terms_) {
    if (!term.coordinate.is_angle()) length_equations_ = 1;
    couples_frames_ = couples_frames_ || term.coordinate.couples_frames() || term.polynomial.size() > 2;
  }
}

// Horner's rule for p, p' and p''/2.
Coupling::Value Coupling::value(const std::vector<double>& polynomial, double x) {
  double p = 0, slope = 0, half = 0;
  for (auto c = polynomial.rbegin(); c != polynomial.rend(); ++c) {
    half = half * x + slope;
    slope = slope * x + p;
    p = p * x + *c;
  }
  return {p, slope, 2 * half};
}

Coupling::Value Coupling::value(const Inputs& u, const Kinematics& k, int i) const {
  const Term& term = terms_[i];
  return value(term.polynomial, term.coordinate.value_near(k.from(2 * i), u.turned[term.index]));
}

double Coupling::slope(const Inputs& u, const Kinematics& k, int i) const { return value(u, k, i).slope; }

void Coupling::evaluate(const Inputs& u, const Kinematics& k, double* phi, double* phidot, const FrameRows& B) const {
  *phi = -u.x[index_];
  *phidot = 0;
  for (int i = 0; i < static_cast<int>(terms_.size()); ++i) {
    const Value at = value(u, k, i);
    *phi += at.p;
    *phidot += at.slope * terms_[i].coordinate.rate(k.from(2 * i));
    const FrameRows B_i = B.from(2 * i);
    terms_[i].coordinate.gradient(k.from(2 * i), B_i);
    for (int side = 0; side < 2; ++side) B_i[side] *= at.slope;
  }
}

void Coupling::rates(const Inputs& u, const Kinematics& k, const FrameRows& Z, double*) const {
  double b[12];
  const FrameRows B(b, 1);
  for (int i = 0; i < static_cast<int>(terms_.size()); ++i) {
    const JointCoordinate& coordinate = terms_[i].coordinate;
    const Kinematics k_i = k.from(2 * i);
    const Value at = value(u, k, i);
    const FrameRows Z_i = Z.from(2 * i);
    coordinate.rates(k_i, Z_i);
    coordinate.gradient(k_i, B);
    const double bend = at.curvature * coordinate.rate(k_i);
    for (int side = 0; side < 2; ++side) Z_i[side] = at.slope * Z_i[side] + bend * B[side];
  }
}

void Coupling::stiffness(const Inputs& u, const Kinematics& k, const double* lambda, const FramePairs& K) const {
  double b[12];
  const FrameRows B(b, 1);
  for (int i = 0; i < static_cast<int>(terms_.size()); ++i) {
    const Kinematics k_i = k.from(2 * i);
    const Value at = value(u, k, i);
    const FramePairs K_i = K.from(2 * i);
    terms_[i].coordinate.stiffness(k_i, -*lambda * at.slope, K_i);
    if (at.curvature == 0) continue;
    terms_[i].coordinate.gradient(k_i, B);
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < 2; ++column) {
        if (!K_i.has(row, column)) continue;
        K_i(row, column).noalias() += (*lambda * at.curvature * B[row].transpose()) * B[column];
      }
    }
  }
}

}  // namespace sigmafmu
