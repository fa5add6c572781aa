"""What the tests of the core share: differences, exact SO(3) in 50 digits, random mechanisms, runs of the integrator.

Positions q hold (x, y, z, quaternion w, x, y, z) per body, velocities v (in W, angular velocity in B) as in the core.
A "motion" is an increment on R³×SO(3): x + δx in W, R exp(φ) in B.
"""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import mpmath as mp
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import block_diag, null_space
from scipy.spatial.transform import Rotation

from research.reference import MODELS, History, vector_columns
from research.reference.minimal_coordinates import solve
from sigmafmu import _core

EPS = float(np.finfo(float).eps)
GROUND = _core.GROUND
mp.mp.dps = 50

__all__ = ["EPS", "GROUND", "MODELS", "Rotation", "block_diag", "copy", "null_space"]


# --- hypothesis ------------------------------------------------------------------------------------------------------


def property_test(examples: int = 100, **strategies: st.SearchStrategy) -> Callable:
    """`given` with a fixed seed: the same examples in every run and on every machine."""

    def decorate(test: Callable) -> Callable:
        chosen = settings(max_examples=examples, derandomize=True, deadline=None, database=None)
        return chosen(given(**strategies)(test))

    return decorate


def vectors(bound: float, size: int = 3) -> st.SearchStrategy:
    """Vectors with components in [-bound, bound]; hypothesis likes zeros, tiny and extreme ones."""
    return arrays(float, size, elements=st.floats(-bound, bound))


seeds = st.integers(0, 2**32 - 1)
"""Seeds of `np.random.default_rng`, for mechanisms with too many numbers to be drawn one by one."""


# --- differences -----------------------------------------------------------------------------------------------------

FIRST = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}  # sixth order: f' = Σ c (f(kh) - f(-kh)) / h
SECOND = {0: -49 / 18, 1: 3 / 2, 2: -3 / 20, 3: 1 / 90}  # f'' = Σ c (f(kh) + f(-kh)) / h², k = 0 once


def derivative(f: Callable[[float], Any], h: float = 2e-3) -> Any:
    """f'(0): truncation h⁶ f⁽⁷⁾/140, about 5e-19 f⁽⁷⁾, and rounding ε/h, about 1e-13 |f|."""
    return sum(c * (np.asarray(f(k * h)) - f(-k * h)) for k, c in FIRST.items()) / h


def second_derivative(f: Callable[[float], Any], h: float = 1e-2) -> Any:
    """f''(0): truncation h⁶ f⁽⁸⁾/560, about 2e-15 f⁽⁸⁾, and rounding 4 ε/h², about 1e-11 |f|."""
    return sum(c * (np.asarray(f(k * h)) + f(-k * h)) / (1 if k else 2) for k, c in SECOND.items()) / h**2


def jacobian(f: Callable[[np.ndarray], Any], size: int) -> np.ndarray:
    """df/dx at x = 0, column by column."""
    return np.stack([derivative(lambda s, e=e: f(s * e)) for e in np.eye(size)], axis=-1)


def assert_close(actual: Any, expected: Any, tolerance: float, scale: float = 1.0) -> None:
    """Largest component of the difference at most tolerance × (scale + largest component)."""
    actual, expected = np.asarray(actual), np.asarray(expected)
    assert actual.shape == expected.shape
    if actual.size == 0:
        return
    allowed = tolerance * (scale + np.abs(expected).max())
    assert np.abs(actual - expected).max() <= allowed, f"{np.abs(actual - expected).max():.3g} > {allowed:.3g}"


DIFFERENCES = 1e-11
"""Accuracy of the differences above, relative to the size of the numbers that are differentiated."""


# --- SO(3) in 50 digits ----------------------------------------------------------------------------------------------


def exact(x: Any) -> mp.matrix:
    """Array of floats → mpmath matrix, without rounding."""
    return mp.matrix(np.asarray(x, dtype=float).tolist())


def rounded(m: mp.matrix) -> np.ndarray:
    """Mpmath matrix → array of floats; a column becomes a vector."""
    result = np.array(m.tolist(), dtype=float)
    return result[:, 0] if m.cols == 1 else result


def exact_coefficients(x: Any) -> tuple:
    """a = (1 - cos t)/t², b = (t - sin t)/t³, a'/t, b'/t at t² = x, as hypergeometric functions: no cancellation."""
    z, half = -mp.mpf(x) / 4, mp.mpf(1) / 2
    return (
        mp.hyp1f2(1, 3 * half, 2, z) / 2,
        mp.hyp1f2(1, 2, 5 * half, z) / 6,
        -mp.hyp1f2(2, 5 * half, 3, z) / 12,
        -mp.hyp1f2(2, 3, 7 * half, z) / 60,
    )


def exact_hat(w: mp.matrix) -> mp.matrix:
    return mp.matrix([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def exact_square(theta: mp.matrix) -> Any:
    return sum((t * t for t in theta), mp.mpf(0))


def exact_exp(theta: mp.matrix) -> mp.matrix:
    """Unit quaternion (w, x, y, z)."""
    half = mp.sqrt(exact_square(theta)) / 2
    return mp.matrix([mp.cos(half), *(mp.sinc(half) / 2 * t for t in theta)])


def exact_tangent(theta: mp.matrix) -> mp.matrix:
    a, b, _, _ = exact_coefficients(exact_square(theta))
    m = exact_hat(theta)
    return mp.eye(3) - a * m + b * m * m


def exact_product(p: mp.matrix, q: mp.matrix) -> mp.matrix:
    """Hamilton product."""
    w = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3]
    x = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2]
    y = p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3]
    z = p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1]
    return mp.matrix([w, x, y, z])


# --- poses and mechanisms --------------------------------------------------------------------------------------------


def rotation_of(q: np.ndarray) -> Rotation:
    """R_WB of the last four of seven coordinates; rows allowed."""
    return Rotation.from_quat(q[..., 3:7], scalar_first=True)


def pose(position: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Homogeneous matrix."""
    result = np.eye(4)
    result[:3, 3], result[:3, :3] = position, axes
    return result


def coordinates(*poses: np.ndarray) -> np.ndarray:
    """q of homogeneous matrices."""
    return np.concatenate([[*x[:3, 3], *Rotation.from_matrix(x[:3, :3]).as_quat(scalar_first=True)] for x in poses])


def random_pose(rng: np.random.Generator) -> np.ndarray:
    return pose(rng.uniform(-1, 1, 3), Rotation.random(rng=rng).as_matrix())


def random_frame(rng: np.random.Generator) -> _core.Frame:
    return _core.Frame(rng.uniform(-0.5, 0.5, 3), Rotation.random(rng=rng).as_matrix())


def frame_pose(frame: _core.Frame) -> np.ndarray:
    return pose(frame.origin, frame.axes)


def random_body(rng: np.random.Generator, name: str) -> _core.RigidBody:
    """Mass 0.5 to 2 kg; inertia of the second moments d of a mass distribution, J = tr(d) I - d, turned."""
    body = _core.RigidBody()
    body.name, body.mass = name, rng.uniform(0.5, 2.0)
    moments = np.diag(rng.uniform(0.05, 0.5, 3))
    axes = Rotation.random(rng=rng).as_matrix()
    inertia = axes @ (np.trace(moments) * np.eye(3) - moments) @ axes.T
    body.inertia, body.inertia_products = np.diag(inertia), inertia[[0, 0, 1], [1, 2, 2]]
    return body


def random_coordinates(rng: np.random.Generator, bodies: int) -> np.ndarray:
    return coordinates(*(random_pose(rng) for _ in range(bodies)))


def mass_matrix(definition: _core.Multibody) -> np.ndarray:
    """M from the definition, not from the System."""
    blocks = []
    for body in definition.bodies:
        inertia = np.diag(body.inertia)
        inertia[[0, 0, 1], [1, 2, 2]] = inertia[[1, 2, 2], [0, 0, 1]] = body.inertia_products
        blocks += [body.mass * np.eye(3), inertia]
    return block_diag(*blocks)


Type = _core.JointType
JOINT_TYPES = tuple(Type)


def relative_pose(kind: _core.JointType, free: np.ndarray) -> np.ndarray:
    """Pose of frame 2 in frame 1 with the joint's free coordinates, and nothing else."""
    x, y, z = np.eye(3)
    about_z = Rotation.from_rotvec(free[0] * z)
    any_turn = Rotation.from_rotvec(np.array([1.3, -0.7, 0.4]) + free)
    place, turn = {
        Type.spherical: (0 * z, Rotation.from_rotvec(free[:3])),
        Type.revolute: (0 * z, about_z),
        # about y of frame 1, then about x of frame 2: y1 stays perpendicular to x2
        Type.universal: (0 * z, Rotation.from_rotvec(free[0] * y) * Rotation.from_rotvec(free[1] * x)),
        Type.prismatic: (free[0] * z, Rotation.identity()),
        Type.fixed: (0 * z, Rotation.identity()),
        Type.cylindrical: (free[1] * z, about_z),
        Type.planar: (free[1] * x + free[2] * y, about_z),
        Type.distance: (Rotation.from_rotvec(free).apply(LENGTH * x), any_turn),
        Type.point_on_line: (free[0] * z, any_turn),
        Type.free: (np.array(free), any_turn),
        Type.screw: (LEAD * free[0] * z, about_z),
        # bent by less than a right angle, where the joint is far from its limit
        Type.constant_velocity: (0 * z, Rotation.from_rotvec(0.3 * np.array([free[0], free[1], 0.0]))),
        Type.point_in_plane: (free[0] * x + free[1] * y, any_turn),
        # heading, lean and turn; far from lying flat
        Type.rolling_disk: (
            free[2] * x - 0.4 * free[0] * y + RADIUS * np.sin(LEAN) * z,
            about_z * Rotation.from_rotvec(LEAN * x) * Rotation.from_rotvec(free[1] * z),
        ),
    }[kind]
    return pose(place, turn.as_matrix())


LEAD = 0.5
"""Of the screws of these tests [m/rad]."""
LENGTH = 0.8
"""Of the distance joints of these tests [m]."""
RADIUS, LEAN = 0.4, 1.1
"""Of the rolling disks of these tests [m], and the angle between their axis and the normal where they touch [rad]."""
COORDINATES = {
    Type.revolute: 1,
    Type.universal: 2,
    Type.prismatic: 1,
    Type.cylindrical: 2,
    Type.planar: 3,
    Type.point_on_line: 1,
    Type.free: 3,
    Type.screw: 2,
    Type.point_in_plane: 2,
}
"""How many coordinates a joint has, the first of the `free` ones of `relative_pose`; other types have none."""
EQUATIONS = dict(zip(JOINT_TYPES, (3, 5, 4, 5, 6, 4, 3, 1, 2, 0, 5, 4, 1, 3), strict=True))
VELOCITY_EQUATIONS = {Type.rolling_disk: 2}
"""How many of them, the last ones, are of velocities alone, if any."""


def make_joint(name: str, kind: _core.JointType, *bodies_and_frames: Any) -> _core.Joint:
    """A joint; those that keep a distance keep LENGTH, screws have the pitch of LEAD, disks RADIUS."""
    joint = _core.Joint(name, kind, *bodies_and_frames)
    if kind == Type.screw:
        joint.pitch = 2 * np.pi * LEAD
    if kind == Type.distance:
        joint.length = LENGTH
    if kind == Type.rolling_disk:
        joint.radius = RADIUS
    return joint


def to_touching_point(frame1: np.ndarray, frame2: np.ndarray) -> np.ndarray:
    """From the centre of a rolling disk to where it touches the plane, by the axes (columns) of both frames in W."""
    normal, axis = frame1[:, 2], frame2[:, 2]
    up = normal - axis * (normal @ axis)
    return -RADIUS * up / np.linalg.norm(up)


@dataclass
class Tree:
    """A mechanism without loops, in a configuration q that satisfies its joints' equations."""

    definition: _core.Multibody
    q: np.ndarray
    joints: list  # (type, body 1, frame 1, body 2, frame 2)
    springs: list  # (body 1, point 1, body 2, point 2, stiffness, damping)
    loads: list  # (body, force, torque)
    joint_springs: list = field(default_factory=list)  # (joint, coordinate, stiffness, damping, rest)


def random_tree(rng: np.random.Generator, bodies: int = 3, *, joint_springs: bool = True) -> Tree:
    """Each body hangs on one before it or on the ground, by a joint of any type; springs, loads and gravity."""
    tree = Tree(_core.Multibody(), np.zeros(0), [], [], [])
    tree.definition.gravity = rng.uniform(-10, 10, 3)
    poses = {GROUND: np.eye(4)}
    for i in range(bodies):
        parent, kind = int(rng.integers(-1, i)), JOINT_TYPES[rng.integers(len(JOINT_TYPES))]
        one, two = random_frame(rng), random_frame(rng)
        relative = relative_pose(kind, rng.uniform(-1, 1, 3))
        joint = (kind, parent, one, i, two)
        if rng.random() < 0.3:  # the other way round
            joint, relative = (kind, i, two, parent, one), np.linalg.inv(relative)
        poses[i] = poses[parent] @ frame_pose(one) @ relative @ np.linalg.inv(frame_pose(two))
        tree.joints.append(joint)
        tree.definition.add(random_body(rng, f"body{i}"))
    tree.q = coordinates(*(poses[i] for i in range(bodies)))
    for i, joint in enumerate(tree.joints):
        tree.definition.add(make_joint(f"joint{i}", *joint))
    for i in range(3):
        one, two = (int(k) for k in rng.choice(range(-1, bodies), 2, replace=False))
        points, constants = rng.uniform(-0.5, 0.5, (2, 3)), rng.uniform(0, 20, (2, 3))
        tree.springs.append((one, points[0], two, points[1], *constants))
        tree.definition.add(_core.SpringDamper(f"spring{i}", *tree.springs[-1]))
    for i in range(2):
        tree.loads.append((int(rng.integers(bodies)), *rng.uniform(-5, 5, (2, 3))))
        tree.definition.add(_core.Load(f"load{i}", *tree.loads[-1]))
    for i, (kind, *_) in enumerate(tree.joints):
        for k in range(COORDINATES.get(kind, 0)):
            if joint_springs and rng.random() < 0.5:
                stiffness, damping, rest = rng.uniform(0, 5, 3)
                tree.joint_springs.append((i, k, stiffness, damping, rest))
                tree.definition.add(_core.JointSpring(i, stiffness, damping, rest, k))
    return tree


# --- runs ------------------------------------------------------------------------------------------------------------

INDEX3, INDEX2, STABILIZED = 1, 2, 3
RESIDUAL, INCREMENTAL = 1, 2
FULL, TANGENT_FREE, MODIFIED = 1, 2, 2
FORMULATIONS = {"index3": INDEX3, "index2": INDEX2, "stabilizedIndex2": STABILIZED}


def simulation(mechanism: str | _core.Mechanism, **chosen: Any) -> _core.Simulation:
    """A mechanism with changed integrator settings, at its start."""
    if isinstance(mechanism, str):
        mechanism = _core.mechanism(mechanism)
    for name, value in chosen.items():
        getattr(mechanism.integrator, name)  # a misspelt setting fails
        setattr(mechanism.integrator, name, value)
    return _core.Simulation(mechanism)


def state_arrays(state: _core.State) -> dict[str, np.ndarray]:
    """Everything a step leaves behind, for bitwise comparison."""
    names = ("time", "q", "v", "vdot", "a", "lambda_", "turned")
    counters = [getattr(state.counters, n) for n in ("steps", "newton_iterations", "jacobian_evaluations", "retries")]
    return {**{name: np.atleast_1d(getattr(state, name)) for name in names}, "counters": np.array(counters)}


def assert_bitwise(one: _core.State, other: _core.State) -> None:
    theirs = state_arrays(other)
    for name, values in state_arrays(one).items():
        assert values.tobytes() == theirs[name].tobytes(), name


@cache
def reference(model: str, stop: float, samples: int) -> History:
    """The independent solution at `samples` equal intervals up to `stop`."""
    return solve(model, np.linspace(0.0, stop, samples + 1))


def columns(history: History, name: str, size: int = 3) -> np.ndarray:
    return np.column_stack([history[c] for c in vector_columns(name, size)])


BODIES = {"HeavyTop": ("top",), "HighSpeedRotor": ("rotor",), "SliderCrank": ("crank", "rod", "slider")}
JOINTS = {"HeavyTop": ("pivot",), "HighSpeedRotor": (), "SliderCrank": ("crankPivot", "crankPin", "wristPin", "guide")}


def errors(model: str, reference: History, q: np.ndarray, v: np.ndarray, multipliers: np.ndarray) -> dict[str, float]:
    """Largest differences to the independent solution at its times, per kind of quantity.

    Rows of q, v and multipliers belong to the times of the reference. Multipliers are compared as the joints' reaction
    forces, which is all of them that the independent solution knows.
    """
    system = _core.System(_core.mechanism(model).multibody)
    rows = {"position": [], "orientation": [], "velocity": [], "angularVelocity": [], "reaction": [np.zeros(1)]}
    for i, body in enumerate(BODIES[model]):
        qi, vi = q[:, 7 * i : 7 * i + 7], v[:, 6 * i : 6 * i + 6]
        turn = Rotation.from_quat(columns(reference, f"{body}.quaternion", 4), scalar_first=True)
        rows["position"].append(qi[:, :3] - columns(reference, f"{body}.position"))
        rows["orientation"].append((turn.inv() * rotation_of(qi)).as_rotvec())
        rows["velocity"].append(vi[:, :3] - columns(reference, f"{body}.velocity"))
        rows["angularVelocity"].append(vi[:, 3:] - columns(reference, f"{body}.angularVelocity"))
    for j, joint in enumerate(JOINTS[model]):
        ours = [system.reaction(*row, j)[0] for row in zip(q, v, multipliers, strict=True)]
        rows["reaction"].append(np.array(ours) - columns(reference, f"{joint}.reactionForce"))
    result = {kind: max(float(np.abs(part).max()) for part in parts) for kind, parts in rows.items()}
    return result if JOINTS[model] else {kind: error for kind, error in result.items() if kind != "reaction"}
