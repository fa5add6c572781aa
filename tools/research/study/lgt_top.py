"""Chapter: why the heavy top is less accurate on SE(3), by an experiment that leaves its motion alone.

The motion about the pivot depends on the inertia J_P = J + m d² about the pivot, the spin's J_y and the moment m g d.
So the share f = m d²/J_P of the mass can be varied with g such that the motion and the independent solution stay.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from research.measure import columns
from research.reference import GRAVITY, TOP, TOP_PIVOT
from research.study import lgt, runs
from research.study.chapter import Cell, Results
from research.study.lgt import METHODS, Combination
from research.study.output import figure, write_csv
from sigmafmu import _core
from sigmafmu.markdown import markdown_table

TIGHT = {"relative_tolerance": 1e-12, "absolute_tolerance": 1e-12}
ARM = float(np.linalg.norm(TOP_PIVOT))  # d, m
PIVOT_INERTIA = TOP.inertia[0] + TOP.mass * ARM**2  # J_P across the axis, kg m2
PAPER_SHARE = TOP.mass * ARM**2 / PIVOT_INERTIA
SHARES = (0.01, 0.1, 0.25, 0.5, 0.75, 0.9, PAPER_SHARE)
QUICK_SHARES = (0.1, 0.5, PAPER_SHARE)
THEORY_SHARES = np.linspace(0.0, PAPER_SHARE, 50)
STEPS = {"generalizedAlpha": 5e-4, "bliedf2": 5e-4, "rkmk4": 1e-3}  # s
STOP_TIME = 0.5  # s
GROUPS = {group: Combination(group, "exp") for group in lgt.GROUPS}


def shares(method: str, fractions: tuple[float, ...]) -> dict[str, Any]:
    """Largest position errors [m] on both groups for each f, and how far R³×SO(3) is from `mixture`."""
    path = {group: [_error_path(method, c, f) for f in fractions] for group, c in GROUPS.items()}
    mixed = path["R3xSO3"]
    deviation = [
        _largest(e - mixture(f, path["SE3"][-1], mixed[-1], fractions[-1])) / _largest(e)
        for e, f in zip(mixed, fractions, strict=True)
    ]
    return {
        "share": list(fractions),
        **{group: [_largest(e) for e in errors] for group, errors in path.items()},
        "deviation": deviation,
        "theory": [_largest(mixture(f, path["SE3"][-1], mixed[-1], fractions[-1])) for f in THEORY_SHARES],
    }


def mixture(f: float, rotation: np.ndarray, known: np.ndarray, known_f: float) -> np.ndarray:
    """Error on R³×SO(3) if it is (1 − f) times that of the rotation plus f times that of the translation.

    The first is the one on SE(3); the second follows from a `known` error at f = `known_f`.
    """
    translation = (known - (1 - known_f) * rotation) / known_f
    return (1 - f) * rotation + f * translation


def twin() -> dict[str, float]:
    """Largest distance [m] of rkmk4 on each group from the same method on SO(3) about the pivot."""
    h = STEPS["rkmk4"]
    path = rotation_about_pivot(h, round(STOP_TIME / h))
    return {group: _largest(_path("rkmk4", c, PAPER_SHARE, h) - path) for group, c in GROUPS.items()}


def rotation_about_pivot(h: float, steps: int) -> np.ndarray:
    """Path of the centre of mass, (steps + 1, 3): classical Munthe-Kaas Runge-Kutta method on SO(3), three unknowns."""
    lie = _core.lie
    d = -TOP_PIVOT
    inertia = np.array(TOP.inertia) + TOP.mass * (d @ d - d**2)  # d is a principal axis

    def rates(quaternion: np.ndarray, x: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        R = lie.rotation_matrix(turned(quaternion, x))
        torque = TOP.mass * np.cross(d, R.T @ GRAVITY)
        return lie.tangent_inverse_times(x, w), (torque - np.cross(w, inertia * w)) / inertia

    def turned(quaternion: np.ndarray, x: np.ndarray) -> np.ndarray:
        return lie.compose(np.concatenate([np.zeros(3), quaternion]), np.concatenate([np.zeros(3), x]))[3:]

    quaternion, w = np.array([1.0, 0.0, 0.0, 0.0]), np.array(TOP.angular_velocity)
    path = [d]
    for _ in range(steps):
        x, w_change = runge_kutta(lambda y, Q=quaternion: np.concatenate(rates(Q, *np.split(y, 2))), w, h)
        quaternion, w = turned(quaternion, x), w + w_change
        path.append(lie.rotation_matrix(quaternion) @ d)
    return np.array(path)


def runge_kutta(rate: Callable[[np.ndarray], np.ndarray], V: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """One classical step of y = (X, V) from X = 0: X and the change of V."""
    start = np.concatenate([np.zeros_like(V), V])
    k1 = rate(start)
    k2 = rate(start + h / 2 * k1)
    k3 = rate(start + h / 2 * k2)
    k4 = rate(start + h * k3)
    X, change = np.split(h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), 2)
    return X, change


def _path(method: str, combination: Combination, f: float, h: float) -> np.ndarray:
    """Position after every step, (steps + 1, 3)."""
    definition = _core.mechanism("HeavyTop")
    body = definition.multibody.body(0)
    mass = f * PIVOT_INERTIA / ARM**2
    body.mass = mass
    body.inertia = np.array([(1 - f) * PIVOT_INERTIA, TOP.inertia[1], (1 - f) * PIVOT_INERTIA])
    definition.multibody.gravity = GRAVITY * TOP.mass / mass
    for name, value in {"step_size": h, **TIGHT, **METHODS[method], **combination.settings}.items():
        setattr(definition.integrator, name, value)
    _, q, _, _ = _core.Simulation(definition).trajectory(STOP_TIME, round(STOP_TIME / h))
    return q[:, :3]


def _error_path(method: str, combination: Combination, f: float) -> np.ndarray:
    path = _path(method, combination, f, STEPS[method])
    return path[:: (len(path) - 1) // runs.SAMPLES] - columns(runs.exact("HeavyTop", STOP_TIME), "top.position")


def _largest(difference: np.ndarray) -> float:
    return float(np.linalg.norm(difference, axis=1).max())


class Top:
    """Errors over the share of the mass."""

    name = "lgt_top"
    title = "Local-global transition maps: what decides between the groups"
    mechanisms = ("HeavyTop",)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each method, and the twin on SO(3)."""
        fractions = QUICK_SHARES if quick else SHARES
        return [Cell(method, shares, (method, fractions)) for method in STEPS] + [Cell("twin", twin, ())]

    def report(self, results: Results, folder: Path) -> str:
        """The explanation with a figure and a table."""
        found = results["HeavyTop"]
        curves = {key: cell for key, cell in found.items() if key in STEPS}
        write_csv(folder / "lgt_top.csv", _rows(curves), ("method", "h", "share", *GROUPS, "deviation"))
        _draw(folder / "lgt_top.png", curves)
        distance = found["twin"]
        flat = max(np.ptp(cell["SE3"]) / max(cell["SE3"]) for cell in curves.values())
        return (
            "On SE(3) a body on a spherical joint to the ground stays in the subgroup of rotations about the joint. "
            f"What is integrated there is the rotation about the pivot: rkmk4 on SE(3) and the same method on SO(3), "
            f"with three unknowns and without a constraint, differ by {distance['SE3']:.1e} m over {STOP_TIME:g} s, "
            f"R³×SO(3) from both by {distance['R3xSO3']:.1e} m.\n\n"
            "On R³×SO(3) the translation of the centre of mass and the rotation about it are integrated beside each "
            "other, and the joint makes one motion of the two, in the mass metric: with f = m d²/J_P, the share of the "
            "mass in the inertia about the pivot, the error is (1 − f) times that of the rotation plus f times that of "
            "the translation. The heavy top of the literature is nearly a point mass, "
            f"f = {PAPER_SHARE:.3f}; its centre of mass moves slowly in W while body-fixed velocities turn with the "
            "spin, so the translation is far more accurate than the rotation.\n\n"
            "The test: mass, inertia and g are changed such that f goes down while the motion about the pivot stays "
            f"as it is. Errors on SE(3) do not change (by {flat:.0e} of their value at most), those on R³×SO(3) go "
            "over to them as theory has it (thin line, from the errors on SE(3) and at the largest f). *deviation*: "
            "distance from that theory, as vectors over the whole run, over the error.\n\n"
            f"![HeavyTop: error over the share of the mass](lgt_top.png)\n\n{_table(curves)}\n"
            "So SE(3) loses where a body's centre of mass moves more smoothly in W than the body-fixed twist does, "
            "and the joint lets that motion count: heavy bodies, far from the joint, that spin. With the mass near the "
            "joint both groups are equally accurate.\n"
        )


def _rows(curves: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    return [
        {"method": method, "h": STEPS[method], **{name: cell[name][i] for name in ("share", *GROUPS, "deviation")}}
        for method, cell in curves.items()
        for i in range(len(cell["share"]))
    ]


def _draw(path: Path, curves: Mapping[str, Mapping[str, Any]]) -> None:
    with figure(path, (9.0, 3.6)) as result:
        for axes, (method, cell) in zip(result.subplots(1, len(curves)), curves.items(), strict=True):
            share = np.array(cell["share"])
            for group, c in GROUPS.items():
                axes.plot(share, cell[group], **{**c.style, "linestyle": "none"}, label=c.name.split(",")[0])
            axes.plot(THEORY_SHARES, cell["theory"], color="0.5", linewidth=0.8)
            axes.set(xlabel="f = m d² / J_P", ylim=(0, None), title=f"{method}, h = {STEPS[method]:g} s")
            axes.ticklabel_format(axis="y", scilimits=(0, 0))
        result.axes[0].set_ylabel("position error in m")
        result.axes[0].legend(fontsize=8)


def _table(curves: Mapping[str, Mapping[str, Any]]) -> str:
    rows = [
        [r["method"], f"{r['share']:.3f}", f"{r['SE3']:.3e}", f"{r['R3xSO3']:.3e}", f"{r['deviation']:.1%}"]
        for r in _rows(curves)
    ]
    return markdown_table(["method", "f", "SE(3), exp [m]", "R³×SO(3), exp [m]", "deviation"], rows)


CHAPTER = Top()
