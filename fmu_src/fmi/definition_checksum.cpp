#include "fmi/definition_checksum.h"

#include <algorithm>

#include "model/json.h"
#include "text/checksum.h"

namespace sigmafmu {
namespace {

template <typename Def>
void forget_parameters(Def& element) {
  for (const Parameter<Def>& p : Def::parameters()) std::fill_n(p.values(element), std::max(1, p.size), 0.0);
}

// Those that are parameters (CouplingDef::Type).
void forget_coefficients(CouplingDef& coupling) {
  using Type = CouplingDef::Type;
  if (coupling.type == Type::sum || coupling.terms.size() != 2) return;
  std::vector<double>& polynomial = coupling.terms[coupling.type == Type::mimic ? 1 : 0].polynomial;
  std::fill(polynomial.begin(), polynomial.end(), 0.0);
}

RigidBodyDef without_values(const RigidBodyDef& body) {
  RigidBodyDef result;
  result.name = body.name;
  if (body.modal) result.modal = modal_file(body.modal->file, body.modal->modes);
  return result;
}

Mechanism without_values(Mechanism mechanism) {
  MultibodyDef& d = mechanism.multibody;
  for (RigidBodyDef& body : d.bodies) body = without_values(body);
  for (JointDef& joint : d.joints) {
    joint.initial_coordinates.fill(JointDef::kNotSet);
    joint.initial_rates.fill(JointDef::kNotSet);
    joint.pitch = joint.radius = JointDef::kNotSet;
  }
  for_each_force_list(d, [](const char*, auto& forces) {
    for (auto& force : forces) {
      using Def = std::remove_reference_t<decltype(force)>;
      forget_parameters(force);
      if constexpr (HasDescription<Def>::value) force.description.clear();
    }
  });
  for (DriveDef& drive : d.drives) drive.value = 0;
  for (TendonDef& tendon : d.tendons) {
    for (TendonDef::Term& term : tendon.terms) term.coefficient = 0;
  }
  for (CouplingDef& coupling : d.couplings) forget_coefficients(coupling);
  d.gravity.setZero();
  d.held.clear();
  for (StationDef& station : mechanism.stations) station.description.clear();
  const Mechanism defaults;
  mechanism.description.clear();
  mechanism.integrator = defaults.integrator;
  mechanism.stop_time = defaults.stop_time;
  mechanism.communication_step = defaults.communication_step;
  return mechanism;
}

}  // namespace

std::string definition_checksum(const Mechanism& mechanism) {
  return hexadecimal(checksum(to_json(without_values(mechanism))));
}

}  // namespace sigmafmu
