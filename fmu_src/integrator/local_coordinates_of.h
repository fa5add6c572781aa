// The implementation of local_coordinates.h for one group and any of its coordinates; a file for each group includes
// it, since compiling both together takes too much memory.
#pragma once

#include "integrator/local_coordinates.h"
#include "lie/lgt.h"
#include "model/dense.h"

namespace sigmafmu {
namespace {

using lie::Pose;
using lie::Quaterniond;

Pose pose(const VectorXd& q, int body) {
  const double* p = q.data() + kPositionsPerBody * body;
  return {{p[0], p[1], p[2]}, {p[3], p[4], p[5], p[6]}};
}

void write(const Pose& pose, VectorXd& q, int body) {
  double* p = q.data() + kPositionsPerBody * body;
  p[0] = pose.p.x(), p[1] = pose.p.y(), p[2] = pose.p.z();
  p[3] = pose.quat.w(), p[4] = pose.quat.x(), p[5] = pose.quat.y(), p[6] = pose.quat.z();
}

Vector6d of_body(const VectorXd& x, int body) { return x.segment<6>(kVelocitiesPerBody * body); }

// All but the absolute coordinates.
template <class Group>
class LocalCoordinatesOf : public LocalCoordinates {
  using Part = typename Group::Coupled;  // what follows acts on the last N entries of a body; T = I for the others
  static constexpr int N = Part::kSize;
  static constexpr bool kMixed = N == 3;
  using PartVector = Eigen::Matrix<double, N, 1>;
  using PartMatrix = Eigen::Matrix<double, N, N>;

  static auto part(VectorXd& x, int body) { return x.segment<N>(kVelocitiesPerBody * (body + 1) - N); }
  static PartVector part(const VectorXd& x, int body) { return x.segment<N>(kVelocitiesPerBody * (body + 1) - N); }

  SIGMAFMU_NOINLINE static PartMatrix P_inverse(double sigma, const PartVector& theta) {
    const PartMatrix P = sigma * PartMatrix::Identity() + (1 - sigma) * Part::tangent(theta);
    return inverse(P);
  }

 public:
  explicit LocalCoordinatesOf(const System& system)
      : bodies_(system.body_count()), modes_(system.modal_count()), tangents_(bodies_) {}

  bool mixed() const override { return kMixed; }

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
    if (&v != &V) v = V;
    if (&vdot != &Vdot) vdot = Vdot;
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

  SIGMAFMU_FLATTEN void velocities(const VelocityRule& rule, const VectorXd& theta, const VectorXd& c,
                                   const VectorXd* b, VectorXd& V) const override {
    for (int i = 0; i < bodies_; ++i) {
      const Vector6d X = of_body(theta, i);
      const PartVector x = X.template tail<N>();
      Vector6d w = X - of_body(c, i);
      if (rule.transported) w.template tail<N>() = Part::tangent_times(x, x - part(c, i));
      if (b) w += of_body(*b, i);
      if (rule.sigma[i] != 1.0) w.template tail<N>() = (P_inverse(rule.sigma[i], x) * w.template tail<N>()).eval();
      V.segment<6>(kVelocitiesPerBody * i) = rule.gamma_prime * w;
    }
    if (modes_ == 0) return;
    V.tail(modes_) = rule.gamma_prime * (theta.tail(modes_) - c.tail(modes_));
    if (b) V.tail(modes_) += rule.gamma_prime * b->tail(modes_);
  }

  SIGMAFMU_FLATTEN void modify(const VelocityRule& rule, const VectorXd& V, VectorXd& theta) const override {
    for (int i = 0; i < bodies_; ++i) {
      part(theta, i) +=
          rule.sigma[i] / rule.gamma_prime * (Part::tangent_inverse_times(part(theta, i), part(V, i)) - part(V, i));
    }
  }

  void modify_as_printed(const VelocityRule& rule, const VectorXd& V, VectorXd& theta) const override {
    for (int i = 0; i < bodies_; ++i) {
      part(theta, i) -= rule.sigma[i] / rule.gamma_prime * Part::commutator(part(V, i), part(theta, i));
    }
  }

  void solve_P(const VelocityRule& rule, const VectorXd& theta, VectorXd& dV) const override {
    for (int i = 0; i < bodies_; ++i) {
      if (rule.sigma[i] != 1.0) part(dV, i) = (P_inverse(rule.sigma[i], part(theta, i)) * part(dV, i)).eval();
    }
  }

  bool factorize(NewtonMatrix& matrix, const Evaluation& e, const Evaluation& start, const StepScales& step,
                 const VelocityRule& rule, const Iterate& at, Derivative derivative, Factorization& f) override {
    tangents_.identity_P = kMixed;
    for (int i = 0; i < bodies_; ++i) tangents_.identity_P = tangents_.identity_P && rule.sigma[i] == 1.0;
    const bool identity = derivative == Derivative::none || (derivative == Derivative::printed && tangents_.identity_P);
    if (!kMixed || !identity) {
      for (int i = 0; i < bodies_; ++i) linearize(step, rule, at, derivative, i);
    }
    return matrix.factorize(e, start, step, tangents_, f);
  }

 protected:
  int bodies_, modes_;

 private:
  // dV = gamma' P^-1 d(T(theta) (theta - c) - P V/gamma') of one body, the last V held fixed; theta - c without T in
  // front where c is not transported. With canonical coordinates T(theta) theta = theta.
  SIGMAFMU_FLATTEN void linearize(const StepScales& step, const VelocityRule& rule, const Iterate& at,
                                  Derivative derivative, int i) {
    const PartVector theta = part(at.theta, i);
    const double sigma = rule.sigma[i];
    const bool identity_P = sigma == 1.0 || derivative == Derivative::none;
    tangents_.P_inverse[i].setIdentity();
    if (!identity_P) tangents_.P_inverse[i] = P_inverse(sigma, theta);
    PartMatrix G = PartMatrix::Identity();
    if (derivative == Derivative::exact) {
      PartVector w = (sigma - 1) / rule.gamma_prime * part(at.V, i);
      if (rule.transported) w -= part(at.c, i);
      if (rule.transported && !Group::Coordinates::kCanonical) {
        w += theta;
        G = Part::tangent(theta);
      }
      G = (G + Part::tangent_derivative(theta, w)) * Part::tangent_inverse(theta);
    }
    if (!identity_P) G = (tangents_.P_inverse[i] * G).eval();
    if constexpr (kMixed) {
      tangents_.U[i] = G;
    } else {
      turn(step, at, i, G);
    }
  }

  // From the body twist V = (R^T v_WB, w) to mixed velocities, A = diag(R, I): dv = A dV + R (dphi x V_t), and with
  // d(v_WB)/dt = R s, s = Vdot_t + w x V_t:  d(vdot_WB) = R (dVdot_t + dw x V_t + w x dV_t) + R (dphi x s).
  void turn(const StepScales& step, const Iterate& at, int i, const PartMatrix& G) {
    const Matrix3d R = pose(at.q, i).quat.toRotationMatrix(), R_n = pose(at.q_n, i).quat.toRotationMatrix();
    const Vector6d V = of_body(at.V, i);
    const Vector3d V_t = V.head<3>(), w = V.tail<3>();
    const Vector3d s = Vector3d(at.Vdot.segment<3>(kVelocitiesPerBody * i)) + w.cross(V_t);
    Matrix6d& U = tangents_.U[i];
    U = G;
    U.template leftCols<3>() *= R.transpose();
    auto& E = tangents_.E[i];
    E = step.gamma_prime / step.beta_prime * R *
        (lie::hat(w) * U.template topRows<3>() - lie::hat(V_t) * U.template bottomRows<3>());
    U.template topRows<3>() = (R * U.template topRows<3>()).eval();
    const Matrix3d turned = R * lie::hat(V_t) / step.gamma_prime;
    U.template topRightCorner<3, 3>() -= turned;
    E.template rightCols<3>() += turned - R * lie::hat(s) / step.beta_prime;
    Matrix6d& P_inverse = tangents_.P_inverse[i];
    P_inverse.template leftCols<3>() *= R_n.transpose();
    tangents_.F[i] =
        step.gamma_prime / step.beta_prime * R *
        (lie::hat(w) * P_inverse.template topRows<3>() - lie::hat(V_t) * P_inverse.template bottomRows<3>());
    P_inverse.template topRows<3>() = (R * P_inverse.template topRows<3>()).eval();
  }

  BodyTangents<N> tangents_;
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
