"""The closed loops, in one table: a mechanism, the laws around it and the wires between them."""

from collections.abc import Mapping
from dataclasses import dataclass

from sigmafmu import SigmafmuError
from sigmafmu.loop.controllers import Law
from sigmafmu.loop.controllers.axis_attitude import AxisAttitude
from sigmafmu.loop.controllers.magnetic_bearings import MagneticBearings
from sigmafmu.loop.controllers.seal import Seal
from sigmafmu.loop.controllers.speed_pi import SpeedPI

CONTROLLER = "controller"
"""Name of the part that can be exchanged or switched off."""


@dataclass(frozen=True)
class Part:
    """A law and its wires."""

    law: type[Law]
    measured: Mapping[str, str]
    """Input of the law → output of the plant."""
    actuated: Mapping[str, str]
    """Output of the law → input of the plant."""


@dataclass(frozen=True)
class Loop:
    """A closed loop. Everything starts with the start values of the FMUs, so that every master gets the same system."""

    plant: str
    """Model of the mechanism; also the name of the loop."""
    parts: Mapping[str, Part]
    """By name; they are sampled in this order. No two of them drive the same input."""
    H: float
    """Sampling period and communication step, s."""
    stop_time: float
    """Length of a standard run, s."""
    shown: tuple[str, ...]
    """Further outputs of the plant that are worth recording."""

    @property
    def outputs(self) -> list[str]:
        """Outputs of the plant that are recorded: those that are measured first."""
        measured = [name for part in self.parts.values() for name in part.measured.values()]
        return list(dict.fromkeys([*measured, *self.shown]))

    @property
    def inputs(self) -> list[str]:
        """Inputs of the plant that the laws drive."""
        return [name for part in self.parts.values() for name in part.actuated.values()]


def _vector(name: str, target: str, indices: tuple[int, ...]) -> dict[str, str]:
    return {f"{name}[{i}]": f"{target}[{i}]" for i in indices}


LOOPS: dict[str, Loop] = {
    loop.plant: loop
    for loop in (
        Loop(
            plant="SliderCrank",
            parts={
                CONTROLLER: Part(SpeedPI, {"speed": "crankPivot.angularRate"}, {"torque": "crankPivot.motorTorque"})
            },
            H=1e-3,
            stop_time=2.0,
            shown=("crankPivot.angle", "guide.displacement", "energy.total"),
        ),
        Loop(
            plant="HighSpeedRotor",
            parts={
                CONTROLLER: Part(
                    MagneticBearings,
                    {
                        f"{side}.{axis}": f"{side}Support.position[{i}]"
                        for side in ("left", "right")
                        for i, axis in ((2, "y"), (3, "z"))
                    },
                    {
                        f"{side}Force.{axis}": f"{side}Support.actuatorForce[{i}]"
                        for side in ("left", "right")
                        for i, axis in ((2, "y"), (3, "z"))
                    },
                ),
                "seal": Part(
                    Seal,
                    {"y": "rotor.position[2]", "z": "rotor.position[3]"},
                    {"force.y": "rotor.force[2]", "force.z": "rotor.force[3]"},
                ),
            },
            H=5e-5,
            stop_time=1.0,
            shown=("rotor.velocity[2]", "rotor.velocity[3]"),
        ),
        Loop(
            plant="HeavyTop",
            parts={
                CONTROLLER: Part(
                    AxisAttitude,
                    _vector("quaternion", "top.quaternion", (1, 2, 3, 4))
                    | _vector("angularVelocity", "top.angularVelocity", (1, 2, 3)),
                    _vector("torque", "top.torque", (1, 2, 3)),
                )
            },
            H=1e-3,
            stop_time=3.0,
            shown=("top.position[1]", "top.position[2]", "top.position[3]", "energy.total"),
        ),
    )
}


def find(name: str) -> Loop:
    """The loop called `name`; raises SigmafmuError with the known ones."""
    if name not in LOOPS:
        raise SigmafmuError(f"there is no loop '{name}'; known loops: {', '.join(LOOPS)}")
    return LOOPS[name]
