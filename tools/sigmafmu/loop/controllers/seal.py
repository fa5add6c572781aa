"""A force that makes rotors whirl."""

from typing import ClassVar


class Seal:
    """Seal or internal damping: a force F = q (−z, y) along the forward whirl of a rotor with its axis along x.

    Against damping c a whirl at ω_n grows if q > c ω_n. Internal damping c_i acts in the same way with q = c_i Ω, which
    makes a rotor unstable above a multiple of its critical speed.
    """

    inputs: ClassVar = {
        "y": (0.0, "m", "displacement of the rotor, y"),
        "z": (0.0, "m", "displacement of the rotor, z"),
    }
    outputs: ClassVar = {
        "force.y": (0.0, "N", "force on the rotor, y"),
        "force.z": (0.0, "N", "force on the rotor, z"),
    }
    parameters: ClassVar = {"crossCoupling": (2000.0, "N/m", "q")}

    def __init__(self, **values):
        self.values = {name: start for name, (start, _, _) in self.parameters.items()} | values

    def reset(self):
        """Nothing is remembered from sample to sample."""

    def step(self, time, H, measured):
        """One sample."""
        q = self.values["crossCoupling"]
        return {"force.y": -q * measured["z"], "force.z": q * measured["y"]}
