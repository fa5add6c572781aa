"""Chapter: integration schemes for vector spaces as black boxes on the local model (section 6.3 of the paper).

In every step the state (X, V) starts at X = 0, a scheme that knows nothing of groups integrates (55)-(58) in index 1

    dX/dt = T(X)⁻¹ V,   dV/dt = f(τ(q_k, X), V),

and q_{k+1} = τ(q_k, X). All but the maps and the accelerations is written here, in NumPy: an independent check of the
Munthe-Kaas methods in C++.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from research.measure import TRACKED, columns
from research.reference.minimal_coordinates import solve
from research.study import runs
from research.study.chapter import Cell, Results
from research.study.lgt import ABSOLUTE, COMBINATIONS, METHODS, Combination, number
from research.study.lgt_rkmk54 import adaptive
from research.study.output import write_csv
from sigmafmu import _core
from sigmafmu.markdown import markdown_table

SETUPS = {"HeavyTop": (5e-3, 100, 1e-3), "HighSpeedRotor": (5e-5, 40, 1e-5), "SliderCrank": (2e-2, 25, 5e-3)}
"""Step of the black boxes [s] and their number; step of rkmk4 [s]."""
QUICK_COUNT = 3
TWIN_STEPS, QUICK_TWIN_STEPS = 200, 20
BLACK_BOXES: dict[str, dict[str, Any]] = {
    "DOP853": {"rtol": 1e-12, "atol": 1e-14},
    "Radau": {"rtol": 1e-9, "atol": 1e-11},
}
"""SciPy's explicit Runge-Kutta method of order 8 and the implicit one of order 5."""
PEER_TOLERANCE = 1e-12
HEADER = (
    "mechanism",
    "scheme",
    "table1",
    "group",
    "map",
    "absolute",
    "position",
    "velocity",
    "rkmk54",
    "calls",
    "drift",
)


class LocalModel:
    """The mechanism in the local coordinates of one combination, and what a step starts from."""

    def __init__(self, mechanism: str, combination: Combination) -> None:
        definition = _core.mechanism(mechanism)
        self.system = _core.System(definition.multibody)
        self.lie = getattr(_core.lie, combination.core)
        self.vectors = combination.absolute == "rotationVector"
        self.tau = self.lie.tau_rotation_vector if self.vectors else self.lie.tau_quaternion
        state = _core.Simulation(definition).state
        self.inputs = np.zeros(self.system.input_size)
        self.take(state.q, state.v)

    def take(self, q: np.ndarray, v: np.ndarray) -> None:
        """Start at q (positions, quaternions) with mixed velocities v; afterwards X = 0."""
        self.q, self.v = np.array(q), np.array(v)
        poses = self.q.reshape(-1, 7)
        self.absolute = [np.concatenate([p[:3], _core.lie.log(p[3:])]) if self.vectors else p for p in poses]
        self.V = np.concatenate(
            [self.lie.velocity(p[3:], v) for p, v in zip(poses, self.v.reshape(-1, 6), strict=True)]
        )

    def mixed(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """q as poses (bodies, 7), X and V (bodies, 6) of y = (X, V)."""
        X, V = (part.reshape(-1, 6) for part in np.split(y, 2))
        moved = [self.tau(q, x) for q, x in zip(self.absolute, X, strict=True)]
        if self.vectors:
            moved = [np.concatenate([q[:3], _core.lie.exp(q[3:])]) for q in moved]
        return np.array(moved), X, V

    def rate(self, y: np.ndarray) -> np.ndarray:
        """dy/dt."""
        poses, X, V = self.mixed(y)
        v = np.array([self.lie.mixed_velocity(p[3:], w) for p, w in zip(poses, V, strict=True)])
        vdot, _ = self.system.accelerations(poses.ravel(), v.ravel(), self.inputs)
        Xdot = [self.lie.tangent_inverse_times(x, w) for x, w in zip(X, V, strict=True)]
        Vdot = [self.lie.acceleration(p[3:], w, a) for p, w, a in zip(poses, v, vdot.reshape(-1, 6), strict=True)]
        return np.concatenate([*Xdot, *Vdot])

    def step(self, scheme: Callable[[np.ndarray], np.ndarray], project: bool = False) -> None:
        """(X, V) at the end of the step from `scheme`, then q = τ(q, X); projected onto the constraints if wanted."""
        poses, _, V = self.mixed(scheme(np.concatenate([np.zeros_like(self.V), self.V])))
        q = poses.ravel()
        v = np.concatenate([self.lie.mixed_velocity(p[3:], w) for p, w in zip(poses, V, strict=True)])
        if project:
            q = self.system.project_positions(q)
            v = self.system.project_velocities(q, v)
        self.take(q, v)


def classical(model: LocalModel, h: float) -> Callable[[np.ndarray], np.ndarray]:
    """The classical Runge-Kutta method."""

    def step(y: np.ndarray) -> np.ndarray:
        k1 = model.rate(y)
        k2 = model.rate(y + h / 2 * k1)
        k3 = model.rate(y + h / 2 * k2)
        k4 = model.rate(y + h * k3)
        return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    return step


def black_box(
    mechanism: str, scheme: str, group: str, coordinate_map: str, absolute: str, count: int
) -> dict[str, Any]:
    """Errors of SciPy's `scheme` over `count` steps, distance from rkmk54, calls in a step, |Φ| at the end."""
    H, _, _ = SETUPS[mechanism]
    combination = Combination(group, coordinate_map, absolute)
    model = LocalModel(mechanism, combination)
    calls = 0

    def integrate(y: np.ndarray) -> np.ndarray:
        nonlocal calls
        solution = solve_ivp(lambda _, y: model.rate(y), (0.0, H), y, method=scheme, **BLACK_BOXES[scheme])
        calls += solution.nfev
        return solution.y[:, -1]

    q, v = [model.q], [model.v]
    for _ in range(count):
        model.step(integrate)
        q.append(model.q)
        v.append(model.v)
    history = runs.body_history(mechanism, np.array(q), np.array(v))
    reference = solve(mechanism, H * np.arange(count + 1))
    peer = runs.simulation(mechanism, H, **adaptive(PEER_TOLERANCE), **combination.settings)
    _, peer_q, _, _ = peer.trajectory(count * H, count)
    body, name = TRACKED[mechanism]
    phi, *_ = model.system.constraints(model.q, model.v)
    position = slice(7 * body, 7 * body + 3)
    return {
        "position": _largest(columns(history, f"{name}.position") - columns(reference, f"{name}.position")),
        "velocity": _largest(columns(history, f"{name}.velocity") - columns(reference, f"{name}.velocity")),
        "rkmk54": _largest(np.array(q)[:, position] - peer_q[:, position]),
        "calls": calls / count,
        "drift": float(np.abs(phi).max(initial=0.0)),
    }


def twin(mechanism: str, group: str, coordinate_map: str, absolute: str, count: int) -> dict[str, Any]:
    """Largest differences between rkmk4 and the classical Runge-Kutta method on the local model after `count` steps.

    Of positions [m], and of velocities relative to the largest one.
    """
    _, _, h = SETUPS[mechanism]
    combination = Combination(group, coordinate_map, absolute)
    model = LocalModel(mechanism, combination)
    for _ in range(count):
        model.step(classical(model, h), project=model.system.constraint_size > 0)
    run = runs.simulation(mechanism, h, **METHODS["rkmk4"], **combination.settings)
    run.run(count * h, count)
    positions = (run.state.q - model.q).reshape(-1, 7)[:, :3]
    return {
        "position": float(np.abs(positions).max()),
        "velocity": float(np.abs(run.state.v - model.v).max() / np.abs(model.v).max()),
    }


def _largest(difference: np.ndarray) -> float:
    return float(np.linalg.norm(difference, axis=1).max())


class VectorSpace:
    """Black boxes and the twin of rkmk4."""

    name = "lgt_vector_space"
    title = "Local-global transition maps: vector-space schemes (section 6.3)"
    mechanisms = tuple(SETUPS)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each scheme and combination; rotation vectors with DOP853 and the twin only."""
        count = QUICK_COUNT if quick else SETUPS[mechanism][1]
        result = []
        for absolute in ABSOLUTE:
            for c in COMBINATIONS:
                names = (c.group, c.map, absolute)
                for scheme in BLACK_BOXES if absolute == "quaternion" else ("DOP853",):
                    arguments = (mechanism, scheme, *names, count)
                    result.append(Cell("/".join((scheme, *names)), black_box, arguments))
                steps = QUICK_TWIN_STEPS if quick else TWIN_STEPS
                result.append(Cell("/".join(("twin", *names)), twin, (mechanism, *names, steps)))
        return result

    def report(self, results: Results, folder: Path) -> str:
        """A table for each mechanism."""
        write_csv(folder / "lgt_vector_space.csv", _rows(results), HEADER)
        parts = [
            f"{__doc__.split(chr(10) * 2, 1)[1].strip()}\n",
            "Black boxes are SciPy's, started anew in every step: "
            + ", ".join(f"{name} (rtol {s['rtol']:g})" for name, s in BLACK_BOXES.items())
            + f". Nothing is projected. *rkmk54*: distance from rkmk54 with tolerance {PEER_TOLERANCE:g}; *calls*: of "
            "the model in a step; *|Φ|*: constraint residual at the end. Every combination gives the same motion: with "
            "the local model solved exactly nothing is left of the map but the work that it makes.\n",
        ]
        for mechanism, found in results.items():
            H, _, h = SETUPS[mechanism]
            twins = [cell for key, cell in found.items() if key.startswith("twin")]
            vectors = [c["position"] for k, c in found.items() if k.startswith("DOP853") and "rotationVector" in k]
            parts.append(f"### {mechanism}\n\nSteps of {H:g} s, quaternions:\n\n{_table(found)}")
            parts.append(f"With rotation vectors and DOP853: at most {max(vectors):.1e} m.\n")
            parts.append(
                f"The classical Runge-Kutta method in NumPy with h = {h:g} s, projected, beside rkmk4, all "
                f"{len(twins)} combinations: positions differ by {max(t['position'] for t in twins):.1e} m, velocities "
                f"by {max(t['velocity'] for t in twins):.1e} of the largest.\n"
            )
        return "\n".join(parts)


def _rows(results: Results) -> list[dict[str, Any]]:
    rows = []
    for mechanism, found in results.items():
        for key, cell in found.items():
            scheme, *names = key.split("/")
            c = Combination(*names)
            own = {"mechanism": mechanism, "scheme": scheme, "group": c.group, "map": c.map, "absolute": c.absolute}
            rows.append({**own, "table1": c.table1, **cell})
    return rows


def _table(found: Mapping[str, Mapping[str, Any]]) -> str:
    rows = []
    for key, cell in found.items():
        scheme, *names = key.split("/")
        c = Combination(*names)
        if scheme not in BLACK_BOXES or c.absolute != "quaternion":
            continue
        figures = [number(cell[name]) for name in ("position", "velocity", "rkmk54")]
        rows.append([scheme, c.table1, c.name, *figures, f"{cell['calls']:.0f}", number(cell["drift"])])
    header = [
        "scheme",
        "Table 1",
        "group, map",
        "position [m]",
        "velocity [m/s]",
        "rkmk54 [m]",
        "calls",
        "|Φ|",
    ]
    return markdown_table(header, sorted(rows, key=lambda row: list(BLACK_BOXES).index(row[0])))


CHAPTER = VectorSpace()
