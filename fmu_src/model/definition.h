// The plain description of a multibody system: what a mechanism file fills in and what parameters change.
//
// What is not said has the default that stands here; only names have none. Nothing is checked while it is filled in:
// validate does that, and comes before anything is built from it. SI units. W is the inertial frame. A rigid body's
// frame B sits in its centre of mass, a flexible body's anywhere; points and axes of a body are given in B. The ground
// is body kGround, its frame is W.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "model/elements/coupling.h"
#include "model/elements/elements.h"

namespace sigmafmu {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;

// What makes a body flexible: n nodes and f modes, so that node i is at X_i + Phi_i zeta in B. Everything follows from
// the nodes, the mass and the inertia of the body as well; its floating frame B need not be in the centre of mass.
//
// Where a file is named, load_modal_files (modal_file.h) reads what stands up to `damping` from it. The number of its
// modes is told because the FMU has variables for each.
struct ModalDef {
  std::string file;         // in the FMU's folder `resources`, here in models/resources/<Mechanism>; empty: none
  int modes = 0;            // of that file
  MatrixXd nodes;           // X [m], n x 3
  VectorXd masses;          // of the nodes, n [kg]; or
  MatrixXd mass_matrix;     // symmetric, n x n [kg], the same in all directions: T = 1/2 sum_ij M_ij r_i' . r_j'
  MatrixXd shapes;          // Phi, 3n x f: row 3i + c is component c of node i
  MatrixXd rotations;       // Psi [rad], 3n x f: turns of the nodes for the joints there; empty: the nodes do not turn
  MatrixXd stiffness;       // f x f, symmetric, positive semidefinite: V = 1/2 zeta^T K zeta
  MatrixXd damping;         // f x f, the same; empty: none
  double mass_damping = 0;  // Rayleigh: mass_damping M_ff [1/s] and
  double stiffness_damping = 0;  // stiffness_damping K [s] are added to the damping
  VectorXd initial_coordinates;  // zeta; empty: zero
  VectorXd initial_rates;        // zeta'; empty: zero

  int node_count() const { return static_cast<int>(nodes.rows()); }
  bool awaits_file() const { return !file.empty() && nodes.size() == 0; }
  int mode_count() const { return awaits_file() ? modes : static_cast<int>(shapes.cols()); }
};

// Modal data that are in a file.
ModalDef modal_file(std::string name, int modes);

// A rigid body or, with `modal`, a flexible one: its mass and inertia are then those of the nodes, and the initial
// values are those of its floating frame.
struct RigidBodyDef {
  std::string name;
  std::string description;
  double mass = 1.0;                                     // [kg]
  Vector3d inertia = Vector3d::Ones();                   // xx, yy, zz about B [kg m^2]
  Vector3d inertia_products = Vector3d::Zero();          // xy, xz, yz: the matrix elements themselves [kg m^2]
  Vector3d initial_position = Vector3d::Zero();          // p_WB [m]
  Vector4d initial_quaternion = Vector4d(1, 0, 0, 0);    // quat_WB (w, x, y, z), any length > 0
  Vector3d initial_velocity = Vector3d::Zero();          // v_WB in W [m/s]
  Vector3d initial_angular_velocity = Vector3d::Zero();  // w_WB_B in B [rad/s]
  std::optional<ModalDef> modal = std::nullopt;          // rigid
};

// The mass [kg] that a body has.
double mass(const RigidBodyDef& body);
// The inertia matrix J [kg m^2] of a rigid body.
Matrix3d inertia_matrix(const RigidBodyDef& body);

// Axes whose z is the given direction (need not be unit); equal directions give equal axes.
Matrix3d axes_with_z(const Vector3d& z);

enum class JointType {
  spherical,      // origins coincide
  revolute,       // origins coincide and z1 = z2; angle from x1 to x2 about z
  universal,      // origins coincide and y1 is perpendicular to x2 (the two axes of the cross); angles about y1 and x2
  prismatic,      // axes are parallel, origin 2 on the z axis of frame 1; displacement along z1
  fixed,          // frames coincide
  cylindrical,    // z axes coincide; angle from x1 to x2 about z, displacement along z1
  planar,         // z1 = z2, origin 2 in the plane of x1 and y1; angle about z, displacements along x1 and y1
  distance,       // origins stay `length` apart
  point_on_line,  // origin 2 on the z axis of frame 1; displacement along z1
  free,           // no equation; displacements along x1, y1 and z1
  screw,          // cylindrical, and the displacement is pitch angle / (2 pi)
  constant_velocity,  // origins coincide, and no twist: x1 . y2 = y1 . x2
  point_in_plane,     // origin 2 in the plane of x1 and y1; displacements along them
  rolling_disk,       // a disk of `radius` about origin 2 and z2 rolls on the plane of x1 and y1, on the side of z1
};

// What a joint leaves free: an angle [rad] about an axis of its frames, or a displacement [m] along one of frame 1.
enum class CoordinateKind { angle, displacement };
struct CoordinateType {
  enum class AxisOf { both_frames, frame1, frame2 };
  CoordinateKind kind;
  int axis;  // 0: x, 1: y, 2: z
  AxisOf of;
};
const std::vector<CoordinateType>& coordinates(JointType type);
// In the order of the enumeration.
const std::vector<std::string>& joint_type_names();

// Where a joint tells its reaction, and in which axes: about a point of frame 1 or 2, in W or in the axes of a frame.
struct ReactionDef {
  enum class At { frame1, frame2 };
  enum class Axes { ground, frame1, frame2 };
  At at = At::frame2;
  Vector3d point = Vector3d::Zero();  // in that frame [m]
  Axes axes = Axes::ground;

  bool is_default() const { return at == At::frame2 && axes == Axes::ground && point.isZero(0); }
};

struct JointDef {
  std::string name;
  JointType type = JointType::spherical;
  int body1 = kGround;
  Frame frame1;
  int body2 = kGround;
  Frame frame2;
  // Of each coordinate: angles with their turns [rad], displacements [m], and rates. They count where
  // MultibodyDef::held has them; else the bodies tell them.
  static constexpr double kNotSet = std::numeric_limits<double>::quiet_NaN();
  std::array<double, 3> initial_coordinates = {kNotSet, kNotSet, kNotSet};
  std::array<double, 3> initial_rates = {kNotSet, kNotSet, kNotSet};
  double length = kNotSet;  // of a distance joint [m]; not set: what it is at the start
  double pitch = kNotSet;   // of a screw: the displacement of a turn [m], negative for a left-handed thread
  double radius = kNotSet;  // of a rolling disk [m]
  ReactionDef reaction = {};

  int coordinate_count() const { return static_cast<int>(coordinates(type).size()); }
  bool turns(int coordinate) const { return coordinates(type)[coordinate].kind == CoordinateKind::angle; }
  // Follows the words for a coordinate where a joint has several of its kind: 1, 2, ...; else nothing.
  std::string number(int coordinate) const;
  // `of_angle` or `of_displacement`, with that number.
  std::string word(int coordinate, const char* of_angle, const char* of_displacement) const;
  // For what acts on a coordinate: `word`, with that number, or `displacementWord` for a displacement of a joint that
  // has angles as well.
  std::string word_on(int coordinate, const std::string& word) const;
};

// Points (time from the start [s], value) of a function of time: the natural cubic spline through them, and straight
// lines beyond its ends.
struct TableDef {
  std::vector<double> times, values;
};

// Prescribes a joint's coordinate: where it is from the start on, or at which rate or acceleration it goes on from its
// initial value. A constant, a function of time, or an input of the FMU with the derivatives that the master gives.
struct DriveDef {
  enum class Motion { position, rate, acceleration };
  int joint = 0;
  int coordinate = 0;  // of the joint
  Motion motion = Motion::rate;
  double value = 0;  // [rad] or [m], per s, per s^2; of an input: at the start
  bool input = false;
  std::optional<TableDef> table = std::nullopt;  // in place of the value
  // Of an input at the start, as the master has set them.
  double first_derivative = 0, second_derivative = 0;

  // `angle`, `rate` or `acceleration` as the name of the input has it: `joint.drivenAngle`.
  std::string input_name(const MultibodyDef& definition) const;
};

// A frame of the ground that moves in a prescribed way: a shaker, a road, the deck of a ship. Elements attach to it as
// to node k of the ground, where this is motion k. Six functions of time tell its displacement d [m] in W and its
// rotation vector psi [rad], each 0 where nothing is said: p = position + d, R = axes exp(hat(psi)).
struct MotionDef {
  std::string name;
  Vector3d position = Vector3d::Zero();
  Matrix3d axes = Matrix3d::Identity();
  bool input = false;  // all six are inputs of the FMU: `displacement`, `rotation`
  std::array<std::optional<TableDef>, 6> tables = {};
  // Of inputs at the start, as the master has set them: values, first and second derivatives.
  std::array<std::array<double, 6>, 3> start = {};
};

// One of the numbers that a mechanism starts from. Objects are bodies, or joints.
struct InitialValue {
  enum class Kind { position, quaternion, velocity, angular_velocity, modal, modal_rate, joint_coordinate, joint_rate };
  Kind kind = Kind::position;
  int object = 0, component = 0;

  bool of_joint() const { return kind == Kind::joint_coordinate || kind == Kind::joint_rate; }
  bool of_motion() const {  // else of position
    return kind == Kind::velocity || kind == Kind::angular_velocity || kind == Kind::modal_rate ||
           kind == Kind::joint_rate;
  }
};
bool operator<(const InitialValue& a, const InitialValue& b);

struct MultibodyDef {
  std::vector<RigidBodyDef> bodies;
  std::vector<JointDef> joints;
  std::vector<SpringDamperDef> spring_dampers;
  std::vector<LineSpringDef> line_springs;
  std::vector<TableSpringDef> table_springs;
  std::vector<TorsionSpringDef> torsion_springs;
  std::vector<BushingDef> bushings;
  std::vector<BearingDef> bearings;
  std::vector<FollowerForceDef> follower_forces;
  std::vector<DragDef> drags;
  std::vector<PlaneContactDef> plane_contacts;
  std::vector<SphereContactDef> sphere_contacts;
  std::vector<CloudContactDef> cloud_contacts;
  std::vector<LoadDef> loads;
  std::vector<TendonDef> tendons;
  std::vector<JointSpringDef> joint_springs;
  std::vector<JointFrictionDef> joint_frictions;
  std::vector<JointStopDef> joint_stops;
  std::vector<JointArmatureDef> joint_armatures;
  std::vector<RotationMotorDef> rotation_motors;
  std::vector<DriveDef> drives;
  std::vector<CouplingDef> couplings;
  std::vector<MotionDef> motions;
  Vector3d gravity = Vector3d::Zero();  // in W [m/s^2]
  // Initial values that a user has set, each with the one that the definition came with: these stay, the others give
  // way where the joints ask for it.
  std::map<InitialValue, double> held;

  // Each returns the index of what it adds; those of bodies are what `body1`, `body2` and `body` refer to.
  int add(RigidBodyDef body);
  int add(JointDef joint);
  int add(SpringDamperDef spring_damper);
  int add(LineSpringDef spring);
  int add(TableSpringDef spring);
  int add(TorsionSpringDef spring);
  int add(BushingDef bushing);
  int add(BearingDef bearing);
  int add(FollowerForceDef force);
  int add(DragDef drag);
  int add(PlaneContactDef contact);
  int add(SphereContactDef contact);
  int add(CloudContactDef contact);
  int add(LoadDef load);
  int add(TendonDef tendon);
  int add(JointSpringDef spring);
  int add(JointFrictionDef friction);
  int add(JointStopDef stop);
  int add(JointArmatureDef armature);
  int add(RotationMotorDef motor);
  int add(DriveDef drive);
  int add(CouplingDef coupling);
  int add(MotionDef motion);
};

// How many components the vector has that a value belongs to, 0 where there is no such value. Those of a joint are its
// coordinates.
int component_count(const MultibodyDef& definition, const InitialValue& what);
double& initial_value(MultibodyDef& definition, const InitialValue& what);
double initial_value(const MultibodyDef& definition, const InitialValue& what);
// Sets an initial value, which is held from then on, until it is set to what the definition came with.
void set_initial_value(MultibodyDef& definition, const InitialValue& what, double value);
// The definition as it came, with nothing held.
MultibodyDef without_held_values(const MultibodyDef& definition);
// The name of the vector that a value belongs to, `body.initialPosition`, or of a joint's scalar,
// `joint.initialAngle`; and its unit.
std::string initial_name(const MultibodyDef& definition, const InitialValue& what);
const char* initial_unit(const MultibodyDef& definition, const InitialValue& what);

// Of a body's frame or of one of its nodes, from its initial values; of a moving frame where its motion is zero.
struct PoseAtStart {
  Vector3d position = Vector3d::Zero();
  Matrix3d axes = Matrix3d::Identity();
};
PoseAtStart pose_at_start(const MultibodyDef& definition, int body, int node);
// The length [m] of a distance joint.
double rod_length(const MultibodyDef& definition, const JointDef& joint);

// The name of a constraint: joints come first, then drives, each called by its joint, then couplings.
std::string constraint_name(const MultibodyDef& definition, int constraint);

// How large the mechanism is [m]: the largest distance of a joint, force or node from the origin of its body's
// frame, or the largest radius of gyration.
double size(const MultibodyDef& definition);

// Throws std::invalid_argument with one sentence that names the variable, its value and what is allowed: names that are
// missing, used twice or no names of FMI variables; mass and inertia that no rigid body can have, a zero quaternion,
// negative stiffness, numbers that are not finite, unknown bodies and nodes, axes that are no rotation; modal data that
// are missing, of wrong sizes, not symmetric, not positive semidefinite.
void validate(const MultibodyDef& definition);

}  // namespace sigmafmu
