// Definitions of multibody systems and mechanisms in sigmafmu._core.
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>
#include <string>

#include "elements.h"
#include "fmi/set_parameter.h"
#include "model/json.h"
#include "model/mechanism.h"
#include "model/mechanisms.h"
#include "model/modal_file.h"
#include "solve/start/assembly.h"
#include "solve/start/dependent_equations.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace sigmafmu;

void bind_definitions(nb::module_& m) {
  m.attr("GROUND") = kGround;
  nb::enum_<JointType>(m, "JointType")
      .value("spherical", JointType::spherical)
      .value("revolute", JointType::revolute)
      .value("universal", JointType::universal)
      .value("prismatic", JointType::prismatic)
      .value("fixed", JointType::fixed)
      .value("cylindrical", JointType::cylindrical)
      .value("planar", JointType::planar)
      .value("distance", JointType::distance)
      .value("point_on_line", JointType::point_on_line)
      .value("free", JointType::free)
      .value("screw", JointType::screw)
      .value("constant_velocity", JointType::constant_velocity)
      .value("point_in_plane", JointType::point_in_plane)
      .value("rolling_disk", JointType::rolling_disk);
  nb::enum_<ReactionDef::At>(m, "ReactionAt")
      .value("frame1", ReactionDef::At::frame1)
      .value("frame2", ReactionDef::At::frame2);
  nb::enum_<ReactionDef::Axes>(m, "ReactionAxes")
      .value("ground", ReactionDef::Axes::ground)
      .value("frame1", ReactionDef::Axes::frame1)
      .value("frame2", ReactionDef::Axes::frame2);
  nb::class_<ReactionDef>(m, "Reaction", "About which point and in which axes a joint tells its reaction.")
      .def(
          "__init__",
          [](ReactionDef* r, ReactionDef::At at, const Vector3d& point, ReactionDef::Axes axes) {
            new (r) ReactionDef{at, point, axes};
          },
          "at"_a = ReactionDef::At::frame2, "point"_a = Vector3d(Vector3d::Zero()),
          "axes"_a = ReactionDef::Axes::ground)
      .def_ro("at", &ReactionDef::at)
      .def_ro("point", &ReactionDef::point)
      .def_ro("axes", &ReactionDef::axes);
  using Shapes = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
  const auto rows = [](const Shapes& a) -> MatrixXd {  // n x 3 x f -> 3n x f
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    if (a.shape(1) != 3) throw std::invalid_argument("the second dimension of shapes and rotations must be 3");
    return Eigen::Map<const RowMajor>(a.data(), 3 * static_cast<Eigen::Index>(a.shape(0)),
                                      static_cast<Eigen::Index>(a.shape(2)));
  };
  nb::class_<ModalDef>(m, "Modal", "Nodes and modes that make a body flexible.")
      .def(nb::init<>())
      .def_rw("file", &ModalDef::file)
      .def_rw("modes", &ModalDef::modes, "Of the file.")
      .def_rw("nodes", &ModalDef::nodes)
      .def_rw("masses", &ModalDef::masses)
      .def_rw("mass_matrix", &ModalDef::mass_matrix)
      .def(
          "set_shapes", [rows](ModalDef& d, const Shapes& a) { d.shapes = rows(a); }, "shapes"_a, "Phi, n x 3 x f")
      .def(
          "set_rotations", [rows](ModalDef& d, const Shapes& a) { d.rotations = rows(a); }, "rotations"_a,
          "Psi, n x 3 x f")
      .def_rw("shapes", &ModalDef::shapes, "3n x f")
      .def_rw("rotations", &ModalDef::rotations, "3n x f")
      .def_rw("stiffness", &ModalDef::stiffness)
      .def_rw("damping", &ModalDef::damping)
      .def_rw("mass_damping", &ModalDef::mass_damping)
      .def_rw("stiffness_damping", &ModalDef::stiffness_damping)
      .def_rw("initial_coordinates", &ModalDef::initial_coordinates)
      .def_rw("initial_rates", &ModalDef::initial_rates);
  nb::class_<RigidBodyDef>(m, "RigidBody")
      .def(nb::init<>())
      .def_rw("name", &RigidBodyDef::name)
      .def_rw("description", &RigidBodyDef::description)
      .def_rw("modal", &RigidBodyDef::modal, nb::for_setter(nb::arg("modal").none()))
      .def_rw("mass", &RigidBodyDef::mass)
      .def_rw("inertia", &RigidBodyDef::inertia)
      .def_rw("inertia_products", &RigidBodyDef::inertia_products)
      .def_rw("initial_position", &RigidBodyDef::initial_position)
      .def_rw("initial_quaternion", &RigidBodyDef::initial_quaternion)
      .def_rw("initial_velocity", &RigidBodyDef::initial_velocity)
      .def_rw("initial_angular_velocity", &RigidBodyDef::initial_angular_velocity);
  nb::class_<Frame>(m, "Frame")
      .def(
          "__init__",
          [](Frame* f, const Vector3d& origin, const Matrix3d& axes, int node) { new (f) Frame{origin, axes, node}; },
          "origin"_a, "axes"_a, "node"_a = kFloatingFrame)
      .def_rw("node", &Frame::node)
      .def_rw("origin", &Frame::origin)
      .def_rw("axes", &Frame::axes);
  nb::class_<JointDef>(m, "Joint")
      .def(
          "__init__",
          [](JointDef* j, std::string name, JointType type, int body1, const Frame& frame1, int body2,
             const Frame& frame2, double length, double pitch, const ReactionDef& reaction, double radius) {
            new (j) JointDef{std::move(name), type, body1, frame1, body2, frame2};
            j->length = length;
            j->pitch = pitch;
            j->reaction = reaction;
            j->radius = radius;
          },
          "name"_a, "type"_a, "body1"_a, "frame1"_a, "body2"_a, "frame2"_a, "length"_a = JointDef::kNotSet,
          "pitch"_a = JointDef::kNotSet, "reaction"_a = ReactionDef{}, "radius"_a = JointDef::kNotSet)
      .def_rw("name", &JointDef::name)
      .def_rw("type", &JointDef::type)
      .def_ro("body1", &JointDef::body1)
      .def_ro("frame1", &JointDef::frame1)
      .def_ro("body2", &JointDef::body2)
      .def_ro("frame2", &JointDef::frame2)
      .def_rw("initial_coordinates", &JointDef::initial_coordinates, "Of each of its coordinates; nan: not set.")
      .def_rw("initial_rates", &JointDef::initial_rates, "nan: not set")
      .def_rw("length", &JointDef::length, "Of a distance joint [m]; nan: what it is at the start.")
      .def_rw("pitch", &JointDef::pitch, "Of a screw: the displacement of a turn [m].")
      .def_rw("radius", &JointDef::radius, "Of a rolling disk [m].")
      .def_rw("reaction", &JointDef::reaction)
      .def("word", &JointDef::word, "coordinate"_a, "of_angle"_a, "of_displacement"_a,
           "What a variable of one of its coordinates is called.");
  nb::class_<SpringDamperDef>(m, "SpringDamper")
      .def(
          "__init__",
          [](SpringDamperDef* s, std::string name, int body1, const Vector3d& point1, int body2, const Vector3d& point2,
             const Vector3d& stiffness, const Vector3d& damping, int node1, int node2) {
            new (s) SpringDamperDef{{std::move(name), body1, point1, body2, point2, node1, node2}, stiffness, damping};
          },
          "name"_a, "body1"_a, "point1"_a, "body2"_a, "point2"_a, "stiffness"_a, "damping"_a,
          "node1"_a = kFloatingFrame, "node2"_a = kFloatingFrame)
      .def_ro("name", &SpringDamperDef::name)
      .def_ro("body1", &SpringDamperDef::body1)
      .def_ro("point1", &SpringDamperDef::point1)
      .def_ro("node1", &SpringDamperDef::node1)
      .def_ro("body2", &SpringDamperDef::body2)
      .def_ro("point2", &SpringDamperDef::point2)
      .def_ro("node2", &SpringDamperDef::node2)
      .def_rw("stiffness", &SpringDamperDef::stiffness)
      .def_rw("damping", &SpringDamperDef::damping);
  nb::class_<LoadDef>(m, "Load")
      .def(
          "__init__",
          [](LoadDef* l, std::string name, int body, const Vector3d& force, const Vector3d& torque) {
            new (l) LoadDef{std::move(name), "", body, force, torque};
          },
          "name"_a, "body"_a, "force"_a, "torque"_a)
      .def_ro("name", &LoadDef::name)
      .def_rw("description", &LoadDef::description)
      .def_ro("body", &LoadDef::body)
      .def_ro("force", &LoadDef::force)
      .def_ro("torque", &LoadDef::torque);
  nb::class_<OnCoordinate>(m, "OnCoordinate", "What acts along a joint's coordinate.")
      .def_ro("joint", &OnCoordinate::joint)
      .def_ro("coordinate", &OnCoordinate::coordinate);
  nb::class_<JointSpringDef, OnCoordinate>(m, "JointSpring", "Spring and damper on a joint's coordinate.")
      .def(
          "__init__",
          [](JointSpringDef* s, int joint, double stiffness, double damping, double rest, int coordinate) {
            new (s) JointSpringDef{{joint, coordinate}, stiffness, damping, rest};
          },
          "joint"_a, "stiffness"_a = 0.0, "damping"_a = 0.0, "rest"_a = 0.0, "coordinate"_a = 0)
      .def_rw("stiffness", &JointSpringDef::stiffness)
      .def_rw("damping", &JointSpringDef::damping)
      .def_rw("rest", &JointSpringDef::rest);
  nb::class_<JointFrictionDef, OnCoordinate>(m, "JointFriction", "Smooth friction on a joint's coordinate.")
      .def(
          "__init__",
          [](JointFrictionDef* f, int joint, double friction, double stribeck_friction, double stribeck_rate,
             double viscous_friction, double creep_rate, int coordinate) {
            new (f) JointFrictionDef{{joint, coordinate}, friction,         stribeck_friction,
                                     stribeck_rate,       viscous_friction, creep_rate};
          },
          "joint"_a, "friction"_a = 0.0, "stribeck_friction"_a = 0.0, "stribeck_rate"_a = 0.1,
          "viscous_friction"_a = 0.0, "creep_rate"_a = 1e-3, "coordinate"_a = 0)
      .def_rw("friction", &JointFrictionDef::friction)
      .def_rw("stribeck_friction", &JointFrictionDef::stribeck_friction)
      .def_rw("stribeck_rate", &JointFrictionDef::stribeck_rate)
      .def_rw("viscous_friction", &JointFrictionDef::viscous_friction)
      .def_rw("creep_rate", &JointFrictionDef::creep_rate);
  nb::class_<JointStopDef, OnCoordinate>(m, "JointStop", "Stops at both ends of a joint coordinate's range.")
      .def(
          "__init__",
          [](JointStopDef* s, int joint, double lower, double upper, double stiffness, double damping, double depth,
             int coordinate) { new (s) JointStopDef{{joint, coordinate}, lower, upper, stiffness, damping, depth}; },
          "joint"_a, "lower"_a = -1e9, "upper"_a = 1e9, "stiffness"_a = 0.0, "damping"_a = 0.0, "depth"_a = 1e-3,
          "coordinate"_a = 0)
      .def_rw("lower", &JointStopDef::lower)
      .def_rw("upper", &JointStopDef::upper)
      .def_rw("stiffness", &JointStopDef::stiffness)
      .def_rw("damping", &JointStopDef::damping)
      .def_rw("depth", &JointStopDef::depth);
  nb::class_<JointArmatureDef, OnCoordinate>(m, "JointArmature", "Inertia that moves with a joint's coordinate.")
      .def(
          "__init__",
          [](JointArmatureDef* a, int joint, double armature, int coordinate) {
            new (a) JointArmatureDef{{joint, coordinate}, armature};
          },
          "joint"_a, "armature"_a, "coordinate"_a = 0)
      .def_rw("armature", &JointArmatureDef::armature);
  nb::class_<RotationMotorDef>(m, "RotationMotor", "Torque in a joint that lets its bodies turn any way.")
      .def(
          "__init__", [](RotationMotorDef* r, int joint) { new (r) RotationMotorDef{joint}; }, "joint"_a)
      .def_ro("joint", &RotationMotorDef::joint);
  bind_elements(m);
  nb::enum_<DriveDef::Motion>(m, "Motion")
      .value("position", DriveDef::Motion::position)
      .value("rate", DriveDef::Motion::rate)
      .value("acceleration", DriveDef::Motion::acceleration);
  nb::class_<TableDef>(m, "Table", "Points of a function of time: a natural cubic spline.")
      .def(
          "__init__",
          [](TableDef* t, std::vector<double> times, std::vector<double> values) {
            new (t) TableDef{std::move(times), std::move(values)};
          },
          "times"_a, "values"_a)
      .def_ro("times", &TableDef::times)
      .def_ro("values", &TableDef::values);
  nb::class_<DriveDef>(m, "Drive", "Prescribes a joint's coordinate.")
      .def(
          "__init__",
          [](DriveDef* d, int joint, DriveDef::Motion motion, double value, int coordinate, bool input,
             std::optional<TableDef> table) {
            new (d) DriveDef{joint, coordinate, motion, value, input, std::move(table)};
          },
          "joint"_a, "motion"_a, "value"_a = 0.0, "coordinate"_a = 0, "input"_a = false, "table"_a = nb::none())
      .def_ro("joint", &DriveDef::joint)
      .def_ro("coordinate", &DriveDef::coordinate)
      .def_ro("motion", &DriveDef::motion)
      .def_ro("input", &DriveDef::input)
      .def_ro("table", &DriveDef::table)
      .def_rw("value", &DriveDef::value);
  nb::class_<MotionDef>(m, "FrameMotion", "A frame of the ground that moves: node `index` of the ground.")
      .def(
          "__init__",
          [](MotionDef* d, std::string name, const Vector3d& position, const Matrix3d& axes, bool input,
             std::array<std::optional<TableDef>, 6> tables) {
            new (d) MotionDef{std::move(name), position, axes, input, std::move(tables)};
          },
          "name"_a, "position"_a = Vector3d(0, 0, 0), "axes"_a = Matrix3d(Matrix3d::Identity()), "input"_a = false,
          "tables"_a = std::array<std::optional<TableDef>, 6>{})
      .def_ro("name", &MotionDef::name)
      .def_ro("position", &MotionDef::position)
      .def_ro("axes", &MotionDef::axes)
      .def_ro("input", &MotionDef::input)
      .def_ro("tables", &MotionDef::tables);
  nb::enum_<CouplingDef::Type>(m, "CouplingType")
      .value("sum", CouplingDef::Type::sum)
      .value("gear", CouplingDef::Type::gear)
      .value("rack_and_pinion", CouplingDef::Type::rack_and_pinion)
      .value("mimic", CouplingDef::Type::mimic);
  nb::class_<CouplingDef::Term>(m, "CouplingTerm")
      .def(
          "__init__",
          [](CouplingDef::Term* t, int joint, std::vector<double> polynomial, int coordinate) {
            new (t) CouplingDef::Term{joint, coordinate, std::move(polynomial)};
          },
          "joint"_a, "polynomial"_a, "coordinate"_a = 0)
      .def_ro("joint", &CouplingDef::Term::joint)
      .def_ro("coordinate", &CouplingDef::Term::coordinate)
      .def_ro("polynomial", &CouplingDef::Term::polynomial);
  nb::class_<CouplingDef>(m, "Coupling", "An equation between coordinates of joints: sum p_i(x_i) = offset.")
      .def(
          "__init__",
          [](CouplingDef* c, std::string name, std::vector<CouplingDef::Term> terms, double offset) {
            new (c) CouplingDef{std::move(name), std::move(terms), offset};
          },
          "name"_a, "terms"_a, "offset"_a = CouplingDef::kNotSet)
      .def_ro("name", &CouplingDef::name)
      .def_ro("terms", &CouplingDef::terms)
      .def_ro("type", &CouplingDef::type)
      .def_ro("offset", &CouplingDef::offset, "nan: what the sum is at the start.");
  m.def("gear", &gear, "name"_a, "first"_a, "second"_a, "ratio"_a);
  m.def("rack_and_pinion", &rack_and_pinion, "name"_a, "pinion"_a, "rack"_a, "radius"_a);
  m.def("differential", &differential, "name"_a, "carrier"_a, "left"_a, "right"_a);
  m.def("mimic", &mimic, "name"_a, "follower"_a, "leader"_a, "polynomial"_a);
  nb::class_<StationDef>(m, "Station", "A point of a flexible body whose place is an output.")
      .def(
          "__init__",
          [](StationDef* s, std::string name, int body, std::vector<int> nodes, std::vector<Vector3d> axes) {
            new (s) StationDef{std::move(name), "", body, std::move(nodes), std::move(axes)};
          },
          "name"_a, "body"_a, "nodes"_a, "deflection_axes"_a = std::vector<Vector3d>{})
      .def_ro("name", &StationDef::name)
      .def_rw("description", &StationDef::description)
      .def_ro("body", &StationDef::body)
      .def_ro("nodes", &StationDef::nodes)
      .def_ro("deflection_axes", &StationDef::deflection_axes);
  nb::class_<MultibodyDef> multibody(m, "Multibody");
  bind_element_lists(multibody);
  multibody.def(nb::init<>())
      .def_rw("gravity", &MultibodyDef::gravity)
      .def_ro("bodies", &MultibodyDef::bodies)
      .def_ro("joints", &MultibodyDef::joints)
      .def_ro("spring_dampers", &MultibodyDef::spring_dampers)
      .def_ro("loads", &MultibodyDef::loads)
      .def_ro("joint_springs", &MultibodyDef::joint_springs)
      .def_ro("joint_frictions", &MultibodyDef::joint_frictions)
      .def_ro("joint_stops", &MultibodyDef::joint_stops)
      .def_ro("joint_armatures", &MultibodyDef::joint_armatures)
      .def_ro("rotation_motors", &MultibodyDef::rotation_motors)
      .def_ro("drives", &MultibodyDef::drives)
      .def_ro("couplings", &MultibodyDef::couplings)
      .def_ro("motions", &MultibodyDef::motions)
      .def(
          "body", [](MultibodyDef& d, int i) -> RigidBodyDef& { return d.bodies.at(i); },
          nb::rv_policy::reference_internal, "index"_a, "The body itself, to be changed in place.")
      .def("add", nb::overload_cast<RigidBodyDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<JointDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<SpringDamperDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<LoadDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<JointSpringDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<JointFrictionDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<JointStopDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<JointArmatureDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<RotationMotorDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<DriveDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<CouplingDef>(&MultibodyDef::add))
      .def("add", nb::overload_cast<MotionDef>(&MultibodyDef::add))
      .def("validate", [](const MultibodyDef& d) { validate(d); });
  nb::class_<IntegratorSettings>(m, "IntegratorSettings")
      .def_rw("step_size", &IntegratorSettings::step_size)
      .def_rw("spectral_radius", &IntegratorSettings::spectral_radius)
      .def_rw("sigma", &IntegratorSettings::sigma)
      .def_rw("absolute_tolerance", &IntegratorSettings::absolute_tolerance)
      .def_rw("relative_tolerance", &IntegratorSettings::relative_tolerance)
      .def_rw("max_newton_iterations", &IntegratorSettings::max_newton_iterations)
      .def_rw("max_halvings", &IntegratorSettings::max_halvings)
      .def_rw("method", &IntegratorSettings::method)
      .def_rw("group", &IntegratorSettings::group)
      .def_rw("local_coordinates", &IntegratorSettings::local_coordinates)
      .def_rw("absolute_coordinates", &IntegratorSettings::absolute_coordinates)
      .def_rw("formulation", &IntegratorSettings::formulation)
      .def_rw("corrector", &IntegratorSettings::corrector)
      .def_rw("jacobian", &IntegratorSettings::jacobian)
      .def_rw("newton", &IntegratorSettings::newton)
      .def_rw("sigma_mode", &IntegratorSettings::sigma_mode)
      .def_rw("step_control", &IntegratorSettings::step_control)
      .def_rw("error_tolerance", &IntegratorSettings::error_tolerance);
  nb::class_<ExposureDef>(m, "Exposure", "Which variables an FMU has: shell patterns.")
      .def(nb::init<>())
      .def_rw("inputs", &ExposureDef::inputs)
      .def_rw("outputs", &ExposureDef::outputs)
      .def_rw("parameters", &ExposureDef::parameters);
  nb::class_<Mechanism>(m, "Mechanism")
      .def(
          "__init__", [](Mechanism* m, std::string name) { (new (m) Mechanism)->name = std::move(name); },
          "name"_a = "Mechanism")
      .def_rw("name", &Mechanism::name)
      .def_rw("description", &Mechanism::description)
      .def_rw("multibody", &Mechanism::multibody)
      .def_rw("integrator", &Mechanism::integrator)
      .def_rw("stop_time", &Mechanism::stop_time)
      .def_rw("communication_step", &Mechanism::communication_step)
      .def_ro("stations", &Mechanism::stations)
      .def_ro("sensors", &Mechanism::sensors)
      .def_rw("expose", &Mechanism::expose, nb::for_setter(nb::arg("expose").none()),
              "None: all, or of more than 20 bodies all but what belongs to bodies.")
      .def("add", nb::overload_cast<StationDef>(&Mechanism::add), "station"_a)
      .def("add", nb::overload_cast<SensorDef>(&Mechanism::add), "sensor"_a)
      .def("validate", [](const Mechanism& m) { validate(m); })
      .def("set", &set_parameter, "name"_a, "value"_a, "Set a parameter by the name it has in the FMU.");
  m.def("to_json", &to_json, "mechanism"_a, "The mechanism as text; its modal data stay in their files.");
  m.def("from_json", &from_json, "text"_a, "A mechanism from text, as yet without the modal data of its files.");
  m.def(
      "load_modal_files", [](Mechanism& mechanism, const std::string& folder) { load_modal_files(mechanism, folder); },
      "mechanism"_a, "folder"_a, "Read the modal data of its flexible bodies.");
  m.def("axes_with_z", &axes_with_z, "z"_a);
  m.def(
      "assemble",
      [](const MultibodyDef& d) {
        validate(d);
        const System system(d, find_compliance(d));
        ConsistentSolver solver(system);
        VectorXd q(system.position_size()), v(system.velocity_size());
        assemble(d, system, solver, q, v);
        return nb::make_tuple(q, v);
      },
      "multibody"_a, "(q, v) of the initial values, moved onto the constraints.");
  m.def("mechanisms", [] {
    std::vector<std::string> names;
    for (const Mechanism& mechanism : mechanisms()) names.push_back(mechanism.name);
    return names;
  });
  m.def(
      "mechanism",
      [](const std::string& name) {
        for (Mechanism& mechanism : mechanisms()) {
          if (mechanism.name != name) continue;
          const auto package = nb::cast<std::string>(nb::str(nb::module_::import_("sigmafmu").attr("__path__")[0]));
          load_modal_files(mechanism, package + "/resources/" + name);
          validate(mechanism);
          find_joint_values(mechanism.multibody);
          return mechanism;
        }
        throw std::invalid_argument("unknown mechanism " + name);
      },
      "name"_a, "A fresh copy of a mechanism from models/, with the modal data of the package.");
}
