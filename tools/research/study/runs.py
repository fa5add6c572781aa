"""One simulation, ours or Exudyn's, with its errors against the independent solution.

Errors are of the position and velocity of a point, of the orientation of its body and of the multipliers: the largest
over equidistant samples of the run (the start is none), or at the end. A run that fails says why; a step that fails is
not halved here, for the step size is what the study varies.
"""

from collections.abc import Callable, Mapping, Sequence
from time import process_time
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from research import measure
from research.measure import INCREMENTAL, INDEX2, INDEX3, MULTIPLIERS, RESIDUAL, STABILIZED, TRACKED, columns
from research.reference import History, add_vector
from research.reference.exudyn_models import Settings, simulate
from sigmafmu import _core

__all__ = ["INCREMENTAL", "INDEX2", "INDEX3", "RESIDUAL", "STABILIZED", "columns"]

FULL, TANGENT_FREE = 1, 2  # integrator.jacobian
MODIFIED = 2  # integrator.newton
SAMPLES = 50
DIVERGED = 10
"""A run has failed when its error is so many times as large as the motion."""
ENOUGH = 0.5
"""Seconds of measured time after which a run is not repeated for a better one."""
POINTS = {"HeavyTop": (0.0, 0.0, 0.0), "HighSpeedRotor": (0.09, 0.0, 0.0), "SliderCrank": (0.0, 0.0, 0.0)}
"""The point that is followed, from the centre of mass of the body in `TRACKED`, m in B: the rotor's right bearing."""
ERRORS = {
    "position": "m",
    "velocity": "m/s",
    "rotation": "rad",
    "multipliers": "N",
    "final position": "m",
    "final velocity": "m/s",
}
"""Errors of a run and their units."""

Run = dict[str, Any]
"""h [s], the errors, steps, iterations and jacobians per step; or h and failed, the reason."""


def simulation(mechanism: str, h: float, **settings: float) -> _core.Simulation:
    """A simulation that fails where a step fails; `settings` are attributes of `_core.IntegratorSettings`."""
    return measure.simulation(mechanism, h, **{"max_halvings": 0, **settings})


def exact(mechanism: str, stop_time: float) -> History:
    """Independent solution at SAMPLES + 1 equidistant times."""
    return measure.exact(mechanism, stop_time, SAMPLES)


def trajectory(mechanism: str, h: float, stop_time: float, **settings: float) -> tuple[History, _core.StepCounters]:
    """The body in `TRACKED` and the joint forces at SAMPLES + 1 times; raises RuntimeError where a step fails."""
    stride = round(stop_time / h / SAMPLES)
    if abs(stride * SAMPLES * h - stop_time) > 1e-9 * stop_time:
        raise ValueError(f"the stop time {stop_time} s is no multiple of {SAMPLES} steps of {h} s")
    run = simulation(mechanism, h, **settings)
    rows = []
    for i in range(SAMPLES + 1):
        run.run(stop_time * i / SAMPLES, stride if i else 0)
        rows.append((run.state.q.copy(), run.state.v.copy(), run.state.lambda_.copy()))
    q, v, multipliers = (np.array(column) for column in zip(*rows, strict=True))
    history = body_history(mechanism, q, v)
    for joint, first in MULTIPLIERS[mechanism].items():
        add_vector(history, f"{joint}.reactionForce", -multipliers[:, first : first + 3])
    return history, run.state.counters


def body_history(mechanism: str, q: np.ndarray, v: np.ndarray) -> History:
    """The body in `TRACKED` from coordinates and velocities of the core, one sample in a row."""
    body, name = TRACKED[mechanism]
    history: History = {}
    add_vector(history, f"{name}.position", q[:, 7 * body : 7 * body + 3])
    add_vector(history, f"{name}.quaternion", q[:, 7 * body + 3 : 7 * body + 7])
    add_vector(history, f"{name}.velocity", v[:, 6 * body : 6 * body + 3])
    add_vector(history, f"{name}.angularVelocity", v[:, 6 * body + 3 : 6 * body + 6])
    return history


def ours(mechanism: str, h: float, stop_time: float, **settings: float) -> Run:
    """Simulate with the core; `stop_time` is a multiple of SAMPLES steps."""
    try:
        history, counters = trajectory(mechanism, h, stop_time, **settings)
    except RuntimeError as error:
        return {"h": h, "failed": str(error)}
    return {
        "h": h,
        **_errors(mechanism, history, stop_time),
        "steps": counters.steps,
        "iterations": counters.newton_iterations / counters.steps,
        "jacobians": counters.jacobian_evaluations / counters.steps,
    }


def exudyn(mechanism: str, h: float, stop_time: float, **settings: Any) -> Run:
    """Simulate with Exudyn; `settings` are those of `exudyn_models.Settings`."""
    try:
        run = simulate(mechanism, Settings(h, **settings), stop_time, sample_step=stop_time / SAMPLES)
    except Exception as error:  # Exudyn has several types of its own
        return {"h": h, "failed": _reason(error)}
    return {
        "h": h,
        **_errors(mechanism, run.history, stop_time),
        "steps": run.steps,
        "iterations": run.newton_iterations / run.steps,
        "jacobians": run.jacobians / run.steps,
    }


def exudyn_steps(mechanism: str, steps: Sequence[float], stop_time: float, settings: Mapping[str, Any]) -> Run:
    """A cell: runs of Exudyn with all `steps`."""
    return {"runs": [exudyn(mechanism, h, stop_time, **settings) for h in steps]}


def seconds(mechanism: str, h: float, stop_time: float, rounds: int, **settings: float) -> float:
    """CPU time of our run, the fastest of some rounds."""

    def once() -> float:
        run = simulation(mechanism, h, **settings)
        start = process_time()
        run.run(stop_time, round(stop_time / h))
        return process_time() - start

    return _fastest(once, rounds)


def seconds_exudyn(mechanism: str, h: float, stop_time: float, rounds: int, **settings: Any) -> float:
    """CPU time of Exudyn's run without output, the fastest of some rounds."""
    return _fastest(lambda: simulate(mechanism, Settings(h, **settings), stop_time).cpu_time, rounds)


def _fastest(once: Callable[[], float], rounds: int) -> float:
    taken: list[float] = []
    while len(taken) < rounds and sum(taken) < ENOUGH:
        taken.append(once())
    return min(taken)


def point_motion(mechanism: str, history: History) -> tuple[np.ndarray, np.ndarray]:
    """Position [m] and velocity [m/s] of the followed point in W, (times, 3)."""
    _, name = TRACKED[mechanism]
    rotation = rotations(_quaternions(history, name))
    offset = np.array(POINTS[mechanism])
    omega = columns(history, f"{name}.angularVelocity")
    position = columns(history, f"{name}.position") + rotation.apply(offset)
    return position, columns(history, f"{name}.velocity") + rotation.apply(np.cross(omega, offset))


def rotations(quaternions: np.ndarray) -> Rotation:
    """Of unit quaternions (w, x, y, z), one in a row."""
    return Rotation.from_quat(quaternions, scalar_first=True)


def _errors(mechanism: str, history: History, stop_time: float) -> dict[str, Any]:
    reference = exact(mechanism, stop_time)
    _, name = TRACKED[mechanism]
    x, v = point_motion(mechanism, history)
    x_exact, v_exact = point_motion(mechanism, reference)
    found, true = (rotations(_quaternions(h, name)) for h in (history, reference))
    result = {
        "position": _largest(x - x_exact),
        "velocity": _largest(v - v_exact),
        "rotation": float((true.inv() * found).magnitude().max()),
        "final position": _largest(x[-1:] - x_exact[-1:]),
        "final velocity": _largest(v[-1:] - v_exact[-1:]),
    }
    if MULTIPLIERS[mechanism]:
        result["multipliers"] = max(
            _largest(columns(history, f"{joint}.reactionForce") - columns(reference, f"{joint}.reactionForce"))
            for joint in MULTIPLIERS[mechanism]
        )
    if not result["position"] < DIVERGED * np.linalg.norm(x_exact - x_exact[0], axis=1).max():
        return {"failed": f"diverged: the error is over {DIVERGED} times as large as the motion"}
    return result


def _quaternions(history: History, body: str) -> np.ndarray:
    return np.column_stack([history[f"{body}.quaternion[{i}]"] for i in (1, 2, 3, 4)])


def _largest(difference: np.ndarray) -> float:
    """Over all samples but the start."""
    return float(np.linalg.norm(difference[-SAMPLES:], axis=1).max())


def _reason(error: Exception) -> str:
    lines = str(error).strip().splitlines()
    return lines[0] if lines else type(error).__name__
