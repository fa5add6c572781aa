"""The problems: mechanisms as the package has them, where one of their points is at the end, and forces where known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import sigmafmu
from research.mechanisms.parts import GROUND, REVOLUTE, add_body, add_joint
from research.reference.iftomm import ANDREWS, flyball_motion
from research.reference.linkage_motions import bricard_motion, four_bar_row_motion
from research.reference.minimal_coordinates import solve
from sigmafmu import _core
from sigmafmu.mechanism_file.load import load

LIBRARY = Path(sigmafmu.__file__).parent / "library"
GRAVITY = 9.81  # m/s2
PENDULUM_LENGTH, PENDULUM_MASS, PENDULUM_INERTIA = 1.0, 1.0, 1e-6  # about its own centre of mass
ANDREWS_LEVER = 0.00092
"""Of the first crank's centre of mass [m]."""


@dataclass(frozen=True)
class Problem:
    """A mechanism, and the centre of mass of one body that is compared at the end."""

    name: str
    title: str
    mechanism: Callable[[], _core.Mechanism]
    exact: Callable[[], np.ndarray]
    """Of that point [m]."""
    body: int
    size: float
    """Of what moves [m]: errors are parts of it."""
    stop_time: float  # s
    largest: float
    """First step [s]."""
    joint: str
    """Whose force is compared."""
    force: Callable[[], float] | None = None
    """Its size [N], where an independent solution tells it."""
    planar: bool = False
    """All moves in a plane: Exudyn has bodies and hinges for that."""
    unique: bool = True
    """Whether that joint's force follows from the motion; redundant joints may share it in any way."""
    exudyn: str = ""
    """The name of a model of research.reference.exudyn_models."""
    mujoco: bool = True
    """Whether it can be told to MuJoCo here: hinges, balls and slides, loops of hinges."""
    stiff: bool = False
    """Springs that an explicit method resolves with small steps alone."""


def simple_pendulum() -> _core.Mechanism:
    """1 kg at 1 m, let go from the horizontal; 1e-6 kg m² of its own."""
    m = _core.Mechanism("SimplePendulum")
    m.multibody.gravity = np.array([0.0, -GRAVITY, 0.0])
    place = np.array([PENDULUM_LENGTH, 0.0, 0.0])
    add_body(m.multibody, "bob", PENDULUM_MASS, np.full(3, PENDULUM_INERTIA), place)
    add_joint(m.multibody, "hinge", REVOLUTE, GROUND, 0, np.zeros(3))
    return m


def _pendulum_acceleration(angle: float) -> float:
    inertia = PENDULUM_MASS * PENDULUM_LENGTH**2 + PENDULUM_INERTIA
    return -PENDULUM_MASS * GRAVITY * PENDULUM_LENGTH * float(np.cos(angle)) / inertia


@cache
def _pendulum_end() -> tuple[float, float]:
    """Angle and rate after 10 s."""

    def rhs(_: float, y: np.ndarray) -> list[float]:
        return [y[1], _pendulum_acceleration(y[0])]

    angle, rate = solve_ivp(rhs, (0.0, 10.0), (0.0, 0.0), "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return float(angle), float(rate)


def _pendulum_point() -> np.ndarray:
    angle, _ = _pendulum_end()
    return PENDULUM_LENGTH * np.array([np.cos(angle), np.sin(angle), 0.0])


def _pendulum_force() -> float:
    angle, rate = _pendulum_end()
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    acceleration = PENDULUM_LENGTH * (_pendulum_acceleration(angle) * across - rate**2 * along)
    return PENDULUM_MASS * float(np.linalg.norm(acceleration + np.array([0.0, GRAVITY])))


def _four_bar_point() -> np.ndarray:
    angle = four_bar_row_motion(2, np.array([0.0, 10.0]))[0][-1]
    return np.array([1.5 + np.cos(angle), np.sin(angle), 0.0])


def _andrews_point() -> np.ndarray:
    angle = ANDREWS["drive.angle"]
    return ANDREWS_LEVER * np.array([np.cos(angle), np.sin(angle), 0.0])


def _slider_crank(name: str) -> float:
    return float(solve("SliderCrank", np.array([0.0, 5.0]))[name][-1])


def _slider_crank_force() -> float:
    return float(np.linalg.norm([_slider_crank(f"crankPin.reactionForce[{i}]") for i in (1, 2, 3)]))


def _file(name: str) -> Callable[[], _core.Mechanism]:
    return lambda: load(LIBRARY / f"{name}.yaml").mechanism


PROBLEMS = (
    Problem(
        "A01",
        "simple pendulum",
        simple_pendulum,
        _pendulum_point,
        body=0,
        size=1.0,
        stop_time=10.0,
        largest=1e-2,
        joint="hinge",
        force=_pendulum_force,
        planar=True,
    ),
    Problem(
        "A02",
        "two four-bars",
        _file("DoubleFourBar"),
        _four_bar_point,
        body=4,
        size=1.0,
        stop_time=10.0,
        largest=1e-2,
        joint="pivot1",
        planar=True,
    ),
    Problem(
        "A03",
        "Andrews' squeezer",
        _file("AndrewsSqueezer"),
        _andrews_point,
        body=0,
        size=ANDREWS_LEVER,
        stop_time=0.03,
        largest=1e-4,
        joint="pinF",
        planar=True,
    ),
    Problem(
        "A04",
        "Bricard's mechanism",
        _file("Bricard"),
        lambda: bricard_motion(np.array([0.0, 9.0]))[-1, 2],
        body=2,
        size=1.0,
        stop_time=9.0,
        largest=1e-2,
        joint="hinge1",
        unique=False,
    ),
    Problem(
        "A05",
        "flyball governor",
        _file("Flyball"),
        lambda: np.array([0.0, 0.0, flyball_motion(np.array([0.0, 10.0]))[0, -1]]),
        body=1,
        size=1.0,
        stop_time=10.0,
        largest=2e-3,
        joint="hinge1",
        stiff=True,
    ),
    Problem(
        "crank",
        "spatial slider-crank",
        lambda: _core.mechanism("SliderCrank"),
        lambda: np.array([_slider_crank("guide.displacement"), 0.0, 0.0]),
        body=2,
        size=0.1,
        stop_time=5.0,
        largest=1e-2,
        joint="crankPin",
        force=_slider_crank_force,
        exudyn="SliderCrank",
        mujoco=False,
    ),
)
