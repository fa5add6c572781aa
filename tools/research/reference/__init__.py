"""Reference solutions of the benchmark mechanisms, made without any code of the FMUs.

Two sources that share nothing but the numbers in this file:

- `exudyn_models`: redundant coordinates and constraints, solved by Exudyn (a peer code);
- `minimal_coordinates`: no constraints at all, solved by SciPy's DOP853.

`make` writes `tests/references/<Model>.csv` from the first and states the distance to the second. For the mechanisms
with a flexible body it is the other way round (`flexible`, `make_flexible`); `segments` is a third source for them.

SI units. W is the inertial frame, B a body's frame at its centre of mass (COM). Columns carry the variable names of the
FMUs, so a reference can be compared with a simulation result by name; `time` is the first column.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sigmafmu.compare import History

GRAVITY = np.array([0.0, 0.0, -9.81])  # m/s2, in W


@dataclass(frozen=True)
class Body:
    """Inertia and initial state of a rigid body; every point of the body is given from its COM, in B."""

    name: str
    mass: float  # kg
    inertia: tuple[float, float, float]  # kg m2, principal moments about the COM, in B
    position: tuple[float, float, float]  # m, COM at t = 0, in W
    velocity: tuple[float, float, float]  # m/s, COM at t = 0, in W
    angular_velocity: tuple[float, float, float]  # rad/s at t = 0, in W
    rotation: tuple[tuple[float, ...], ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))  # R_WB at t = 0


# Heavy top: Brüls, Cardona, Arnold, Lie group generalized-alpha time integration of constrained flexible multibody
# systems, Mech. Mach. Theory 48 (2012), section 6.1.
TOP = Body("top", 15.0, (0.234375, 0.46875, 0.234375), (0.0, 1.0, 0.0), (4.61538, 0.0, 0.0), (0.0, 150.0, -4.61538))
TOP_PIVOT = np.array([0.0, -1.0, 0.0])  # m, the body point held at the origin of W


@dataclass(frozen=True)
class Rotor:
    """High-speed rotor: Holzinger, Arnold, Gerstmayr (2025), Table 1. The rotor's axis is its x axis."""

    mass: float = 1.223  # kg
    inertia: tuple[float, float, float] = (0.001541, 0.000812, 0.000812)  # kg m2
    spin: float = 20944.0  # rad/s about x
    stiffness: float = 4000.0  # N/m, of each support and in each of its axes
    damping: float = 5.165093  # N s/m, acts on the absolute velocity of the point on the axis
    left: float = 0.11  # m, COM to the left support, at x = -left; holds x, y and z
    right: float = 0.09  # m, COM to the right support, at x = +right; holds y and z

    @property
    def torque(self) -> np.ndarray:
        """Constant torque in W, N m: the moment (L/2 − L_L) m g of an offset weight, L = L_L + L_R."""
        offset = 0.5 * (self.left + self.right) - self.left
        return np.array([0.0, 0.0, -offset * self.mass * 9.81])

    @property
    def body(self) -> Body:
        """The rotor at rest on its supports, spinning."""
        return Body("rotor", self.mass, self.inertia, (0.0,) * 3, (0.0,) * 3, (self.spin, 0.0, 0.0))


CONSISTENT_ROTOR = Rotor(
    mass=1.23307511653,
    inertia=(0.00154134390, 0.000811774452, 0.000811774452),
    spin=20943.9510239,
    damping=5.16509296991,
)
"""Table 1 contradicts itself: its J and d belong to this steel disk (7850 kg/m3, radius 0.05 m, width 0.02 m)."""

# Spatial slider-crank: IFToMM library of computational benchmark problems. Crank about W x, slider along W x. The rod's
# frame at t = 0 is written out, since published models differ in the universal joint: here slider e_x ⟂ rod e_y.
_EX = np.array([2.0, -1.0, -2.0]) / 3.0
_EY = np.array([0.0, 2.0, -1.0]) / np.sqrt(5.0)
_EZ = np.array([5.0, 2.0, 4.0]) / (3.0 * np.sqrt(5.0))
CRANK = Body("crank", 0.12, (1e-4, 1e-4, 1e-5), (0.0, 0.1, 0.16), (0.0, -0.24, 0.0), (6.0, 0.0, 0.0))
ROD = Body(
    "rod",
    0.5,
    (4e-4, 4e-3, 4e-3),
    (0.1, 0.05, 0.1),
    (0.12, -0.24, 0.0),
    (1.92, -0.96, 0.48),
    tuple(map(tuple, np.column_stack([_EX, _EY, _EZ]))),
)
SLIDER = Body("slider", 2.0, (1e-4, 1e-4, 1e-4), (0.2, 0.0, 0.0), (0.24, 0.0, 0.0), (0.0, 0.0, 0.0))
CRANK_CENTRE = np.array([0.0, 0.1, 0.12])  # m, point A in W
CRANK_LENGTH = 0.08  # m, A to B, along the crank's z
ROD_LENGTH = 0.3  # m, B to C, along the rod's x

STOP_TIME = {"HeavyTop": 2.0, "HighSpeedRotor": 1.0, "SliderCrank": 5.0}  # s, span of the reference files
SAMPLE_STEP = {"HeavyTop": 0.01, "HighSpeedRotor": 0.005, "SliderCrank": 0.01}  # s, their output grid
MODELS = tuple(STOP_TIME)

FLEXIBLE_STOP_TIME = {"FlexiblePendulum": 2.0, "FlexibleSliderCrank": 2.0, "SpinUpBeam": 20.0}  # s
FLEXIBLE_SAMPLE_STEP = {"FlexiblePendulum": 0.01, "FlexibleSliderCrank": 0.01, "SpinUpBeam": 0.05}  # s
FLEXIBLE_MODELS = tuple(FLEXIBLE_STOP_TIME)


def vector_columns(name: str, size: int = 3) -> list[str]:
    """Column names of a vector: name[1] … name[size]."""
    return [f"{name}[{i}]" for i in range(1, size + 1)]


def add_vector(history: History, name: str, values: np.ndarray) -> None:
    """Store the columns of values (samples × size) under name[1], name[2], …"""
    for column, samples in zip(vector_columns(name, values.shape[1]), values.T, strict=True):
        history[column] = samples


def continuous_sign(quaternions: np.ndarray) -> np.ndarray:
    """Choose the sign of unit quaternions (rows w, x, y, z): w ≥ 0 at first, then the one nearer to the row before."""
    dots = np.einsum("ij,ij->i", quaternions[1:], quaternions[:-1])
    signs = np.cumprod(np.concatenate([[1.0 if quaternions[0, 0] >= 0 else -1.0], np.where(dots < 0, -1.0, 1.0)]))
    return quaternions * signs[:, None]


def quaternions_from_matrices(rotations: np.ndarray) -> np.ndarray:
    """Unit quaternions (w, x, y, z) of rotation matrices (n × 3 × 3), sign continuous.

    The largest of the four components is taken from the diagonal, the others from sums and differences beside it
    (Shepperd, J. Guidance and Control 1 (1978) 223), so that nothing is divided by a small number.
    """
    r = rotations
    trace = r[:, 0, 0] + r[:, 1, 1] + r[:, 2, 2]
    squares = np.stack([1 + trace, *(1 + 2 * r[:, i, i] - trace for i in range(3))], axis=1)  # 4 q_i²
    w_products = [r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]]  # 4 w q_i
    xy, xz, yz = r[:, 0, 1] + r[:, 1, 0], r[:, 0, 2] + r[:, 2, 0], r[:, 1, 2] + r[:, 2, 1]  # 4 x y, 4 x z, 4 y z
    products = np.stack(
        [
            np.stack([squares[:, 0], *w_products], axis=1),
            np.stack([w_products[0], squares[:, 1], xy, xz], axis=1),
            np.stack([w_products[1], xy, squares[:, 2], yz], axis=1),
            np.stack([w_products[2], xz, yz, squares[:, 3]], axis=1),
        ],
        axis=1,
    )  # 4 q qᵀ
    row = products[np.arange(len(r)), np.argmax(squares, axis=1)]
    return continuous_sign(row / np.linalg.norm(row, axis=1, keepdims=True))


GROUPS = {
    "position": "m",
    "quaternion": "1",
    "velocity": "m/s",
    "angularVelocity": "rad/s",
    "angle": "rad",
    "modal": "m",
    "modalRate": "m/s",
    "energy": "J",
    "reactionForce": "N",
}
"""Kind of quantity → unit, for statements about errors."""


_SAME_KIND = {
    "displacement": "position",
    "deflection": "position",
    "rate": "velocity",
    "angularRate": "angularVelocity",
    "kinetic": "energy",
    "potential": "energy",
}


def group_of(column: str) -> str:
    """Kind of quantity of a column: `top.position[1]` → position, `guide.displacement` → position."""
    kind = column.rpartition(".")[2].partition("[")[0]
    return _SAME_KIND.get(kind, kind)


def differences(history: History, reference: History) -> dict[str, float]:
    """Largest difference of two histories with the same columns and times, per kind of quantity.

    A quaternion and its negative are the same orientation; the sign with the smaller difference counts.
    """
    if list(history) != list(reference) or not np.array_equal(history["time"], reference["time"]):
        raise ValueError("the histories have different columns or times")
    result: dict[str, float] = {}
    for column in history:
        if column == "time" or column.endswith((".quaternion[2]", ".quaternion[3]", ".quaternion[4]")):
            continue
        group, columns = group_of(column), [column]
        if group == "quaternion":
            columns = vector_columns(column.removesuffix("[1]"), 4)
        ours, theirs = (np.column_stack([h[c] for c in columns]) for h in (history, reference))
        distance = np.abs(ours - theirs).max(axis=1)
        if group == "quaternion":
            distance = np.minimum(distance, np.abs(ours + theirs).max(axis=1))
        result[group] = max(result.get(group, 0.0), float(distance.max()))
    return {group: result[group] for group in GROUPS if group in result}
