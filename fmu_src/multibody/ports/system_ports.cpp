// Ports of stations and of the whole mechanism.
#include <algorithm>

#include "multibody/momentum.h"
#include "multibody/ports/ports.h"

namespace sigmafmu {
namespace {

void station_position(const View& view, int s, int, double* values) {
  const StationDef& station = view.mechanism.stations[s];
  Vector3d sum = Vector3d::Zero();
  for (int node : station.nodes) sum += view.system.node_position(view.evaluation, station.body, node);
  vector3(values) = sum / static_cast<double>(station.nodes.size());
}

void station_deflection(const View& view, int s, int, double* values) {
  const StationDef& station = view.mechanism.stations[s];
  const int f = view.system.flexible_index(station.body);
  const VectorXd& zeta = view.evaluation.flexible[f].zeta;
  const std::size_t axes = station.deflection_axes.size();
  std::fill_n(values, axes, 0.0);
  for (int node : station.nodes) {
    const Vector3d displacement = view.system.flexible(f).shape(node).lazyProduct(zeta);
    for (std::size_t i = 0; i < axes; ++i) values[i] += station.deflection_axes[i].dot(displacement);
  }
  for (std::size_t i = 0; i < axes; ++i) values[i] /= static_cast<double>(station.nodes.size());
}

// Kinetic, potential and total energy.
void energies(const View& view, int, int, double* values) {
  values[0] = view.system.kinetic_energy(view.evaluation);
  values[1] = view.system.potential_energy(view.evaluation, view.inputs);
  values[2] = values[0] + values[1];
}

void momenta(const View& view, int, int, double* values) {
  const Momentum m = momentum(view.system, view.evaluation);
  vector3(values) = m.centre_of_mass;
  vector3(values + 3) = m.linear;
  vector3(values + 6) = m.angular;
}

}  // namespace

void station_ports(Ports& ports, int s) {
  const StationDef& d = ports.mechanism.stations[s];
  ports.owner(d.name, "station", "");
  ports.outputs(s, d.name + ".position", 3, "Displacement", with_note("Position in W", d.description),
                station_position);
  const int axes = static_cast<int>(d.deflection_axes.size());
  if (axes == 0) return;
  ports.outputs(s, d.name + ".deflection", axes == 1 ? 0 : axes, "Deflection",
                with_note("Displacement by deformation, in body axes", d.description), station_deflection);
}

void system_ports(Ports& ports) {
  ports.owner("", "", "");
  using V = const View&;
  ports.parameters(
      0, "gravity", 3, "Acceleration", "Gravitational acceleration in W",
      [](Mechanism& m, int, int, int c) -> double& { return m.multibody.gravity[c]; }, Variability::tunable);
  const Ports::Group energy = ports.group(0, 3, energies);
  ports.output(energy, 0, "energy.kinetic", "Energy", "Kinetic energy of all bodies");
  ports.output(energy, 1, "energy.potential", "Energy",
               ports.system.flexible_count() > 0
                   ? "Potential energy of gravity (zero at the origin of W), springs and deformation"
                   : "Potential energy of gravity (zero at the origin of W) and springs");
  ports.output(energy, 2, "energy.total", "Energy", "Kinetic and potential energy");
  const Ports::Group whole = ports.group(0, 9, momenta);
  ports.outputs(whole, 0, "centerOfMass", 3, "Position", "Centre of mass of all bodies, in W");
  ports.outputs(whole, 3, "momentum", 3, "Momentum", "Momentum of all bodies, in W");
  ports.outputs(whole, 6, "angularMomentum", 3, "AngularMomentum",
                "Moment of momentum of all bodies about the origin of W, in W");
  ports.output(0, "constraint.positionResidual", "Residual",
               "Largest violation of a joint equation (m, or 1 for directions)",
               [](V v, int, int, double* x) { *x = v.system.position_residual(v.evaluation); });
  ports.output(0, "constraint.velocityResidual", "Residual",
               "Largest violation of the time derivative of a joint equation (m/s, or 1/s for directions)",
               [](V v, int, int, double* x) { *x = v.system.velocity_residual(v.evaluation); });
  if (ports.system.compliance().dependent == 0) return;
  Port& redundant =
      ports.output(0, "joints.redundant", nullptr,
                   "Joint equations that follow from others: with them the reactions of joints are one choice of many",
                   [](V v, int, int, double* x) { *x = v.system.compliance().dependent; });
  redundant.causality = Causality::local;
  redundant.integer = true;
  redundant.variability = Variability::discrete;
}

}  // namespace sigmafmu
