"""Attitude control of an axis."""

from math import cos, sin, sqrt
from typing import ClassVar


class AxisAttitude:
    """Turns the y axis of a body towards a direction b of W, and leaves its spin alone: geometric PD on the sphere.

    With the target seen from the body, Γ = Rᵀ b / |b|, the axis e = e_y and the transverse part ω⊥ of ω:

        τ = k e × Γ − d ω⊥ − g e × Rᵀ n,      n = −e_z the direction of gravity, g = m g l its largest moment.

    V = ½ ω⊥ᵀ J ω⊥ + k (1 − e·Γ) decreases: V̇ = −d |ω⊥|². The gyroscopic torque does no work, so that the spin does not
    matter; k is a torque per sine of the angle. No angles are subtracted, and q and −q give the same torque.

    The torque is held for H in a body that turns by ω_y H meanwhile, so τ is turned ahead by half of that angle.
    """

    inputs: ClassVar = {
        **{f"quaternion[{i}]": (0.0, "1", f"orientation of B in W, {c}") for i, c in enumerate("wxyz", start=1)},
        **{f"angularVelocity[{i}]": (0.0, "rad/s", f"ω in B, {c}") for i, c in enumerate("xyz", start=1)},
    }
    outputs: ClassVar = {f"torque[{i}]": (0.0, "N.m", f"torque in B, {c}") for i, c in enumerate("xyz", start=1)}
    parameters: ClassVar = {
        "target[1]": (0.0, "1", "direction for the axis in W, x; any length"),
        "target[2]": (0.0, "1", "direction for the axis in W, y"),
        "target[3]": (1.0, "1", "direction for the axis in W, z"),
        "stiffness": (500.0, "N.m", "k"),
        "damping": (120.0, "N.m.s/rad", "d"),
        "weightMoment": (147.15, "N.m", "g = m g l, with l from the pivot to the centre of mass, along +y of B"),
    }

    def __init__(self, **values):
        self.values = {name: start for name, (start, _, _) in self.parameters.items()} | values
        self.reset()

    def reset(self):
        """Nothing is remembered from sample to sample."""

    def step(self, time, H, measured):
        """One sample."""
        p = self.values
        quaternion = [measured[f"quaternion[{i}]"] for i in (1, 2, 3, 4)]
        rate = [measured[f"angularVelocity[{i}]"] for i in (1, 2, 3)]
        target = [p[f"target[{i}]"] for i in (1, 2, 3)]
        length = sqrt(sum(x * x for x in target))
        if not length > 0.0:
            raise ValueError(f"target is {target}, but needs a length above zero to be a direction")
        # along Rᵀ (k b / |b| + g e_z): compensation adds the torque that would hold the top against gravity
        x, _, z = _in_body(
            quaternion,
            p["stiffness"] * target[0] / length,
            p["stiffness"] * target[1] / length,
            p["stiffness"] * target[2] / length + p["weightMoment"],
        )
        # e_y × (x, y, z) = (z, 0, −x)
        torque_x, torque_z = z - p["damping"] * rate[0], -x - p["damping"] * rate[2]
        # what stands still in W turns by −ω_y in B
        c, s = cos(0.5 * H * rate[1]), sin(0.5 * H * rate[1])
        return {"torque[1]": c * torque_x - s * torque_z, "torque[2]": 0.0, "torque[3]": s * torque_x + c * torque_z}


def _in_body(quaternion, x, y, z):
    """Rᵀ (x, y, z) for a unit quaternion (w, x, y, z)."""
    w, a, b, c = quaternion
    return (
        (w * w + a * a - b * b - c * c) * x + 2.0 * (a * b + w * c) * y + 2.0 * (a * c - w * b) * z,
        2.0 * (a * b - w * c) * x + (w * w - a * a + b * b - c * c) * y + 2.0 * (b * c + w * a) * z,
        2.0 * (a * c + w * b) * x + 2.0 * (b * c - w * a) * y + (w * w - a * a - b * b + c * c) * z,
    )
