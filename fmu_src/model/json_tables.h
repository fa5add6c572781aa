// The one table for each struct of a mechanism of its members and their keys in JSON; `archive` reads or writes each.
//
//   required(key, x)            a key that must be there
//   optional(key, x)            one that may be left out: x keeps its default; a third argument false: not written
//   choice(key, x, words, n)    an enumeration by the names of its values n, n + 1, ...; optional_choice
//   list(key, xs, add)          a list of structs, each read one given to add
//   parameters(x)               those of a force, which may be left out
//   body(key, i), optional_body(key, i), bodies(key, i, j), joint(key, i), held(key, definition)
//
// Keys are those of the files that users write, where these have the same thing.
#pragma once

#include <cmath>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "model/mechanism.h"
#include "model/settings_table.h"

namespace sigmafmu::json {

inline constexpr int kVersion = 1;

// Const for an archive that writes.
template <typename Def, typename Any>
using If = std::enable_if_t<std::is_same_v<std::remove_const_t<Any>, Def>, int>;

// Members under a key of their own.
template <typename Members>
struct Group {
  Members members;
};
template <typename Members>
Group(Members) -> Group<Members>;
template <typename Archive, typename Members>
void visit(Archive& archive, const Group<Members>& group) {
  group.members(archive);
}

template <typename Archive, typename Any, If<Frame, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.optional("position", d.origin);
  archive.optional("orientation", Group{[&](auto& a) { a.required("matrix", d.axes); }});
  archive.optional("node", d.node, d.node != kFloatingFrame);
}

template <typename Archive, typename Any, If<ModalDef, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.required("file", d.file);
  archive.required("modes", d.modes);
  archive.optional("mass_damping", d.mass_damping);
  archive.optional("stiffness_damping", d.stiffness_damping);
  archive.optional("initial_coordinates", d.initial_coordinates, d.initial_coordinates.size() > 0);
  archive.optional("initial_rates", d.initial_rates, d.initial_rates.size() > 0);
}

template <typename Archive, typename Any, If<RigidBodyDef, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.required("name", d.name);
  archive.optional("description", d.description);
  archive.optional("flexible", d.modal, d.modal.has_value());
  if (!d.modal) {  // whose mass and inertia come from its nodes
    archive.required("mass", d.mass);
    archive.required("inertia", Group{[&](auto& a) {
                       a.required("xx", d.inertia[0]), a.required("yy", d.inertia[1]), a.required("zz", d.inertia[2]);
                       a.optional("xy", d.inertia_products[0]), a.optional("xz", d.inertia_products[1]);
                       a.optional("yz", d.inertia_products[2]);
                     }});
  }
  archive.optional("position", d.initial_position);
  archive.optional("orientation", Group{[&](auto& a) { a.required("quaternion", d.initial_quaternion); }});
  archive.optional("velocity", d.initial_velocity);
  archive.optional("angular_velocity", d.initial_angular_velocity);
}

template <typename Archive, typename Any, If<ReactionDef, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.optional_choice("at", d.at, {"frame1", "frame2"}, 0);
  archive.optional("point", d.point);
  archive.optional_choice("axes", d.axes, {"ground", "frame1", "frame2"}, 0);
}

template <typename Archive, typename Any, If<JointDef, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.required("name", d.name);
  archive.choice("type", d.type, joint_type_names(), 0);
  archive.bodies("bodies", d.body1, d.body2);
  archive.optional("frame1", d.frame1);
  archive.optional("frame2", d.frame2);
  if (d.type == JointType::distance) archive.optional("length", d.length, !std::isnan(d.length));
  if (d.type == JointType::screw) archive.optional("pitch", d.pitch, !std::isnan(d.pitch));
  if (d.type == JointType::rolling_disk) archive.optional("radius", d.radius, !std::isnan(d.radius));
  archive.optional("reaction", d.reaction, !d.reaction.is_default());
  // A joint with several coordinates has keys for each: an angle's are the shorter ones.
  for (int c = 0; c < d.coordinate_count(); ++c) {
    const bool plain = d.turns(c) || !d.turns(0);
    archive.optional((plain ? "coordinate" : "displacement") + d.number(c), d.initial_coordinates[c],
                     !std::isnan(d.initial_coordinates[c]));
    archive.optional((plain ? "rate" : "displacement_rate") + d.number(c), d.initial_rates[c],
                     !std::isnan(d.initial_rates[c]));
  }
}

// A force; its type where a list holds several.
template <typename Archive, typename Any, typename Def = std::remove_const_t<Any>,
          std::enable_if_t<std::is_class_v<typename std::remove_reference_t<decltype(Def::parameters())>>, int> = 0>
void visit(Archive& archive, Any& d) {
  if constexpr (HasName<Def>::value) archive.required("name", d.name);
  if constexpr (Def::kType != nullptr) {
    int type = 0;
    archive.choice("type", type, {Def::kType}, 0);
  }
  Def::visit(archive, d);
}

template <typename Archive, typename Any, If<DriveDef, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.joint("joint", d.joint);
  archive.optional("coordinate", d.coordinate);
  archive.choice("motion", d.motion, {"position", "rate", "acceleration"}, 0);
  archive.optional("value", d.value, !d.table);
  archive.optional("input", d.input, d.input);
  archive.optional("table", d.table, d.table.has_value());
}

template <typename Archive, typename Any, If<TableDef, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.required("times", d.times);
  archive.required("values", d.values);
}

template <typename Archive, typename Any, If<CouplingDef::Term, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.joint("joint", d.joint);
  archive.optional("coordinate", d.coordinate);
  archive.required("polynomial", d.polynomial);
}

template <typename Archive, typename Any, If<TendonDef::Term, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.joint("joint", d.joint);
  archive.optional("coordinate", d.coordinate);
  archive.required("coefficient", d.coefficient);
}

template <typename Archive, typename Any, If<CouplingDef, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.required("name", d.name);
  archive.optional_choice("type", d.type, coupling_type_names(), 0);
  archive.required("terms", d.terms);
  archive.optional("offset", d.offset, !std::isnan(d.offset));
}

template <typename Archive, typename Any, If<MotionDef, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.required("name", d.name);
  archive.optional("position", d.position);
  archive.optional("orientation", Group{[&](auto& a) { a.required("matrix", d.axes); }});
  archive.optional("input", d.input, d.input);
  constexpr const char* keys[] = {"x", "y", "z", "rx", "ry", "rz"};
  for (std::size_t i = 0; i < d.tables.size(); ++i) archive.optional(keys[i], d.tables[i], d.tables[i].has_value());
}

template <typename Archive, typename Any, If<StationDef, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.required("name", d.name);
  archive.optional("description", d.description);
  archive.body("body", d.body);
  archive.required("nodes", d.nodes);
  archive.optional("deflection_axes", d.deflection_axes);
}

template <typename Archive, typename Any, If<SensorDef, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.required("name", d.name);
  archive.choice("type", d.type, sensor_type_names(), 0);
  archive.optional("description", d.description);
  archive.body("body", d.body);
  archive.optional("frame", d.frame);
  if (d.type == SensorType::imu) return;
  archive.optional_body("reference", d.reference);
  archive.optional("reference_frame", d.reference_frame);
  archive.optional_choice("axes", d.axes, sensor_axes_names(), 0);
}

template <typename Archive, typename Any, If<ExposureDef, Any> = 0>
void visit(Archive& archive, Any& d) {
  archive.optional("inputs", d.inputs);
  archive.optional("outputs", d.outputs);
  archive.optional("parameters", d.parameters);
}

template <typename Archive, typename Any, If<IntegratorSettings, Any> = 0>
void visit(Archive& archive, Any& d) {
  for (const RealSetting& s : real_settings()) archive.optional(s.name, d.*s.value);
  for (const IntegerSetting& s : integer_settings()) {
    if (!s.enumeration) {
      archive.optional(s.name, d.*s.value);
      continue;
    }
    std::vector<std::string> words;
    words.reserve(s.enumeration->items.size());
    for (const Enumeration::Item& item : s.enumeration->items) words.emplace_back(item.name);
    archive.optional_choice(s.name, d.*s.value, words, 1);
  }
}

template <typename Archive, typename Any, If<Mechanism, Any> = 0>
void visit(Archive& archive, Any& d) {
  auto& m = d.multibody;
  const auto add = [&](auto x) { m.add(std::move(x)); };
  archive.version("sigmafmu", kVersion);
  archive.required("name", d.name);
  archive.optional("description", d.description);
  archive.optional("gravity", m.gravity);
  archive.list("bodies", m.bodies, add);
  archive.list("joints", m.joints, add);
  for_each_force_list(m, [&](const char* key, auto& forces) { archive.list(key, forces, add); });
  archive.list("drives", m.drives, add);
  archive.list("couplings", m.couplings, add);
  archive.list("motions", m.motions, add);
  archive.list("stations", d.stations, [&](auto x) { d.add(std::move(x)); });
  archive.list("sensors", d.sensors, [&](auto x) { d.add(std::move(x)); });
  archive.optional("expose", d.expose, d.expose.has_value());
  archive.optional("integrator", d.integrator);
  archive.optional("experiment", Group{[&](auto& a) {
                     a.optional("stop_time", d.stop_time);
                     a.optional("step_size", d.communication_step);
                   }});
  archive.held("held", m);
}

}  // namespace sigmafmu::json
