#include "multibody/forces/tendon.h"

namespace sigmafmu {

const std::vector<ForcePort>& Tendon::ports() const {
  static const std::vector<ForcePort> table = {
      {"length", 0, "Displacement", "Sum of the joints' coordinates, each times its coefficient",
       [](const Force& f, const Kinematics& k, const Inputs& u, double* x) {
         *x = static_cast<const Tendon&>(f).length(k, u);
       }},
      {"rate", 0, "Velocity", "Rate of the length",
       [](const Force& f, const Kinematics& k, const Inputs&, double* x) {
         *x = static_cast<const Tendon&>(f).rate(k);
       }},
      {"force", 0, "Force", "Tension, positive where it pulls the length together",
       [](const Force& f, const Kinematics& k, const Inputs& u, double* x) {
         *x = static_cast<const Tendon&>(f).tension(k, u);
       }},
      {"energy", 0, "Energy", "Elastic energy of the tendon", energy_output},
      {"power", 0, "Power", "Power of the tendon on the bodies, its actuator included", power_output, true},
      {"actuatorForce", 0, "Force", "Tension that is added", nullptr},
  };
  return table;
}

void Tendon::set_values(const MultibodyDef& definition) {
  const TendonDef& d = definition.tendons[index_];
  stiffness_ = d.stiffness;
  damping_ = d.damping;
  free_length_ = d.free_length;
  for (std::size_t i = 0; i < terms_.size(); ++i) terms_[i].coefficient = d.terms[i].coefficient;
}

double Tendon::length(const Kinematics& k, const Inputs& u) const {
  double sum = 0;
  for (int i = 0; i < static_cast<int>(terms_.size()); ++i) {
    const Term& term = terms_[i];
    sum += term.coefficient * term.coordinate.value_near(k.from(2 * i), u.turned[term.index]);
  }
  return sum;
}

double Tendon::rate(const Kinematics& k) const {
  double sum = 0;
  for (int i = 0; i < static_cast<int>(terms_.size()); ++i) {
    sum += terms_[i].coefficient * terms_[i].coordinate.rate(k.from(2 * i));
  }
  return sum;
}

double Tendon::tension(const Kinematics& k, const Inputs& u) const {
  return stiffness_ * (length(k, u) - free_length_) + damping_ * rate(k) + *own(u);
}

double Tendon::energy(const Kinematics& k, const Inputs& u) const {
  const double x = length(k, u) - free_length_;
  return 0.5 * stiffness_ * x * x;
}

Stiffest Tendon::stiffest() const {
  Stiffest sum;
  for (const Term& term : terms_) {
    const double stiffness = term.coefficient * term.coefficient * stiffness_;
    (term.coordinate.is_angle() ? sum.rotation : sum.translation) += stiffness;
  }
  return sum;
}

void Tendon::add(const Kinematics& k, const Inputs& u, const FrameForces& r) const {
  const double N = tension(k, u);
  if (N == 0.0) return;
  for (int i = 0; i < static_cast<int>(terms_.size()); ++i) {
    terms_[i].coordinate.add_force(k.from(2 * i), -terms_[i].coefficient * N, r.from(2 * i));
  }
}

void Tendon::linearize(const Kinematics& k, const Inputs& u, const FramePairs& K, const FramePairs& C) const {
  const double N = tension(k, u);
  const int terms = static_cast<int>(terms_.size());
  double b_i[12], b_j[12], z_j[12];
  const FrameRows B_i(b_i, 1), B_j(b_j, 1), Z_j(z_j, 1);
  for (int i = 0; i < terms; ++i) {
    const JointCoordinate& row = terms_[i].coordinate;
    row.gradient(k.from(2 * i), B_i);
    for (int j = 0; j < terms; ++j) {
      const JointCoordinate& column = terms_[j].coordinate;
      column.gradient(k.from(2 * j), B_j);
      column.rates(k.from(2 * j), Z_j);
      const double c = terms_[i].coefficient * terms_[j].coefficient;
      for (int one = 0; one < 2; ++one) {
        for (int two = 0; two < 2; ++two) {
          if (!K.has(2 * i + one, 2 * j + two)) continue;
          const Vector6d of_j = c * (stiffness_ * B_j[two] + damping_ * Z_j[two]).transpose();
          K(2 * i + one, 2 * j + two).noalias() += B_i[one].transpose() * of_j.transpose();
          C(2 * i + one, 2 * j + two).noalias() += (c * damping_ * B_i[one].transpose()) * B_j[two];
        }
      }
    }
    row.stiffness(k.from(2 * i), -terms_[i].coefficient * N, K.from(2 * i));
  }
}

}  // namespace sigmafmu
