// A bearing or seal between two frames: force -K d - C d' on the second body, with the displacement d of frame2's
// origin in the axes of frame1. K and C need not be symmetric: cross-coupling in the plane across z. The axes stand
// still if frame1 is that of the housing, and turn with the shaft if it is that of the shaft.
#pragma once

#include "model/elements/two_frames.h"
#include "model/parameter.h"

namespace sigmafmu {

struct BearingDef : TwoFrames {
  static constexpr const char *kKind = "bearing", *kType = "bearing";
  using Vector2d = Eigen::Vector2d;
  using Vector3d = Eigen::Vector3d;
  using Matrix3d = Eigen::Matrix3d;

  Vector3d stiffness = Vector3d::Zero();        // xx, yy, zz of K [N/m]
  Vector3d damping = Vector3d::Zero();          // xx, yy, zz of C [N s/m]
  Vector2d cross_stiffness = Vector2d::Zero();  // xy, yx of K: force along the first by displacement along the second
  Vector2d cross_damping = Vector2d::Zero();    // xy, yx of C

  static const std::vector<Parameter<BearingDef>>& parameters() {
    using Def = BearingDef;
    static const std::vector<Parameter<Def>> table = {
        {"stiffness", "Stiffness", "Stiffness along the axes of the first frame", 3,
         [](Def& d) { return d.stiffness.data(); }},
        {"damping", "Damping", "Damping along the axes of the first frame", 3, [](Def& d) { return d.damping.data(); }},
        {"crossStiffness", "CrossStiffness", "Cross-coupled stiffness k_xy and k_yx", 2,
         [](Def& d) { return d.cross_stiffness.data(); }},
        {"crossDamping", "CrossDamping", "Cross-coupled damping c_xy and c_yx", 2,
         [](Def& d) { return d.cross_damping.data(); }},
    };
    return table;
  }
  Matrix3d stiffness_matrix() const { return matrix(stiffness, cross_stiffness); }
  Matrix3d damping_matrix() const { return matrix(damping, cross_damping); }
  void check_values() const { check_frames(); }
  template <typename Archive, typename Any>
  static void visit(Archive& archive, Any& d) {
    visit_frames(archive, d);
    archive.parameters(d);
  }

 private:
  static Matrix3d matrix(const Vector3d& diagonal, const Vector2d& cross) {
    Matrix3d A = diagonal.asDiagonal();
    A(0, 1) = cross[0];
    A(1, 0) = cross[1];
    return A;
  }
};

}  // namespace sigmafmu
