#include "model/names.h"

#include <algorithm>

#include "model/validation.h"

namespace sigmafmu::validation {
namespace {

// First parts of the names of variables that every FMU has, and words with a meaning of their own.
constexpr const char* kReserved[] = {"angularMomentum", "centerOfMass", "constraint", "energy",   "gravity",
                                     "ground",          "integrator",   "joints",     "momentum", "time"};

// What variables of elements are called after the element's name and a dot.
constexpr const char* kVariables[] = {
    "acceleration",
    "actuatorForce",
    "actuatorTorque",
    "angle",
    "angularAcceleration",
    "angularRate",
    "angularVelocity",
    "armature",
    "coefficient",
    "contactPoint",
    "creepRate",
    "crossDamping",
    "crossStiffness",
    "damping",
    "deflection",
    "displacement",
    "displacementArmature",
    "displacementCreepRate",
    "displacementDamping",
    "displacementDrivenAcceleration",
    "displacementDrivenRate",
    "displacementFriction",
    "displacementFrictionForce",
    "displacementFrictionPower",
    "displacementLowerStop",
    "displacementPower",
    "displacementRest",
    "displacementSpringEnergy",
    "displacementSpringForce",
    "displacementSpringPower",
    "displacementStiffness",
    "displacementStopDamping",
    "displacementStopDepth",
    "displacementStopEnergy",
    "displacementStopForce",
    "displacementStopPower",
    "displacementStopStiffness",
    "displacementStribeckFriction",
    "displacementStribeckRate",
    "displacementUpperStop",
    "displacementViscousFriction",
    "dissipation",
    "driveForce",
    "driveTorque",
    "drivenAcceleration",
    "drivenAngle",
    "drivenDisplacement",
    "drivenRate",
    "energy",
    "flow",
    "force",
    "freeLength",
    "friction",
    "frictionForce",
    "frictionPower",
    "frictionTorque",
    "gap",
    "inertia",
    "initialAngle",
    "initialAngularRate",
    "initialAngularVelocity",
    "initialDisplacement",
    "initialModal",
    "initialModalRate",
    "initialPosition",
    "initialQuaternion",
    "initialRate",
    "initialVelocity",
    "length",
    "lowerStop",
    "mass",
    "massDamping",
    "modal",
    "modalRate",
    "modulus",
    "motorPower",
    "motorTorque",
    "normalForce",
    "pitch",
    "polynomial",
    "position",
    "power",
    "quaternion",
    "radius",
    "rate",
    "ratio",
    "reactionForce",
    "reactionTorque",
    "relativeAngularVelocity",
    "rest",
    "rotation",
    "rotationVector",
    "rotational",
    "slipVelocity",
    "specificForce",
    "springEnergy",
    "springForce",
    "springPower",
    "springTorque",
    "stiffness",
    "stiffnessDamping",
    "stopDamping",
    "stopDepth",
    "stopEnergy",
    "stopForce",
    "stopPower",
    "stopStiffness",
    "stopTorque",
    "stribeckFriction",
    "stribeckRate",
    "torque",
    "torsionalDamping",
    "torsionalStiffness",
    "upperStop",
    "velocity",
    "viscousFriction",
};

// `angle2` -> `angle`: the number of a joint's coordinate.
std::string without_number(const std::string& word) { return word.substr(0, word.find_last_not_of("0123456789") + 1); }

template <typename Words>
bool contains(const Words& words, const std::string& word) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

bool is_identifier(const std::string& name) {
  return !name.empty() && is_letter(name[0]) &&
         std::all_of(name.begin(), name.end(), [](char c) { return is_letter(c) || is_digit(c); });
}

void Names::add(const std::string& name, const char* kind, std::size_t index) {
  if (name.empty()) fail("The name of ", kind, " ", index, " is empty; every element must have one.");
  for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
    end = name.find('.', begin);
    if (is_identifier(name.substr(begin, end - begin))) continue;
    fail("\"", name, "\" is the name of a ", kind,
         "; allowed are letters, digits and _, no digit first, and dots between", " such words.");
  }
  const std::string first = name.substr(0, name.find('.'));
  if (contains(kReserved, first)) {
    fail(name, " is the name of a ", kind, "; ", first, " is reserved for what every mechanism has.");
  }
  const auto [other, added] = kinds_.emplace(name, kind);
  if (!added) fail(name, " is the name of a ", other->second, " and of a ", kind, "; every element needs its own.");
}

void Names::check_variables() const {
  for (const auto& [name, kind] : kinds_) {
    for (std::size_t dot = name.find('.'); dot != std::string::npos; dot = name.find('.', dot + 1)) {
      const std::string owner = name.substr(0, dot), word = name.substr(dot + 1, name.find('.', dot + 1) - dot - 1);
      if (kinds_.count(owner) == 0 || !contains(kVariables, without_number(word))) continue;
      fail(name, " is the name of a ", kind, "; variables of ", owner, " may have that name.");
    }
  }
}

}  // namespace sigmafmu::validation
