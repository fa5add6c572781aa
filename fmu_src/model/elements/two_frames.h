// What forces between a frame of one body and a frame of another have in common.
#pragma once

#include <string>

#include "model/elements/checks.h"
#include "model/elements/references.h"

namespace sigmafmu {

struct TwoFrames {
  std::string name;
  int body1 = kGround;
  Frame frame1;
  int body2 = kGround;
  Frame frame2;

  void check(const References& of) const {
    of.pair(name, body1, body2);
    of.node(name, body1, frame1.node);
    of.node(name, body2, frame2.node);
  }
  void check_frames() const {
    validation::check_frame(name + ".frame1", frame1);
    validation::check_frame(name + ".frame2", frame2);
  }
  template <typename Use>
  void points(Use use) const {
    use(body1, frame1.origin, frame1.node);
    use(body2, frame2.origin, frame2.node);
  }
  template <typename Archive, typename Any>
  static void visit_frames(Archive& archive, Any& d) {
    archive.bodies("bodies", d.body1, d.body2);
    archive.optional("frame1", d.frame1);
    archive.optional("frame2", d.frame2);
  }
};

}  // namespace sigmafmu
