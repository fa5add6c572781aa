// Definitions of forces and sensors in sigmafmu._core.
#include "elements.h"

#include <nanobind/eigen/dense.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <utility>

#include "model/sensor.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace sigmafmu;

namespace {

void bind_sensors(nb::module_& m) {
  nb::enum_<SensorType>(m, "SensorType").value("motion", SensorType::motion).value("imu", SensorType::imu);
  nb::enum_<SensorAxes>(m, "SensorAxes")
      .value("ground", SensorAxes::ground)
      .value("reference", SensorAxes::reference)
      .value("sensor", SensorAxes::sensor);
  nb::class_<SensorDef>(m, "Sensor", "Tells how a frame of a body moves.")
      .def(
          "__init__",
          [](SensorDef* s, std::string name, SensorType type, int body, const Frame& frame, int reference,
             const Frame& reference_frame, SensorAxes axes) {
            new (s) SensorDef{std::move(name), "", type, body, frame, reference, reference_frame, axes};
          },
          "name"_a, "type"_a, "body"_a, "frame"_a = Frame{}, "reference"_a = kGround, "reference_frame"_a = Frame{},
          "axes"_a = SensorAxes::reference)
      .def_ro("name", &SensorDef::name)
      .def_rw("description", &SensorDef::description)
      .def_ro("type", &SensorDef::type)
      .def_ro("body", &SensorDef::body)
      .def_ro("frame", &SensorDef::frame)
      .def_ro("reference", &SensorDef::reference)
      .def_ro("reference_frame", &SensorDef::reference_frame)
      .def_ro("axes", &SensorDef::axes);
}

TwoPoints two_points(std::string name, int body1, const Vector3d& point1, int body2, const Vector3d& point2, int node1,
                     int node2) {
  return {std::move(name), body1, point1, body2, point2, node1, node2};
}

// Members of what lies between two points or frames.
template <typename Def>
nb::class_<Def> between_points(nb::module_& m, const char* name, const char* doc) {
  return nb::class_<Def>(m, name, doc)
      .def_ro("name", &Def::name)
      .def_ro("body1", &Def::body1)
      .def_ro("point1", &Def::point1)
      .def_ro("node1", &Def::node1)
      .def_ro("body2", &Def::body2)
      .def_ro("point2", &Def::point2)
      .def_ro("node2", &Def::node2);
}
template <typename Def>
nb::class_<Def> between_frames(nb::module_& m, const char* name, const char* doc) {
  return nb::class_<Def>(m, name, doc)
      .def_ro("name", &Def::name)
      .def_ro("body1", &Def::body1)
      .def_ro("frame1", &Def::frame1)
      .def_ro("body2", &Def::body2)
      .def_ro("frame2", &Def::frame2);
}

void bind_springs(nb::module_& m) {
  between_points<LineSpringDef>(m, "LineSpring", "Tension k (L - L_0) + d L' between two points.")
      .def(
          "__init__",
          [](LineSpringDef* s, std::string name, int body1, const Vector3d& point1, int body2, const Vector3d& point2,
             double stiffness, double damping, double free_length, int node1, int node2) {
            new (s) LineSpringDef{two_points(std::move(name), body1, point1, body2, point2, node1, node2), stiffness,
                                  damping, free_length};
          },
          "name"_a, "body1"_a, "point1"_a, "body2"_a, "point2"_a, "stiffness"_a, "damping"_a = 0.0,
          "free_length"_a = 0.0, "node1"_a = kFloatingFrame, "node2"_a = kFloatingFrame)
      .def_rw("stiffness", &LineSpringDef::stiffness)
      .def_rw("damping", &LineSpringDef::damping)
      .def_rw("free_length", &LineSpringDef::free_length);
  using Table = std::vector<double>;
  between_points<TableSpringDef>(m, "TableSpring", "Tension by tables over length and rate between two points.")
      .def(
          "__init__",
          [](TableSpringDef* s, std::string name, int body1, const Vector3d& point1, int body2, const Vector3d& point2,
             Table length, Table force, Table rate, Table rate_force, int node1, int node2) {
            new (s) TableSpringDef{two_points(std::move(name), body1, point1, body2, point2, node1, node2),
                                   std::move(length), std::move(force), std::move(rate), std::move(rate_force)};
          },
          "name"_a, "body1"_a, "point1"_a, "body2"_a, "point2"_a, "length"_a = Table{}, "force"_a = Table{},
          "rate"_a = Table{}, "rate_force"_a = Table{}, "node1"_a = kFloatingFrame, "node2"_a = kFloatingFrame)
      .def_rw("length", &TableSpringDef::length)
      .def_rw("force", &TableSpringDef::force)
      .def_rw("rate", &TableSpringDef::rate)
      .def_rw("rate_force", &TableSpringDef::rate_force);
  between_frames<TorsionSpringDef>(m, "TorsionSpring", "Spring and damper about the z axes of two frames.")
      .def(
          "__init__",
          [](TorsionSpringDef* s, std::string name, int body1, const Frame& frame1, int body2, const Frame& frame2,
             double stiffness, double damping, double rest) {
            new (s) TorsionSpringDef{{std::move(name), body1, frame1, body2, frame2}, stiffness, damping, rest};
          },
          "name"_a, "body1"_a, "frame1"_a, "body2"_a, "frame2"_a, "stiffness"_a, "damping"_a = 0.0, "rest"_a = 0.0)
      .def_rw("stiffness", &TorsionSpringDef::stiffness)
      .def_rw("damping", &TorsionSpringDef::damping)
      .def_rw("rest", &TorsionSpringDef::rest);
  const Vector3d zero = Vector3d::Zero();
  between_frames<BushingDef>(m, "Bushing", "Spring and damper in all six directions between two frames.")
      .def(
          "__init__",
          [](BushingDef* s, std::string name, int body1, const Frame& frame1, int body2, const Frame& frame2,
             const Vector3d& stiffness, const Vector3d& damping, const Vector3d& torsional_stiffness,
             const Vector3d& torsional_damping) {
            new (s) BushingDef{{std::move(name), body1, frame1, body2, frame2},
                               stiffness,
                               damping,
                               torsional_stiffness,
                               torsional_damping};
          },
          "name"_a, "body1"_a, "frame1"_a, "body2"_a, "frame2"_a, "stiffness"_a, "damping"_a = zero,
          "torsional_stiffness"_a = zero, "torsional_damping"_a = zero)
      .def_rw("stiffness", &BushingDef::stiffness)
      .def_rw("damping", &BushingDef::damping)
      .def_rw("torsional_stiffness", &BushingDef::torsional_stiffness)
      .def_rw("torsional_damping", &BushingDef::torsional_damping)
      .def_rw("stiffness_coupling", &BushingDef::stiffness_coupling, "6 x 6, symmetric, zeros on the diagonal.")
      .def_rw("damping_coupling", &BushingDef::damping_coupling, "6 x 6, symmetric, zeros on the diagonal.");
}

void bind_bearing_and_drag(nb::module_& m) {
  const Vector3d zero = Vector3d::Zero();
  const Eigen::Vector2d none = Eigen::Vector2d::Zero();
  between_frames<BearingDef>(m, "Bearing", "Bearing or seal with cross-coupling, in the axes of the first frame.")
      .def(
          "__init__",
          [](BearingDef* b, std::string name, int body1, const Frame& frame1, int body2, const Frame& frame2,
             const Vector3d& stiffness, const Vector3d& damping, const Eigen::Vector2d& cross_stiffness,
             const Eigen::Vector2d& cross_damping) {
            new (b) BearingDef{
                {std::move(name), body1, frame1, body2, frame2}, stiffness, damping, cross_stiffness, cross_damping};
          },
          "name"_a, "body1"_a, "frame1"_a, "body2"_a, "frame2"_a, "stiffness"_a, "damping"_a = zero,
          "cross_stiffness"_a = none, "cross_damping"_a = none)
      .def_rw("stiffness", &BearingDef::stiffness)
      .def_rw("damping", &BearingDef::damping)
      .def_rw("cross_stiffness", &BearingDef::cross_stiffness, "(k_xy, k_yx)")
      .def_rw("cross_damping", &BearingDef::cross_damping, "(c_xy, c_yx)");
  nb::class_<DragDef>(m, "Drag", "Quadratic drag at a point of a body.")
      .def(
          "__init__",
          [](DragDef* d, std::string name, int body, const Vector3d& point, const Vector3d& coefficient,
             const Vector3d& rotational, const Vector3d& flow,
             int node) { new (d) DragDef{{std::move(name), body, point, node}, coefficient, rotational, flow}; },
          "name"_a, "body"_a, "point"_a, "coefficient"_a, "rotational"_a = zero, "flow"_a = zero,
          "node"_a = kFloatingFrame)
      .def_ro("name", &DragDef::name)
      .def_ro("body", &DragDef::body)
      .def_ro("point", &DragDef::point)
      .def_ro("node", &DragDef::node)
      .def_rw("coefficient", &DragDef::coefficient)
      .def_rw("rotational", &DragDef::rotational)
      .def_rw("flow", &DragDef::flow, "Velocity of the medium, in W.");
}

void bind_contacts(nb::module_& m) {
  nb::class_<ContactSurface>(m, "ContactSurface", "What surfaces that touch are made of.")
      .def(
          "__init__",
          [](ContactSurface* s, double modulus, double dissipation, double friction, double slip_velocity) {
            new (s) ContactSurface{modulus, dissipation, friction, slip_velocity};
          },
          "modulus"_a = ContactSurface{}.modulus, "dissipation"_a = 0.0, "friction"_a = 0.0,
          "slip_velocity"_a = ContactSurface{}.slip_velocity)
      .def_rw("modulus", &ContactSurface::modulus)
      .def_rw("dissipation", &ContactSurface::dissipation)
      .def_rw("friction", &ContactSurface::friction)
      .def_rw("slip_velocity", &ContactSurface::slip_velocity);
  nb::class_<PlaneContactDef>(m, "PlaneContact", "A sphere of body 2 on the plane z = 0 of a frame of body 1.")
      .def(
          "__init__",
          [](PlaneContactDef* c, std::string name, int body1, const Frame& frame1, int body2, const Vector3d& point2,
             double radius, const ContactSurface& surface, int node2) {
            new (c) PlaneContactDef{std::move(name), body1, frame1, body2, point2, radius, surface, node2};
          },
          "name"_a, "body1"_a, "frame1"_a, "body2"_a, "point2"_a, "radius"_a, "surface"_a, "node2"_a = kFloatingFrame)
      .def_ro("name", &PlaneContactDef::name)
      .def_ro("body1", &PlaneContactDef::body1)
      .def_ro("frame1", &PlaneContactDef::frame1)
      .def_ro("body2", &PlaneContactDef::body2)
      .def_ro("point2", &PlaneContactDef::point2)
      .def_ro("node2", &PlaneContactDef::node2)
      .def_rw("radius", &PlaneContactDef::radius)
      .def_rw("surface", &PlaneContactDef::surface);
  nb::class_<CloudContactDef>(m, "CloudContact", "Spheres about many points of body 2 on the plane z = 0 of body 1.")
      .def(
          "__init__",
          [](CloudContactDef* c, std::string name, int body1, const Frame& frame1, int body2,
             std::vector<Vector3d> points2, double radius, const ContactSurface& surface, int node2) {
            new (c) CloudContactDef{std::move(name), body1, frame1, body2, std::move(points2), radius, surface, node2};
          },
          "name"_a, "body1"_a, "frame1"_a, "body2"_a, "points2"_a, "radius"_a, "surface"_a, "node2"_a = kFloatingFrame)
      .def_ro("name", &CloudContactDef::name)
      .def_ro("body1", &CloudContactDef::body1)
      .def_ro("frame1", &CloudContactDef::frame1)
      .def_ro("body2", &CloudContactDef::body2)
      .def_ro("points2", &CloudContactDef::points2)
      .def_ro("node2", &CloudContactDef::node2)
      .def_rw("radius", &CloudContactDef::radius)
      .def_rw("surface", &CloudContactDef::surface);
  between_points<SphereContactDef>(m, "SphereContact", "Two spheres that touch.")
      .def(
          "__init__",
          [](SphereContactDef* c, std::string name, int body1, const Vector3d& point1, double radius1, int body2,
             const Vector3d& point2, double radius2, const ContactSurface& surface, int node1, int node2) {
            new (c) SphereContactDef{two_points(std::move(name), body1, point1, body2, point2, node1, node2), radius1,
                                     radius2, surface};
          },
          "name"_a, "body1"_a, "point1"_a, "radius1"_a, "body2"_a, "point2"_a, "radius2"_a, "surface"_a,
          "node1"_a = kFloatingFrame, "node2"_a = kFloatingFrame)
      .def_rw("radius1", &SphereContactDef::radius1)
      .def_rw("radius2", &SphereContactDef::radius2)
      .def_rw("surface", &SphereContactDef::surface);
}

void bind_tendon(nb::module_& m) {
  nb::class_<TendonDef::Term>(m, "TendonTerm")
      .def(
          "__init__",
          [](TendonDef::Term* t, int joint, double coefficient, int coordinate) {
            new (t) TendonDef::Term{joint, coordinate, coefficient};
          },
          "joint"_a, "coefficient"_a = 1.0, "coordinate"_a = 0)
      .def_ro("joint", &TendonDef::Term::joint)
      .def_ro("coordinate", &TendonDef::Term::coordinate)
      .def_ro("coefficient", &TendonDef::Term::coefficient);
  nb::class_<TendonDef>(m, "Tendon", "Tension k (L - L_0) + d L' in a sum L of coordinates of joints.")
      .def(
          "__init__",
          [](TendonDef* t, std::string name, std::vector<TendonDef::Term> terms, double stiffness, double damping,
             double free_length) {
            new (t) TendonDef{std::move(name), std::move(terms), stiffness, damping, free_length};
          },
          "name"_a, "terms"_a, "stiffness"_a = 0.0, "damping"_a = 0.0, "free_length"_a = 0.0)
      .def_ro("name", &TendonDef::name)
      .def_ro("terms", &TendonDef::terms)
      .def_rw("stiffness", &TendonDef::stiffness)
      .def_rw("damping", &TendonDef::damping)
      .def_rw("free_length", &TendonDef::free_length);
}

}  // namespace

void bind_elements(nb::module_& m) {
  bind_sensors(m);
  bind_tendon(m);
  bind_springs(m);
  nb::class_<FollowerForceDef>(m, "FollowerForce", "A force and a torque in the axes of a body.")
      .def(
          "__init__",
          [](FollowerForceDef* f, std::string name, int body, const Vector3d& point, const Vector3d& force,
             const Vector3d& torque,
             int node) { new (f) FollowerForceDef{{std::move(name), body, point, node}, force, torque}; },
          "name"_a, "body"_a, "point"_a, "force"_a = Vector3d(Vector3d::Zero()),
          "torque"_a = Vector3d(Vector3d::Zero()), "node"_a = kFloatingFrame)
      .def_ro("name", &FollowerForceDef::name)
      .def_ro("body", &FollowerForceDef::body)
      .def_ro("point", &FollowerForceDef::point)
      .def_ro("node", &FollowerForceDef::node)
      .def_rw("force", &FollowerForceDef::force)
      .def_rw("torque", &FollowerForceDef::torque);
  bind_bearing_and_drag(m);
  bind_contacts(m);
}

void bind_element_lists(nb::class_<MultibodyDef>& c) {
  c.def_ro("line_springs", &MultibodyDef::line_springs)
      .def_ro("tendons", &MultibodyDef::tendons)
      .def_ro("table_springs", &MultibodyDef::table_springs)
      .def_ro("torsion_springs", &MultibodyDef::torsion_springs)
      .def_ro("bushings", &MultibodyDef::bushings)
      .def_ro("bearings", &MultibodyDef::bearings)
      .def_ro("follower_forces", &MultibodyDef::follower_forces)
      .def_ro("drags", &MultibodyDef::drags)
      .def_ro("cloud_contacts", &MultibodyDef::cloud_contacts)
      .def_ro("plane_contacts", &MultibodyDef::plane_contacts)
      .def_ro("sphere_contacts", &MultibodyDef::sphere_contacts)
      .def("add", nb::overload_cast<LineSpringDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<TendonDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<TableSpringDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<TorsionSpringDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<BushingDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<BearingDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<FollowerForceDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<DragDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<CloudContactDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<PlaneContactDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<SphereContactDef>(&MultibodyDef::add));
}
