// The implementation of local_coordinates.h for one group and any of its coordinates; a file for each group includes
// it, since compiling both together takes too much memory.
#pragma once

#include "integrator/coordinates/local_coordinates.h"
#include "integrator/coordinates/tangents_of.h"
#include "lie/lgt.h"

namespace sigmafmu {
namespace {

using lie::Quaterniond;

void write(const Pose& pose, VectorXd& q, int body) {
  double* p = q.data() + kPositionsPerBody * body;
  p[0] = pose.p.x(), p[1] = pose.p.y(), p[2] = pose.p.z();
  p[3] = pose.quat.w(), p[4] = pose.quat.x(), p[5] = pose.quat.y(), p[6] = pose.quat.z();
}

// All but the absolute coordinates.
template <class Group>
class LocalCoordinatesOf : public LocalCoordinates {
  using Part = typename Group::Coupled;  // what follows acts on the last N entries of a body; T = I for the others
  static constexpr int N = Part::kSize;
  static constexpr bool kMixed = N == 3;
  using PartVector = Eigen::Matrix<double, N, 1>;
  using PartMatrix = Eigen::Matrix<double, N, N>;

  static auto part(VectorXd& x, int body) { return part_of<N>(x, body); }
  static PartVector part(const VectorXd& x, int body) { return part_of<N>(x, body); }

 public:
  explicit LocalCoordinatesOf(const System& system)
      : LocalCoordinates(kMixed), bodies_(system.body_count()), modes_(system.modal_count()) {}

  void to_group(const VectorXd& q, const VectorXd& v, const VectorXd& vdot, VectorXd& V,
                VectorXd& Vdot) const override {
    V = v;
    Vdot = vdot;
    if constexpr (!kMixed) {
      for (int i = 0; i < bodies_; ++i) {
        const Quaterniond quat = pose(q, i).quat;
        part(V, i) = Group::velocity(quat, of_body(v, i));
        part(Vdot, i) = Group::acceleration(quat, of_body(v, i), of_body(vdot, i));
      }
    }
  }

  void to_mixed(const VectorXd& q, const VectorXd& V, const VectorXd& Vdot, VectorXd& v,
                VectorXd& vdot) const override {
    v = V;
    vdot = Vdot;
    if constexpr (!kMixed) {
      for (int i = 0; i < bodies_; ++i) {
        const Quaterniond quat = pose(q, i).quat;
        part(v, i) = Group::mixed_velocity(quat, of_body(V, i));
        part(vdot, i) = Group::mixed_acceleration(quat, of_body(V, i), of_body(Vdot, i));
      }
    }
  }

  void turn_to_group(const VectorXd& q, VectorXd& x) const override {
    if constexpr (!kMixed) {
      for (int i = 0; i < bodies_; ++i) part(x, i) = Group::velocity(pose(q, i).quat, of_body(x, i));
    }
  }

  void jerk_to_group(const VectorXd& q, const VectorXd& v, const VectorXd& vdot, VectorXd& jerk) const override {
    if constexpr (!kMixed) {
      for (int i = 0; i < bodies_; ++i) {
        part(jerk, i) = Group::jerk(pose(q, i).quat, of_body(v, i), of_body(vdot, i), of_body(jerk, i));
      }
    }
  }

  double largest_rotation(const VectorXd& theta, int& body) const override {
    double largest = 0;
    for (int i = 0; i < bodies_; ++i) {
      const double angle = Group::Coordinates::angle(theta.segment<3>(kVelocitiesPerBody * i + 3).norm());
      if (angle <= largest) continue;
      largest = angle;
      body = i;
    }
    return largest;
  }

  SIGMAFMU_FLATTEN void rate(const VectorXd& theta, const VectorXd& V, VectorXd& thetadot) const override {
    thetadot = V;
    for (int i = 0; i < bodies_; ++i) part(thetadot, i) = Part::tangent_inverse_times(part(theta, i), part(V, i));
  }

  SIGMAFMU_FLATTEN void add_motion(const VectorXd& q, const VectorXd& dq, VectorXd& theta) const override {
    for (int i = 0; i < bodies_; ++i) {
      if constexpr (kMixed) {
        const int at = kVelocitiesPerBody * i;
        theta.segment<3>(at) += dq.segment<3>(at);
        part(theta, i) += Part::tangent_inverse_times(part(theta, i), part(dq, i));
      } else {
        part(theta, i) += Part::tangent_inverse_times(part(theta, i), Group::velocity(pose(q, i).quat, of_body(dq, i)));
      }
    }
    if (modes_ > 0) theta.tail(modes_) += dq.segment(kVelocitiesPerBody * bodies_, modes_);
  }

  SIGMAFMU_FLATTEN void velocities(const StepEquations& e, const VectorXd& theta, const VectorXd* b,
                                   VectorXd& V) const override {
    const double gamma_prime = e.scales.gamma_prime;
    for (int i = 0; i < bodies_; ++i) {
      const Vector6d X = of_body(theta, i);
      const PartVector x = X.template tail<N>();
      Vector6d w = X - of_body(e.c, i);
      if (e.transported) w.template tail<N>() = Part::tangent_times(x, x - part(e.c, i));
      if (b) w += of_body(*b, i);
      if (e.sigma[i] != 1.0) {
        w.template tail<N>() = (P_inverse<Part>(e.sigma[i], x) * w.template tail<N>()).eval();
      }
      V.segment<6>(kVelocitiesPerBody * i) = gamma_prime * w;
    }
    if (modes_ == 0) return;
    V.tail(modes_) = gamma_prime * (theta.tail(modes_) - e.c.tail(modes_));
    if (b) V.tail(modes_) += gamma_prime * b->tail(modes_);
  }

  SIGMAFMU_FLATTEN void modify(const StepEquations& e, const VectorXd& V, VectorXd& theta) const override {
    for (int i = 0; i < bodies_; ++i) {
      part(theta, i) +=
          e.sigma[i] / e.scales.gamma_prime * (Part::tangent_inverse_times(part(theta, i), part(V, i)) - part(V, i));
    }
  }

  // dV = gamma' P^-1 d(T(theta) (theta - c) - P V/gamma') of a body, the last V held fixed; theta - c without T in
  // front where c is not transported. With canonical coordinates T(theta) theta = theta.
  SIGMAFMU_FLATTEN void tangents(const StepEquations& e, const VectorXd& q_n, const Iterate& at, bool exact,
                                 BodyTangents& out) const override {
    begin_tangents<Part>(e, out);
    for (int i = 0; i < bodies_; ++i) {
      const PartVector theta = part(at.theta, i);
      const double sigma = e.sigma[i];
      PartMatrix P_inv = PartMatrix::Identity(), G = P_inv;
      if (exact) {
        PartVector w = (sigma - 1) / e.scales.gamma_prime * part(at.V, i);
        if (e.transported) w -= part(e.c, i);
        if (e.transported && !Group::Coordinates::kCanonical) {
          w += theta;
          G = Part::tangent(theta);
        }
        G = (G + Part::tangent_derivative(theta, w)) * Part::tangent_inverse(theta);
        if (sigma != 1.0) {
          P_inv = P_inverse<Part>(sigma, theta);
          G = (P_inv * G).eval();
        }
      }
      store_tangents<Part>(e.scales, q_n, at, i, G, P_inv, out);
    }
  }

 protected:
  int bodies_, modes_;
};

template <class Absolute, class Group>
class AbsoluteCoordinatesOf final : public LocalCoordinatesOf<Group> {
  using LocalCoordinatesOf<Group>::bodies_;
  using LocalCoordinatesOf<Group>::modes_;

  // The pose that the absolute coordinates of a pose stand for: the same up to rounding.
  static Pose represented(const Pose& pose) {
    if constexpr (std::is_same_v<Absolute, lie::QuaternionPosition>) return pose;
    return Absolute::pose(Absolute::coordinates(pose));
  }

 public:
  using LocalCoordinatesOf<Group>::LocalCoordinatesOf;

  SIGMAFMU_FLATTEN void compose(const VectorXd& q_n, const VectorXd& theta, VectorXd& q) const override {
    for (int i = 0; i < bodies_; ++i) {
      write(represented(Group::product(pose(q_n, i), Group::psi(of_body(theta, i)))), q, i);
    }
    if (modes_ > 0) q.tail(modes_) = q_n.tail(modes_) + theta.segment(kVelocitiesPerBody * bodies_, modes_);
  }

  void store(const VectorXd& q, VectorXd& stored) const override {
    if constexpr (std::is_same_v<Absolute, lie::QuaternionPosition>) {
      stored = q;
    } else {
      for (int i = 0; i < bodies_; ++i) {
        const Pose now = represented(pose(q, i));
        write({now.p, lie::nearest(now.quat, pose(stored, i).quat)}, stored, i);
      }
      stored.tail(modes_) = q.tail(modes_);
    }
  }
};

template <class Absolute, template <class> class Group>
std::unique_ptr<LocalCoordinates> with_map(const System& system, const IntegratorSettings& s) {
  if (s.is(CoordinateMap::cayley)) return std::make_unique<AbsoluteCoordinatesOf<Absolute, Group<lie::Cayley>>>(system);
  if (s.is(CoordinateMap::cayley2)) {
    return std::make_unique<AbsoluteCoordinatesOf<Absolute, Group<lie::Cayley2>>>(system);
  }
  return std::make_unique<AbsoluteCoordinatesOf<Absolute, Group<lie::Exponential>>>(system);
}

template <template <class> class Group>
std::unique_ptr<LocalCoordinates> on_group(const System& system, const IntegratorSettings& s) {
  if (s.is(AbsoluteCoordinates::rotation_vector)) return with_map<lie::RotationVectorPosition, Group>(system, s);
  return with_map<lie::QuaternionPosition, Group>(system, s);
}

}  // namespace
}  // namespace sigmafmu
