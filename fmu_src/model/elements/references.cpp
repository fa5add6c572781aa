#include "model/elements/references.h"

#include "model/definition.h"
#include "model/validation.h"

namespace sigmafmu {

using validation::fail;

int References::bodies() const { return static_cast<int>(d_.bodies.size()); }

void References::body(const std::string& name, int body) const {
  if (body >= kGround && body < bodies()) return;
  fail(name, " refers to body ", body, "; allowed are -1 (ground) to ", bodies() - 1, ".");
}

void References::pair(const std::string& name, int body1, int body2) const {
  body(name, body1), body(name, body2);
  if (body1 == body2) fail(name, " connects ", name_of(body1), " with itself; it must connect two bodies.");
}

void References::not_ground(const std::string& name, const char* verb, int body) const {
  if (body >= 0 && body < bodies()) return;
  fail(name, " ", verb, " body ", body, "; allowed are 0 to ", bodies() - 1, ".");
}

void References::node(const std::string& name, int body, int node) const {
  if (node == kFloatingFrame) return;
  if (body == kGround && !d_.motions.empty()) {
    const int motions = static_cast<int>(d_.motions.size());
    if (node >= 0 && node < motions) return;
    fail(name, " attaches to moving frame ", node, " of the ground; allowed are -1 (none) to ", motions - 1, ".");
  }
  if (!is_flexible(body)) {
    fail(name, " attaches to node ", node, " of ", name_of(body), ", which is not flexible; allowed is -1 (no node).");
  }
  if (node >= 0 && node < nodes(body)) return;
  fail(name, " attaches to node ", node, " of ", name_of(body), "; allowed are -1 (floating frame) to ",
       nodes(body) - 1, ".");
}

void References::joint(const char* what, int joint) const {
  const int joints = static_cast<int>(d_.joints.size());
  if (joint < 0 || joint >= joints) fail(what, " acts on joint ", joint, "; allowed are 0 to ", joints - 1, ".");
}

void References::coordinate(const char* what, int joint, int coordinate) const {
  this->joint(what, joint);
  const JointDef& j = d_.joints[joint];
  if (coordinate >= 0 && coordinate < j.coordinate_count()) return;
  fail(what, " acts on coordinate ", coordinate, " of ", j.name, "; joints of its type have ", j.coordinate_count(),
       ", counted from 0.");
}

bool References::is_flexible(int body) const { return body != kGround && d_.bodies[body].modal; }
int References::nodes(int body) const { return d_.bodies[body].modal->node_count(); }
std::string References::name_of(int body) const { return body == kGround ? "the ground" : d_.bodies[body].name; }

}  // namespace sigmafmu
