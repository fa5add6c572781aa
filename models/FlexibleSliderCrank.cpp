// The spatial slider-crank (SliderCrank.cpp) with a flexible connecting rod: floating frame of reference with modal
// coordinates. Five degrees of freedom, 17 joint equations.
#include <cmath>

#include "mechanism.h"

namespace sigmafmu::models {

Mechanism FlexibleSliderCrank() {
  Mechanism m;
  m.name = "FlexibleSliderCrank";
  m.description = "Spatial slider-crank with a connecting rod that bends in two planes, under gravity";
  m.stop_time = 2.0;
  m.communication_step = 1e-3;
  m.integrator.step_size = 1e-4;
  m.multibody.gravity = {0, 0, -9.81};

  const Vector3d ground_pivot(0, 0.1, 0.12);           // A
  const double crank_length = 0.08, rod_length = 0.3;  // AB, BC

  RigidBodyDef crank;  // z along the crank from A to B
  crank.name = "crank";
  crank.description = "crank";
  crank.mass = 0.12;
  crank.inertia = {1e-4, 1e-4, 1e-5};
  crank.initial_position = {0, 0.1, 0.16};
  crank.initial_velocity = {0, -0.24, 0};
  crank.initial_angular_velocity = {6, 0, 0};
  const int crank_index = m.multibody.add(crank);

  RigidBodyDef rod;  // its frame in B, x towards C; both ends stay on its x axis
  rod.name = "rod";
  rod.description = "flexible connecting rod";
  rod.initial_position = {0, 0.1, 0.2};
  Matrix3d R;
  R.col(0) = Vector3d(2, -1, -2) / 3;
  R.col(1) = Vector3d(0, 2, -1) / std::sqrt(5.0);
  R.col(2) = Vector3d(5, 2, 4) / (3 * std::sqrt(5.0));
  // quaternion of R: trace(R) > 0 here
  const double w = 0.5 * std::sqrt(1 + R.trace());
  rod.initial_quaternion = {w, (R(2, 1) - R(1, 2)) / (4 * w), (R(0, 2) - R(2, 0)) / (4 * w),
                            (R(1, 0) - R(0, 1)) / (4 * w)};
  rod.initial_velocity = {0, -0.48, 0};
  rod.initial_angular_velocity = R.transpose() * Vector3d(1.92, -0.96, 0.48);
  const int rod_index = m.multibody.add(rod);
  m.modal_files.push_back({rod_index, "rod.json", 4});

  RigidBodyDef slider;
  slider.name = "slider";
  slider.description = "slider on the x axis of W";
  slider.mass = 2.0;
  slider.inertia = {1e-4, 1e-4, 1e-4};
  slider.initial_position = {0.2, 0, 0};
  slider.initial_velocity = {0.24, 0, 0};
  const int slider_index = m.multibody.add(slider);

  const Matrix3d z_along_x = axes_with_z(Vector3d::UnitX());
  m.multibody.add(JointDef{"crankPivot",
                           JointType::revolute,
                           kGround,
                           {ground_pivot, z_along_x},
                           crank_index,
                           {{0, 0, -crank_length / 2}, z_along_x}});
  m.multibody.add(JointDef{"crankPin", JointType::spherical, crank_index, {{0, 0, crank_length / 2}}, rod_index, {}});
  m.multibody.add(JointDef{"wristPin", JointType::universal, rod_index, {{rod_length, 0, 0}}, slider_index, {}});
  m.multibody.add(
      JointDef{"guide", JointType::prismatic, kGround, {{0, 0, 0}, z_along_x}, slider_index, {{0, 0, 0}, z_along_x}});

  // sections of four nodes, 0.03 m apart
  const auto section = [](int k) { return std::vector<int>{4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3}; };
  for (int k : {1, 2, 3, 4}) {
    m.stations.push_back({"rod.station" + std::to_string(k), "point of the centre line", rod_index, section(2 * k)});
  }
  m.stations.push_back({"middle",
                        "middle of the rod",
                        rod_index,
                        section(5),
                        {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()}});
  return m;
}

}  // namespace sigmafmu::models
