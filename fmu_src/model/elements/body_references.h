// How elements say what they attach to.
#pragma once

namespace sigmafmu {

inline constexpr int kGround = -1;         // in place of a body: the frame is W
inline constexpr int kFloatingFrame = -1;  // in place of a node of a flexible body: the body's own frame

}  // namespace sigmafmu
