// An elastic and damping connection of two frames in all six directions. With the displacement d of frame2's origin, in
// the axes of frame1, and the rotation vector psi from frame1 to frame2, x = (d, psi): potential energy x^T K x / 2,
// lost power x'^T D x' (multibody/forces/bushing.h).
#pragma once

#include "model/elements/two_frames.h"
#include "model/parameter.h"

namespace sigmafmu {

struct BushingDef : TwoFrames {
  static constexpr const char *kKind = "bushing", *kType = "bushing";
  using Vector3d = Eigen::Vector3d;
  using Matrix6d = Eigen::Matrix<double, 6, 6>;

  // The diagonals of K and D along and about the axes of frame1, and what else is in them, symmetric with a diagonal of
  // zeros: rows and columns of displacements [N/m, N s/m], of both [N/rad, N s/rad], of rotations [N m/rad, N m s/rad].
  Vector3d stiffness = Vector3d::Zero();            // [N/m]
  Vector3d damping = Vector3d::Zero();              // [N s/m]
  Vector3d torsional_stiffness = Vector3d::Zero();  // [N m/rad]
  Vector3d torsional_damping = Vector3d::Zero();    // [N m s/rad]
  Matrix6d stiffness_coupling = Matrix6d::Zero();
  Matrix6d damping_coupling = Matrix6d::Zero();

  static const std::vector<Parameter<BushingDef>>& parameters() {
    using Def = BushingDef;
    static const std::vector<Parameter<Def>> table = {
        {"stiffness", "Stiffness", "Stiffness along the axes of the first frame", 3,
         [](Def& d) { return d.stiffness.data(); }},
        {"damping", "Damping", "Damping along the axes of the first frame", 3, [](Def& d) { return d.damping.data(); }},
        {"torsionalStiffness", "TorsionalStiffness", "Stiffness about the axes of the first frame", 3,
         [](Def& d) { return d.torsional_stiffness.data(); }},
        {"torsionalDamping", "TorsionalDamping", "Damping about the axes of the first frame", 3,
         [](Def& d) { return d.torsional_damping.data(); }},
    };
    return table;
  }
  Matrix6d stiffness_matrix() const { return with_diagonal(stiffness_coupling, stiffness, torsional_stiffness); }
  Matrix6d damping_matrix() const { return with_diagonal(damping_coupling, damping, torsional_damping); }
  void check_values() const;
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    visit_frames(archive, d);
    archive.parameters(d);
    archive.optional("stiffness_coupling", d.stiffness_coupling, !d.stiffness_coupling.isZero(0));
    archive.optional("damping_coupling", d.damping_coupling, !d.damping_coupling.isZero(0));
  }

 private:
  static Matrix6d with_diagonal(Matrix6d coupling, const Vector3d& displacements, const Vector3d& rotations) {
    coupling.diagonal().head<3>() += displacements;
    coupling.diagonal().tail<3>() += rotations;
    return coupling;
  }
};

}  // namespace sigmafmu
