"""What the interface of each FMU must be: every variable with its unit, causality and start value.

`MECHANISMS` says what a mechanism consists of; the variables of bodies, joints, springs and loads follow from it.
Numbers come from `research.reference`, which holds the literature's data without any code of the FMUs.
"""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from research.reference import CRANK, GRAVITY, ROD, SLIDER, TOP, Body, Rotor
from research.reference.clouds import PENDULUM_ANGULAR_VELOCITY, SpinUp

from .helpers import (
    ABSOLUTE_COORDINATES,
    CORRECTORS,
    EPS,
    FORMULATIONS,
    GROUPS,
    JACOBIANS,
    LOCAL_COORDINATES,
    METHODS,
    NEWTONS,
)

ANGLE = {
    "angle": ("output", "rad"),
    "angularRate": ("output", "rad/s"),
    "angularAcceleration": ("output", "rad/s2"),
    "power": ("output", "W"),
    "motorTorque": ("input", "N.m"),
    "initialAngle": ("parameter", "rad"),
    "initialAngularRate": ("parameter", "rad/s"),
}
JOINT_COORDINATE = {
    "spherical": {},
    "universal": {f"{name}{number}": what for number in (1, 2) for name, what in ANGLE.items()},
    "fixed": {},
    "revolute": ANGLE,
    "prismatic": {
        "displacement": ("output", "m"),
        "rate": ("output", "m/s"),
        "acceleration": ("output", "m/s2"),
        "power": ("output", "W"),
        "actuatorForce": ("input", "N"),
        "initialDisplacement": ("parameter", "m"),
        "initialRate": ("parameter", "m/s"),
    },
}

JOINT_STARTS = {  # coordinate and rate; else 0
    "crankPivot.": (0.0, 6.0),
    "guide.": (0.2, 0.24),
    # about y of the rod, (0, 2, -1)/sqrt(5), then about W x; the rod turns with (1.92, -0.96, 0.48)
    "wristPin.1": (-math.atan2(math.sqrt(5), 2), 2.4 / math.sqrt(5)),
    "wristPin.2": (math.atan2(1, 2), -1.92),
}


@dataclass(frozen=True)
class Spring:
    stiffness: tuple[float, float, float]
    damping: tuple[float, float, float]


@dataclass(frozen=True)
class Flexible:
    """A flexible body; initial values are those of its frame."""

    name: str
    modes: int
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular_velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))  # in W


@dataclass(frozen=True)
class Mechanism:
    bodies: tuple[Body | Flexible, ...]
    joints: dict[str, str] = field(default_factory=dict)  # name: type
    springs: dict[str, Spring] = field(default_factory=dict)
    loads: dict[str, np.ndarray] = field(default_factory=dict)  # name: torque in W
    stations: dict[str, int] = field(default_factory=dict)  # name: components of the deflection, -1: a scalar
    gravity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    stop_time: float = 1.0  # s
    step_size: float = 1e-3  # s, internal


_rotor = Rotor()
_spin_up = SpinUp()


def stations(body: str) -> dict[str, int]:
    return {f"{body}.station{i}": 0 for i in (1, 2, 3, 4)}


MECHANISMS = {
    "HeavyTop": Mechanism(
        bodies=(TOP,), joints={"pivot": "spherical"}, gravity=GRAVITY, stop_time=2.0, step_size=2.5e-4
    ),
    "HighSpeedRotor": Mechanism(
        bodies=(_rotor.body,),
        springs={
            "leftSupport": Spring((_rotor.stiffness,) * 3, (_rotor.damping,) * 3),
            "rightSupport": Spring((0.0, _rotor.stiffness, _rotor.stiffness), (0.0, _rotor.damping, _rotor.damping)),
        },
        loads={"load": _rotor.torque},
        stop_time=1.0,
        step_size=5e-6,
    ),
    "SliderCrank": Mechanism(
        bodies=(CRANK, ROD, SLIDER),
        joints={"crankPivot": "revolute", "crankPin": "spherical", "wristPin": "universal", "guide": "prismatic"},
        gravity=GRAVITY,
        stop_time=5.0,
        step_size=1e-4,
    ),
    "FlexiblePendulum": Mechanism(
        bodies=(Flexible("beam", 4, angular_velocity=PENDULUM_ANGULAR_VELOCITY),),
        joints={"pivot": "spherical"},
        stations={**stations("beam"), "tip": 3},
        gravity=GRAVITY,
        stop_time=2.0,
        step_size=1e-4,
    ),
    "FlexibleSliderCrank": Mechanism(
        bodies=(
            CRANK,
            Flexible(
                "rod",
                4,
                position=np.array([0, 0.1, 0.2]),  # B
                rotation=ROD.rotation,
                velocity=np.array([0, -0.48, 0]),
                angular_velocity=ROD.angular_velocity,
            ),
            SLIDER,
        ),
        joints={"crankPivot": "revolute", "crankPin": "spherical", "wristPin": "universal", "guide": "prismatic"},
        stations={**stations("rod"), "middle": 3},
        gravity=GRAVITY,
        stop_time=2.0,
        step_size=1e-4,
    ),
    "SpinUpBeam": Mechanism(
        bodies=(
            Body(
                "hub",
                100.0,
                (500.0, 500.0, _spin_up.hub_inertia),
                position=np.zeros(3),
                velocity=np.zeros(3),
                angular_velocity=np.zeros(3),
            ),
            Flexible("beam", _spin_up.modes),
        ),
        joints={"hubPivot": "revolute", "clamp": "fixed"},
        stations={**stations("beam"), "tip": -1},
        stop_time=30.0,
        step_size=5e-3,
    ),
}

# SI exponents (kg, m, s, rad) of every unit that the contract uses.
UNITS = {
    "1": (0, 0, 0, 0),
    "s": (0, 0, 1, 0),
    "1/s": (0, 0, -1, 0),
    "kg": (1, 0, 0, 0),
    "kg.m2": (1, 2, 0, 0),
    "m": (0, 1, 0, 0),
    "m/s": (0, 1, -1, 0),
    "m/s2": (0, 1, -2, 0),
    "rad": (0, 0, 0, 1),
    "rad/s": (0, 0, -1, 1),
    "rad/s2": (0, 0, -2, 1),
    "N": (1, 1, -2, 0),
    "N.m": (1, 2, -2, 0),
    "N/m": (1, 0, -2, 0),
    "N.s/m": (1, 0, -1, 0),
    "J": (1, 2, -2, 0),
    "W": (1, 2, -3, 0),
    "N.s": (1, 1, -1, 0),
    "N.m.s": (1, 2, -1, 0),
}

# shown = factor · value
DISPLAY_FACTORS = {
    "ms": 1e3,
    "us": 1e6,
    "mm": 1e3,
    "um": 1e6,
    "mm/s": 1e3,
    "deg": 180 / math.pi,
    "deg/s": 180 / math.pi,
    "deg/s2": 180 / math.pi,
    "rpm": 30 / math.pi,
    "kN": 1e-3,
    "N.mm": 1e3,
    "N/mm": 1e-3,
    "mJ": 1e3,
    "kW": 1e-3,
}

ENUMERATIONS = {
    "integrator.formulation": (FORMULATIONS, "stabilizedIndex2"),
    "integrator.corrector": (CORRECTORS, "residual"),
    "integrator.jacobian": (JACOBIANS, "full"),
    "integrator.newton": (NEWTONS, "full"),
    "integrator.sigmaMode": (("fixed", "spinOptimal"), "fixed"),
    "integrator.stepControl": (("fixed", "error"), "fixed"),
    "integrator.method": (METHODS, "generalizedAlpha"),
    "integrator.group": (GROUPS, "R3xSO3"),
    "integrator.localCoordinates": (LOCAL_COORDINATES, "exp"),
    "integrator.absoluteCoordinates": (ABSOLUTE_COORDINATES, "quaternion"),
}


class Row(NamedTuple):
    type: str
    causality: str
    variability: str
    unit: str | None = None
    start: float | None = None
    start_rounding: float = 0.0  # the start may be a computed number: allowed difference


def expected_rows(mechanism: Mechanism) -> dict[str, Row]:
    rows: dict[str, Row] = {}

    def add(name: str, size: int, causality: str, unit: str, variability="continuous", start=None, rounding=0.0):
        """A Real scalar (size 0) or vector."""
        names = [name] if size == 0 else [f"{name}[{i + 1}]" for i in range(size)]
        starts = [None] * len(names) if start is None else np.broadcast_to(start, len(names)).tolist()
        for element, value in zip(names, starts, strict=True):
            rows[element] = Row("Real", causality, variability, unit, value, rounding)

    for body in mechanism.bodies:
        b = body.name
        for name, size, unit in (
            ("position", 3, "m"),
            ("quaternion", 4, "1"),
            ("rotationVector", 3, "rad"),
            ("velocity", 3, "m/s"),
            ("angularVelocity", 3, "rad/s"),
            ("acceleration", 3, "m/s2"),
            ("angularAcceleration", 3, "rad/s2"),
        ):
            add(f"{b}.{name}", size, "output", unit)
        add(f"{b}.force", 3, "input", "N", start=0.0)
        add(f"{b}.torque", 3, "input", "N.m", start=0.0)
        rotation = np.array(body.rotation)
        w = 0.5 * math.sqrt(1 + np.trace(rotation))
        axis = np.array([rotation[(i + 2) % 3, (i + 1) % 3] - rotation[(i + 1) % 3, (i + 2) % 3] for i in range(3)])
        turned = not np.array_equal(rotation, np.eye(3))
        rounding = 4 * EPS if turned else 0.0
        if isinstance(body, Flexible):
            add(f"{b}.modal", body.modes, "output", "m")
            add(f"{b}.modalRate", body.modes, "output", "m/s")
            add(f"{b}.initialModal", body.modes, "parameter", "m", "fixed", 0.0)
            add(f"{b}.initialModalRate", body.modes, "parameter", "m/s", "fixed", 0.0)
            add(f"{b}.massDamping", 0, "parameter", "1/s", "tunable", 0.0)
            add(f"{b}.stiffnessDamping", 0, "parameter", "s", "tunable", 0.0)
        else:
            add(f"{b}.mass", 0, "parameter", "kg", "fixed", body.mass)
            for i, moment in enumerate(("xx", "yy", "zz")):
                add(f"{b}.inertia.{moment}", 0, "parameter", "kg.m2", "fixed", body.inertia[i])
            for product in ("xy", "xz", "yz"):
                add(f"{b}.inertia.{product}", 0, "parameter", "kg.m2", "fixed", 0.0)
        add(f"{b}.initialPosition", 3, "parameter", "m", "fixed", body.position)
        add(f"{b}.initialQuaternion", 4, "parameter", "1", "fixed", np.array([w, *(axis / (4 * w))]), rounding)
        add(f"{b}.initialVelocity", 3, "parameter", "m/s", "fixed", body.velocity)
        speed = np.linalg.norm(body.angular_velocity)
        in_body = rotation.T @ body.angular_velocity
        add(f"{b}.initialAngularVelocity", 3, "parameter", "rad/s", "fixed", in_body, rounding * speed)
    for joint, kind in mechanism.joints.items():
        add(f"{joint}.reactionForce", 3, "output", "N")
        add(f"{joint}.reactionTorque", 3, "output", "N.m")
        for name, (causality, unit) in JOINT_COORDINATE[kind].items():
            if causality == "parameter":
                number = name[-1] if name[-1].isdigit() else ""
                start = JOINT_STARTS.get(f"{joint}.{number}", (0.0, 0.0))["Rate" in name]
                add(f"{joint}.{name}", 0, causality, unit, "fixed", start, 1e-12)  # given with 12 digits
            else:
                add(f"{joint}.{name}", 0, causality, unit, start=0.0 if causality == "input" else None)
    for spring, numbers in mechanism.springs.items():
        add(f"{spring}.stiffness", 3, "parameter", "N/m", "tunable", numbers.stiffness)
        add(f"{spring}.damping", 3, "parameter", "N.s/m", "tunable", numbers.damping)
        add(f"{spring}.position", 3, "output", "m")
        add(f"{spring}.force", 3, "output", "N")
        add(f"{spring}.energy", 0, "output", "J")
        add(f"{spring}.power", 0, "output", "W")
        add(f"{spring}.actuatorForce", 3, "input", "N", start=0.0)
    for station, axes in mechanism.stations.items():
        add(f"{station}.position", 3, "output", "m")
        if axes:
            add(f"{station}.deflection", max(axes, 0), "output", "m")
    for load, torque in mechanism.loads.items():
        add(f"{load}.force", 3, "parameter", "N", "tunable", 0.0)
        add(f"{load}.torque", 3, "parameter", "N.m", "tunable", torque, EPS * np.abs(torque).max())

    add("gravity", 3, "parameter", "m/s2", "tunable", mechanism.gravity)
    for energy in ("kinetic", "potential", "total"):
        add(f"energy.{energy}", 0, "output", "J")
    for name, unit in (("centerOfMass", "m"), ("momentum", "N.s"), ("angularMomentum", "N.m.s")):
        add(name, 3, "output", unit)
    for residual in ("positionResidual", "velocityResidual"):
        add(f"constraint.{residual}", 0, "output", "1")
    add("integrator.stepSize", 0, "parameter", "s", "fixed", mechanism.step_size)
    for name, start in (
        ("spectralRadius", 0.9),
        ("sigma", 1.0),
        ("absoluteTolerance", 1e-10),
        ("relativeTolerance", 1e-8),
        ("errorTolerance", 1e-8),
    ):
        add(f"integrator.{name}", 0, "parameter", "1", "fixed", start)
    for name, start in (("maxNewtonIterations", 20), ("maxHalvings", 10)):
        rows[f"integrator.{name}"] = Row("Integer", "parameter", "fixed", None, start)
    for name, (items, default) in ENUMERATIONS.items():
        rows[name] = Row("Enumeration", "parameter", "fixed", None, items.index(default) + 1)
    for estimate in ("errorEstimate", "largestErrorEstimate"):
        add(f"integrator.{estimate}", 0, "output", "1")
    for counter in ("steps", "newtonIterations", "jacobianEvaluations", "retries"):
        rows[f"integrator.{counter}"] = Row("Integer", "local", "discrete")
    return rows
