"""Runs of the flexible mechanisms, ours or Exudyn's, with their errors against the independent solution.

Errors are of a point of the bent centre line, of the modal coordinates and of the frame's angular velocity: the largest
over equidistant samples of the run (the start is none). As in `runs`, a step that fails is not halved.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from research.measure import FORMULATION_NAMES
from research.reference import GRAVITY, History, add_vector, exudyn_flexible, flexible, vector_columns
from research.reference.clouds import PENDULUM_ANGULAR_VELOCITY, PENDULUM_LENGTH, SpinUp, pendulum_cloud
from research.reference.exudyn_models import Model, Settings, simulate
from research.study import cases, runs
from research.study.runs import Run, rotations
from sigmafmu import _core

RHO_INF = 0.9
ERRORS = {"position": "m", "modal": "m", "angularVelocity": "rad/s"}
"""Errors of a run and their units."""
SAMPLES = 50
DIVERGED = 10
"""A run has failed when its modal coordinates are so many times as large as those of the solution."""


@dataclass(frozen=True)
class Case:
    """One flexible mechanism; every step is half of the one before."""

    body: str
    index: int
    """Of the flexible body."""
    bodies: int
    point: str
    """A point of the centre line, with the section that it is the middle of."""
    section: int
    modes: int
    build: Callable[[Model], None]
    """For Exudyn."""
    stop_time: float  # s
    quick_time: float  # s
    largest_step: float  # s
    halvings: int
    quick_halvings: range
    driven: bool = False

    def steps(self, quick: bool) -> list[float]:
        """Step sizes in s."""
        chosen = self.quick_halvings if quick else range(self.halvings + 1)
        return [self.largest_step / 2**i for i in chosen]

    def time(self, quick: bool) -> float:
        """Stop time in s."""
        return self.quick_time if quick else self.stop_time


CASES = {
    "FlexiblePendulum": Case(
        body="beam",
        index=0,
        bodies=1,
        point="tip",
        section=-1,
        modes=4,
        build=exudyn_flexible.flexible_pendulum,
        stop_time=0.5,
        quick_time=0.05,
        largest_step=2e-3,
        halvings=6,
        quick_halvings=range(2, 5),
    ),
    "FlexibleSliderCrank": Case(
        body="rod",
        index=1,
        bodies=3,
        point="middle",
        section=5,
        modes=4,
        build=exudyn_flexible.flexible_slider_crank,
        stop_time=0.5,
        quick_time=0.025,
        largest_step=1e-3,
        halvings=6,
        quick_halvings=range(2, 5),
    ),
    "SpinUpBeam": Case(
        body="beam",
        index=1,
        bodies=2,
        point="tip",
        section=-1,
        modes=3,
        build=exudyn_flexible.spin_up_beam,
        stop_time=20.0,
        quick_time=2.0,
        largest_step=4e-2,
        halvings=5,
        quick_halvings=range(3),
        driven=True,
    ),
}
OTHERS: dict[str, dict[str, float]] = {
    "generalizedAlpha, SE(3)": {"group": 2},
    "bliedf2": {"method": 4},
    "bliedf2, SE(3)": {"method": 4, "group": 2},
    "rkmk4": {"method": 2},
    "rkmk4, SE(3)": {"method": 2, "group": 2},
    "rkmk54": {"method": 3},
    "rkmk54, SE(3)": {"method": 3, "group": 2},
}
"""Beside generalizedAlpha on R³×SO(3); implicit ones in the stabilized formulation."""
FIXED_STEPS = {"relative_tolerance": 1e9, "absolute_tolerance": 1e9}
"""Tolerances with which rkmk54 accepts every step."""
PEERS: dict[str, dict[str, Any]] = {
    "index 2, Euler parameters": {"rotation": "eulerParameters", "scheme": "index2"},
    "index 3, Euler parameters": {"rotation": "eulerParameters", "scheme": "index3"},
    "index 3, geom1": {"rotation": "lieGroup", "scheme": "index3", "simplified_kinematics": True},
    "index 3, σ-modified": {"rotation": "lieGroup", "scheme": "index3"},
}
"""Exudyn's ways; Tait-Bryan angles do not converge with its flexible body."""


def generalized_alpha() -> dict[str, dict[str, float]]:
    """Every formulation with every σ."""
    return {
        f"{name}, {cases.sigma_name(label)}": {"formulation": f, "sigma": cases.sigma_of(label, RHO_INF)}
        for f, name in FORMULATION_NAMES.items()
        for label in cases.SIGMAS
    }


def explicit(settings: Mapping[str, float]) -> bool:
    """Whether these are settings of a Runge-Kutta method."""
    return settings.get("method") in (2, 3)


@lru_cache(maxsize=8)
def exact(mechanism: str, stop_time: float) -> History:
    """Independent solution at SAMPLES + 1 equidistant times."""
    return flexible.solve(mechanism, np.linspace(0.0, stop_time, SAMPLES + 1))


def _spin_up(run: _core.Simulation, start: float, stop: float, steps: int, spin_up: SpinUp) -> None:
    """Move SpinUpBeam with its torque, a chord over each step: exact at the ends, where implicit methods ask for it."""
    times = np.linspace(start, stop, steps + 1)
    torques = spin_up.inertia * spin_up.acceleration(times)
    hub = system("SpinUpBeam")[0]
    u, slope = np.zeros((2, hub.input_size))
    motor = hub.motor_index(0)  # `hubPivot` is the first joint
    for t, end, torque, next_torque in zip(times, times[1:], torques, torques[1:], strict=False):
        u[motor], slope[motor] = torque, (next_torque - torque) / (end - t)
        run.set_input(u, slope, t)
        run.run(end, 1)


@cache
def system(mechanism: str) -> tuple[_core.System, int]:
    """For node positions and sizes; and the number of nodes."""
    multibody = _core.mechanism(mechanism).multibody
    return _core.System(multibody), len(multibody.body(CASES[mechanism].index).modal.nodes)


def states(
    mechanism: str, h: float, times: np.ndarray, spin_up: SpinUp | None = None, **settings: float
) -> tuple[np.ndarray, np.ndarray, _core.StepCounters]:
    """q and v at `times` (multiples of h, from 0), one in a row; raises RuntimeError where a step fails."""
    run = runs.simulation(mechanism, h, spectral_radius=RHO_INF, **settings)
    rows = [(run.state.q.copy(), run.state.v.copy())]
    for start, stop in pairwise(times):
        steps = round((stop - start) / h)
        if abs(steps * h - (stop - start)) > 1e-9 * stop:
            raise ValueError(f"{stop - start} s between samples is no multiple of the step {h} s")
        if CASES[mechanism].driven:
            _spin_up(run, start, stop, steps, spin_up or SpinUp())
        else:
            run.run(stop, steps)
        rows.append((run.state.q.copy(), run.state.v.copy()))
    q, v = (np.array(column) for column in zip(*rows, strict=True))
    return q, v, run.state.counters


def middle(mechanism: str, q: np.ndarray, section: int) -> np.ndarray:
    """The middle of a section in W, m: the mean of its four nodes."""
    model, nodes = system(mechanism)
    first = 4 * section % nodes
    return np.mean([model.node_position(q, CASES[mechanism].index, first + i) for i in range(4)], axis=0)


def centre_line(mechanism: str, q: np.ndarray) -> np.ndarray:
    """The middles of all sections, sections × 3."""
    return np.array([middle(mechanism, q, section) for section in range(system(mechanism)[1] // 4)])


def point(mechanism: str, q: np.ndarray) -> np.ndarray:
    """The followed point in W for each row of q, m."""
    return np.array([middle(mechanism, row, CASES[mechanism].section) for row in q])


def ours(mechanism: str, h: float, stop_time: float, **settings: float) -> Run:
    """Simulate with the core; `stop_time` is a multiple of SAMPLES steps."""
    case = CASES[mechanism]
    try:
        q, v, counters = states(mechanism, h, np.linspace(0.0, stop_time, SAMPLES + 1), **settings)
    except RuntimeError as error:
        return {"h": h, "failed": str(error)}
    history: History = {}
    add_vector(history, f"{case.point}.position", point(mechanism, q))
    add_vector(history, f"{case.body}.modal", q[:, 7 * case.bodies :])
    add_vector(history, f"{case.body}.angularVelocity", v[:, 6 * case.index + 3 : 6 * case.index + 6])
    return {
        "h": h,
        **errors(mechanism, history, stop_time),
        "steps": counters.steps,
        "iterations": counters.newton_iterations / counters.steps,
        "jacobians": counters.jacobian_evaluations / counters.steps,
    }


def peer(mechanism: str, h: float, stop_time: float, **settings: Any) -> Run:
    """Simulate with Exudyn; `settings` are those of `exudyn_models.Settings`."""
    try:
        chosen = Settings(h, rho_inf=RHO_INF, **settings)
        run = simulate(mechanism, chosen, stop_time, stop_time / SAMPLES, build=CASES[mechanism].build)
    except Exception as error:  # Exudyn has several types of its own
        return {"h": h, "failed": str(error).strip().splitlines()[0]}
    return {
        "h": h,
        **errors(mechanism, run.history, stop_time),
        "steps": run.steps,
        "iterations": run.newton_iterations / run.steps,
        "jacobians": run.jacobians / run.steps,
    }


def errors(mechanism: str, history: History, stop_time: float) -> dict[str, Any]:
    """Largest distances from the solution."""
    case, reference = CASES[mechanism], exact(mechanism, stop_time)
    result = {}
    for quantity, (name, size) in {
        "position": (f"{case.point}.position", 3),
        "modal": (f"{case.body}.modal", case.modes),
        "angularVelocity": (f"{case.body}.angularVelocity", 3),
    }.items():
        found, true = (
            np.column_stack([h[c] for c in vector_columns(name, size)])[-SAMPLES:] for h in (history, reference)
        )
        result[quantity] = float(np.linalg.norm(found - true, axis=1).max())
        if quantity == "modal" and not result[quantity] < DIVERGED * np.linalg.norm(true, axis=1).max():
            return {"failed": f"diverged: the error is over {DIVERGED} times as large as the bending"}
    return result


def our_steps(mechanism: str, steps: Sequence[float], stop_time: float, settings: Mapping[str, float]) -> Run:
    """A cell: runs of ours with all `steps`."""
    return {"runs": [ours(mechanism, h, stop_time, **settings) for h in steps]}


def peer_steps(mechanism: str, steps: Sequence[float], stop_time: float, settings: Mapping[str, Any]) -> Run:
    """A cell: runs of Exudyn with all `steps`."""
    return {"runs": [peer(mechanism, h, stop_time, **settings) for h in steps]}


# --- the pendulum's beam, rigid ---------------------------------------------------------------------------------------


def rigid_pendulum() -> _core.Mechanism:
    """The nodes of the pendulum's beam as a rigid body on the same joint, with the same start."""
    cloud = pendulum_cloud()
    centre = cloud.masses @ cloud.nodes / cloud.mass
    arms = cloud.nodes - centre
    body = _core.RigidBody()
    body.name, body.mass = "beam", cloud.mass
    body.inertia = cloud.masses @ ((arms**2).sum(axis=1)[:, None] - arms**2)  # a cloud with two planes of symmetry
    body.initial_position = centre
    body.initial_velocity = np.cross(PENDULUM_ANGULAR_VELOCITY, centre)
    body.initial_angular_velocity = PENDULUM_ANGULAR_VELOCITY
    result = _core.Mechanism()
    result.name = "RigidPendulum"
    result.multibody.gravity = GRAVITY
    ground, held = (_core.Frame(origin, np.eye(3)) for origin in (np.zeros(3), -centre))
    index = result.multibody.add(body)
    result.multibody.add(_core.Joint("pivot", _core.JointType.spherical, _core.GROUND, ground, index, held))
    return result


@lru_cache(maxsize=8)
def exact_rigid(stop_time: float) -> History:
    """Of the rigid pendulum: a cloud without modes, at SAMPLES + 1 equidistant times."""
    cloud = pendulum_cloud()
    rigid = replace(cloud, modes=cloud.modes[:, :, :0], stiffness=np.zeros((0, 0)))
    return flexible.flexible_pendulum(np.linspace(0.0, stop_time, SAMPLES + 1), cloud=rigid)


def rigid_position_error(h: float, stop_time: float, sigma: float, formulation: int) -> float:
    """Largest error of the tip of `rigid_pendulum`, m."""
    true, definition = exact_rigid(stop_time), rigid_pendulum()
    chosen = {"step_size": h, "spectral_radius": RHO_INF, "sigma": sigma, "formulation": formulation}
    for name, value in chosen.items():
        setattr(definition.integrator, name, value)
    run, error = _core.Simulation(definition), 0.0
    for i in range(1, SAMPLES + 1):
        run.run(true["time"][i], round(stop_time / SAMPLES / h))
        q = run.state.q
        tip = q[:3] + rotations(q[None, 3:7]).apply([0.5 * PENDULUM_LENGTH, 0.0, 0.0])[0]
        error = max(error, float(np.linalg.norm(tip - [true[c][i] for c in vector_columns("tip.position")])))
    return error


def rigid_steps(steps: Sequence[float], stop_time: float) -> dict[str, Any]:
    """A cell: by formulation and σ, tip errors of the rigid pendulum with all `steps`."""
    return {
        name: [rigid_position_error(h, stop_time, s["sigma"], int(s["formulation"])) for h in steps]
        for name, s in generalized_alpha().items()
    }
