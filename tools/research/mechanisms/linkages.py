"""Linkages that close loops; their joints say some things twice where all are hinges.

All are drawn in space with hinges whose axes are z of W, but for Bricard's. The kinds of `REGULAR` in place of all
hinges make the same motion and say nothing twice.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from research.mechanisms.parts import (
    GROUND,
    MANY,
    REVOLUTE,
    SPHERICAL,
    add_bar,
    add_body,
    add_joint,
    expose_ends,
)
from sigmafmu import _core

CYLINDRICAL = _core.JointType.cylindrical
GRAVITY = np.array([0.0, -9.81, 0.0])  # m/s2, in W


# --- planar four-bar -------------------------------------------------------------------------------------------------

CRANK, COUPLER, ROCKER, BASE = 0.2, 0.5, 0.4, 0.6
MASSES = {"crank": 0.5, "coupler": 1.2, "rocker": 0.8}
LENGTHS = {"crank": CRANK, "coupler": COUPLER, "rocker": ROCKER}
SPIN = 8.0
START = 1.0


def bar_inertia(mass: float, length: float) -> np.ndarray:
    """A slender bar along x that is a little thick."""
    return mass * np.array([1e-4, length**2 / 12, length**2 / 12 + 1e-4])


def four_bar_corners(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the coupler (crank pin and rocker pin) at crank angle theta, open branch."""
    pin = CRANK * np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    across = np.array([BASE, 0.0]) - pin
    distance = np.linalg.norm(across, axis=-1, keepdims=True)
    along = (COUPLER**2 - ROCKER**2 + distance**2) / (2 * distance)
    height = np.sqrt(COUPLER**2 - along**2)
    normal = np.stack([-across[..., 1], across[..., 0]], axis=-1)
    return pin, pin + (along * across + height * normal) / distance


def planar_four_bar(kinds: tuple = (REVOLUTE,) * 4) -> _core.Mechanism:
    """Crank 0.2 m, coupler 0.5 m, rocker 0.4 m on a base of 0.6 m: the crank turns fully. It starts at 1 rad with
    8 rad/s."""
    m = _core.Mechanism()
    m.name = "PlanarFourBar"
    m.multibody.gravity = GRAVITY
    step = 1e-6  # velocities of the pins: the projection at the start corrects what differences leave
    corners, ahead, behind = (
        [np.append(p, 0.0) for p in four_bar_corners(np.array(START + d))] for d in (0.0, step, -step)
    )
    rates = [SPIN * (a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True)]
    still, right = np.zeros(3), np.array([BASE, 0.0, 0.0])
    points = [still, *corners, right]
    moving = [still, *rates, still]
    for i, (name, mass) in enumerate(MASSES.items()):
        ends = np.array(points[i : i + 2])
        add_bar(m.multibody, name, ends, mass, bar_inertia(mass, LENGTHS[name]), np.array(moving[i : i + 2]))
    chain = (GROUND, 0, 1, 2, GROUND)
    for i, kind in enumerate(kinds):
        add_joint(m.multibody, f"hinge{i + 1}", kind, chain[i], chain[i + 1], points[i])
    return m


# --- cranks with couplers between them -------------------------------------------------------------------------------


def four_bar_row(count: int, kinds: tuple = (REVOLUTE,) * 3) -> _core.Mechanism:
    """`count` squares side by side: cranks upright on the ground, couplers between their tips that start with 1 m/s.

    All bars have 1 m, 1 kg and, about axes across them, 1/12 kg m². The kinds are those of a crank's pivot and of a
    coupler's left and right pin.
    """
    m = _core.Mechanism()
    m.name = "DoubleFourBar" if count == 2 else f"FourBarRow{count}"
    m.multibody.gravity = GRAVITY
    m.integrator.step_size = 1e-3
    push, still = np.array([1.0, 0, 0]), np.zeros(3)
    inertia = np.array([1e-4, 1 / 12, 1 / 12])
    bottom = [np.array([float(i), 0, 0]) for i in range(count + 1)]
    top = [b + np.array([0, 1.0, 0]) for b in bottom]
    for i in range(count + 1):
        add_bar(m.multibody, f"crank{i + 1}", np.array([bottom[i], top[i]]), 1.0, inertia, np.array([still, push]))
    for i in range(count):
        add_bar(m.multibody, f"coupler{i + 1}", np.array([top[i], top[i + 1]]), 1.0, inertia, np.array([push, push]))
    for i in range(count + 1):
        add_joint(m.multibody, f"pivot{i + 1}", kinds[0], GROUND, i, bottom[i])
    for i in range(count):
        coupler = count + 1 + i
        add_joint(m.multibody, f"left{i + 1}", kinds[1], i, coupler, top[i])
        add_joint(m.multibody, f"right{i + 1}", kinds[2], coupler, i + 1, top[i + 1])
    if len(m.multibody.bodies) > MANY:
        expose_ends(m)
    return m


# --- Bricard's -------------------------------------------------------------------------------------------------------

BRICARD_POINTS = np.array([(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)], dtype=float)
BRICARD_AXES = np.eye(3)[[1, 2, 0, 1, 2, 0]]


def bricard(kinds: tuple = (REVOLUTE,) * 6) -> _core.Mechanism:
    """Five bars along the edges of a cube, six hinges (IFToMM A04)."""
    m = _core.Mechanism()
    m.name = "Bricard"
    m.multibody.gravity = GRAVITY
    x, y, z = np.eye(3)
    turns = [0 * x, -np.pi / 2 * z, -np.pi / 2 * y, np.pi * z, np.pi / 2 * z]
    for i, turn in enumerate(turns):
        middle = BRICARD_POINTS[i : i + 2].mean(axis=0)
        inertia = np.array([1 / 600, 1.01 / 12, 1.01 / 12])
        add_body(m.multibody, f"bar{i + 1}", 1.0, inertia, middle, Rotation.from_rotvec(turn))
    chain = (GROUND, 0, 1, 2, 3, 4, GROUND)
    for i, kind in enumerate(kinds):
        add_joint(m.multibody, f"hinge{i + 1}", kind, chain[i], chain[i + 1], BRICARD_POINTS[i], BRICARD_AXES[i])
    return m


# --- a door ----------------------------------------------------------------------------------------------------------

DOOR_MASS, DOOR_HEIGHT = 20.0, 2.0


def door() -> _core.Mechanism:
    """20 kg, 0.8 m by 2 m, on a hinge at its foot and a ball at its top; the axis is upright, z of W."""
    m = _core.Mechanism()
    m.name = "Door"
    m.multibody.gravity = np.array([0.0, 0.0, -9.81])
    width = 0.8
    add_body(
        m.multibody,
        "door",
        DOOR_MASS,
        DOOR_MASS / 12 * np.array([DOOR_HEIGHT**2, width**2 + DOOR_HEIGHT**2, width**2]),
        np.array([width / 2, 0.0, DOOR_HEIGHT / 2]),
        velocity=np.array([0.0, 1.5 * width / 2, 0.0]),
        angular_velocity=np.array([0.0, 0.0, 1.5]),
    )
    add_joint(m.multibody, "hinge", REVOLUTE, GROUND, 0, np.zeros(3))
    add_joint(m.multibody, "ball", SPHERICAL, GROUND, 0, np.array([0.0, 0.0, DOOR_HEIGHT]))
    return m


REGULAR = {
    planar_four_bar: (REVOLUTE, SPHERICAL, CYLINDRICAL, REVOLUTE),
    four_bar_row: (REVOLUTE, SPHERICAL, CYLINDRICAL),
    bricard: (REVOLUTE,) * 5 + (CYLINDRICAL,),
}
