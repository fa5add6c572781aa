"""Active magnetic bearings."""

from typing import ClassVar


class MagneticBearings:
    """Two radial active magnetic bearings on a rotor with its axis along x.

    Each bearing and axis is a PD controller, F = −P q − D v, with the filtered derivative v = (q − f) / τ, τ ḟ = q − f,
    of the position q.

    A fast rotor is a gyroscope: a force against its tilt turns it sideways, so that PD hardly damps the precession. The
    cross feedback pushes sideways instead: at the slope (s_y, s_z) of the axis with the forces ±C (−s_z, s_y), + on the
    right and − on the left, which turn the axis towards zero (for a spin along +x).

    Every force is limited. The filter is integrated by the trapezoidal rule and starts at the first measured position.
    """

    inputs: ClassVar = {
        "left.y": (0.0, "m", "position of the rotor in the left bearing, y"),
        "left.z": (0.0, "m", "position of the rotor in the left bearing, z"),
        "right.y": (0.0, "m", "position of the rotor in the right bearing, y"),
        "right.z": (0.0, "m", "position of the rotor in the right bearing, z"),
    }
    outputs: ClassVar = {
        "leftForce.y": (0.0, "N", "force of the left bearing on the rotor, y"),
        "leftForce.z": (0.0, "N", "force of the left bearing on the rotor, z"),
        "rightForce.y": (0.0, "N", "force of the right bearing on the rotor, y"),
        "rightForce.z": (0.0, "N", "force of the right bearing on the rotor, z"),
    }
    parameters: ClassVar = {
        "stiffness": (4000.0, "N/m", "P"),
        "damping": (80.0, "N.s/m", "D"),
        "filterTime": (1e-3, "s", "τ, time constant of the derivative's filter"),
        "crossStiffness": (2500.0, "N", "C, force per slope of the axis"),
        "distance": (0.2, "m", "from the left to the right bearing"),
        "forceLimit": (50.0, "N", "largest force along each axis"),
        "startTime": (0.0, "s", "the bearings are switched on then"),
    }

    def __init__(self, **values):
        self.values = {name: start for name, (start, _, _) in self.parameters.items()} | values
        self.reset()

    def reset(self):
        """The next sample starts the filters."""
        self._positions = self._filtered = None
        self._elapsed = 0.0

    def step(self, time, H, measured):
        """One sample."""
        p = self.values
        q = [measured[name] for name in self.inputs]
        v = self._velocities(q)
        self._elapsed = H

        slope_y, slope_z = (q[2] - q[0]) / p["distance"], (q[3] - q[1]) / p["distance"]
        cross_y, cross_z = -p["crossStiffness"] * slope_z, p["crossStiffness"] * slope_y
        cross = (-cross_y, -cross_z, cross_y, cross_z)
        wanted = (-p["stiffness"] * x - p["damping"] * w + c for x, w, c in zip(q, v, cross, strict=True))
        limit = p["forceLimit"] if time >= p["startTime"] else 0.0
        return {name: max(-limit, min(limit, force)) for name, force in zip(self.outputs, wanted, strict=True)}

    def _velocities(self, q):
        """Filtered derivatives of the positions q, after the time that went by since the last sample."""
        if self._positions is None:
            self._positions = self._filtered = q
        tau = self.values["filterTime"]
        share = self._elapsed / (2.0 * tau + self._elapsed)
        states = zip(self._filtered, self._positions, q, strict=True)
        self._filtered = [f + share * (before + now - 2.0 * f) for f, before, now in states]
        self._positions = q
        return [(x - f) / tau for x, f in zip(q, self._filtered, strict=True)]
