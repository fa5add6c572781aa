"""Mechanisms of random geometry whose dependent equations are known: doors, planar four-bars, Bricard's, and none."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sigmafmu import _core

from .helpers import GROUND, Rotation

REVOLUTE, SPHERICAL = _core.JointType.revolute, _core.JointType.spherical
UNIVERSAL, PRISMATIC, FIXED = _core.JointType.universal, _core.JointType.prismatic, _core.JointType.fixed


class JointPlace(NamedTuple):
    """A joint between two bodies, where it is in W; the axis is z of its frames, y of those of a universal joint."""

    kind: _core.JointType
    body1: int
    body2: int
    point: np.ndarray
    axis: np.ndarray


def direction(rng: np.random.Generator) -> np.ndarray:
    x = rng.normal(size=3)
    return x / np.linalg.norm(x)


def mechanism(
    rng: np.random.Generator, bodies: int, places: Sequence[JointPlace], masses: Sequence[float] | None = None
) -> _core.Mechanism:
    """Bodies whose frames lie anywhere near their joints; every joint's equations hold to rounding."""
    m = _core.Mechanism()
    m.name = "Chain"
    frames = []
    for i in range(bodies):
        points = np.array([p.point for p in places if i in (p.body1, p.body2)])
        size = max(float(np.ptp(points, axis=0).max()), 1e-3 * float(np.abs(points).max()), 1e-6)
        body = _core.RigidBody()
        body.name = f"body{i + 1}"
        body.mass = 1.0 if masses is None else masses[i]
        body.inertia = body.mass * size**2 * (0.1 + np.array([0.1, 0.2, 0.25]) * rng.uniform(0.5, 1.0))
        body.initial_position = points.mean(axis=0) + 0.2 * size * rng.normal(size=3)
        turn = Rotation.random(rng=rng)
        body.initial_quaternion = turn.as_quat(scalar_first=True)
        frames.append((body.initial_position, turn.as_matrix()))
        m.multibody.add(body)
    for k, place in enumerate(places):
        axes = _core.axes_with_z(place.axis) @ Rotation.from_rotvec([0, 0, rng.uniform(0, 6)]).as_matrix()
        if place.kind == UNIVERSAL:
            axes = axes[:, [1, 2, 0]]
        sides = []
        for body in (place.body1, place.body2):
            position, R = (np.zeros(3), np.eye(3)) if body == GROUND else frames[body]
            local = R.T @ axes
            left, _, right = np.linalg.svd(local)  # orthonormal to rounding
            sides += [body, _core.Frame(R.T @ (place.point - position), left @ right)]
        m.multibody.add(_core.Joint(f"joint{k + 1}", place.kind, *sides))
    return m


def door(rng: np.random.Generator, size: float = 1.0) -> _core.Mechanism:
    """Hinge and ball on one axis."""
    hinge, axis = size * rng.normal(size=3), direction(rng)
    ball = hinge + size * rng.uniform(0.5, 2) * axis
    return mechanism(
        rng, 1, [JointPlace(REVOLUTE, GROUND, 0, hinge, axis), JointPlace(SPHERICAL, GROUND, 0, ball, direction(rng))]
    )


def planar_four_bar(rng: np.random.Generator, third: _core.JointType = REVOLUTE, size: float = 1.0) -> _core.Mechanism:
    """R-R-x-R in any plane, each joint anywhere on its axis."""
    turn, origin = Rotation.random(rng=rng).as_matrix(), size * rng.normal(size=3)
    corners = np.array([(0, 0), (0.2, 0.6), (1.1, 0.9), (1.0, 0)]) + 0.15 * rng.uniform(-1, 1, (4, 2))
    kinds = (REVOLUTE, REVOLUTE, third, REVOLUTE)
    chain = (GROUND, 0, 1, 2, GROUND)
    places = []
    for i, (kind, corner) in enumerate(zip(kinds, corners, strict=True)):
        height = 0.0 if third == SPHERICAL else rng.uniform(-0.5, 0.5)
        point = origin + size * turn @ np.array([*corner, height])
        places.append(JointPlace(kind, chain[i], chain[i + 1], point, turn[:, 2]))
    return mechanism(rng, 3, places)


def bricard(rng: np.random.Generator, size: float = 1.0) -> _core.Mechanism:
    """Bricard's line-symmetric six-bar: three axes anywhere, the other three are these turned by π about a line."""
    line, base = direction(rng), rng.normal(size=3)
    half_turn = 2 * np.outer(line, line) - np.eye(3)
    points, axes = rng.normal(size=(3, 3)), [direction(rng) for _ in range(3)]
    points = [*points, *(base + (p - base) @ half_turn for p in points)]
    axes = [*axes, *(half_turn @ a for a in axes)]
    places = [
        JointPlace(REVOLUTE, i - 1, i if i < 5 else GROUND, size * p, a)
        for i, (p, a) in enumerate(zip(points, axes, strict=True))
    ]
    return mechanism(rng, 5, places)


FREEDOM = {REVOLUTE: 1, PRISMATIC: 1, UNIVERSAL: 2, SPHERICAL: 3, FIXED: 0}
"""What a joint leaves free."""


def spread(rng: np.random.Generator, decades: float, count: int) -> np.ndarray:
    """Log-uniform factors around 1."""
    return 10.0 ** rng.uniform(-decades / 2, decades / 2, count)


def independent_chain(rng: np.random.Generator, closed: bool) -> _core.Mechanism:
    """Joints of any types and directions in a row, links of 1 mm to 100 m, bodies of 1e-3 to 1e3 kg; as a loop with
    enough freedom for its equations to be independent."""
    size = 10.0 ** rng.uniform(-3, 2)
    while True:
        bodies = int(rng.integers(2, 6))
        kinds = [(REVOLUTE, PRISMATIC, UNIVERSAL, SPHERICAL)[i] for i in rng.integers(0, 4, bodies + closed)]
        turning = sum(FREEDOM[k] for k in kinds if k != PRISMATIC)
        # A loop needs three translations and three rotations that its joints leave free.
        if not closed or (sum(FREEDOM[k] for k in kinds) >= 7 and turning >= 3 and kinds.count(PRISMATIC) <= 2):
            break
    points = size * np.cumsum(spread(rng, 2, bodies + 1)[:, None] * [direction(rng) for _ in range(bodies + 1)], axis=0)
    places = [
        JointPlace(kind, i - 1, i if i < bodies else GROUND, point, direction(rng))
        for i, (kind, point) in enumerate(zip(kinds, points, strict=False))
    ]
    return mechanism(rng, bodies, places, spread(rng, 6, bodies))
