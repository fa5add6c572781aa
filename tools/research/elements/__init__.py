"""Elements beside those of Exudyn and MuJoCo, and robot arms beside Pinocchio and MuJoCo.

`python -m research elements` writes the page docs/comparison.md. A `Case` is a small mechanism with the element, and
what is the same thing in another code; both run with the same numbers, and a point of the last body is compared.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from research.reference.exudyn_models import Model, Settings, of_definition, simulate
from sigmafmu import _core

if TYPE_CHECKING:
    import mujoco

RKMK4 = 2
POINT = np.array([0.1, 0.2, 0.3])
"""Whose place is compared, in the last body [m]."""


@dataclass(frozen=True)
class Peer:
    """The same element in another code."""

    name: str
    """What it is called there."""
    build: Callable[..., Any]
    """Exudyn: adds it to a Model with the bodies; MuJoCo: makes (model, rates) or (model, rates, controls)."""
    order: int
    """Of that code's error in h."""
    note: str = ""
    """Why something else comes out."""


@dataclass(frozen=True)
class Case:
    """An element in a mechanism."""

    element: str
    mechanism: Callable[[], _core.Mechanism]
    stop: float = 0.4  # s
    steps: int = 400
    contact: bool = False
    """Whether bodies touch, which Exudyn must be told."""
    inputs: Mapping[str, float] = field(default_factory=dict)
    """Constant ones of ours, by their names."""
    exudyn: Peer | None = None
    mujoco: Peer | None = None


def ours(case: Case, steps: int) -> np.ndarray:
    """Where the point is at the end, by our method of order 4."""
    mechanism = case.mechanism()
    settings = mechanism.integrator
    settings.method, settings.step_size = RKMK4, case.stop / steps
    settings.absolute_tolerance = settings.relative_tolerance = 1e-13
    simulation = _core.Simulation(mechanism)
    if case.inputs:
        u = np.array([case.inputs.get(name, 0.0) for name in _core.Outputs(mechanism).inputs])
        simulation.set_input(u, np.zeros_like(u), 0.0)
    simulation.advance(case.stop / steps, steps)
    last = simulation.state.q.reshape(-1, 7)[-1]
    return last[:3] + Rotation.from_quat(last[3:], scalar_first=True).apply(POINT)


def exudyn(case: Case, steps: int) -> np.ndarray:
    """The same by Exudyn: Newmark's method with constraints on velocities, of order 2."""
    assert case.exudyn is not None
    whole = case.mechanism().multibody
    bodies = _core.Multibody()
    bodies.gravity = whole.gravity
    q, v = _core.assemble(whole)
    for body, pose, rates in zip(whole.bodies, q.reshape(-1, 7), v.reshape(-1, 6), strict=True):
        body.initial_position, body.initial_quaternion = pose[:3], pose[3:]
        body.initial_velocity, body.initial_angular_velocity = rates[:3], rates[3:]
        bodies.add(body)

    def build(model: Model) -> None:
        of_definition(bodies)(model)
        case.exudyn.build(model, whole)

    settings = Settings(case.stop / steps, relative_tolerance=1e-10, absolute_tolerance=1e-12, contact=case.contact)
    history = simulate(case.element, settings, case.stop, build=build).history
    name = whole.bodies[-1].name
    x = np.array([history[f"{name}.position[{i}]"][-1] for i in (1, 2, 3)])
    turn = np.array([history[f"{name}.quaternion[{i}]"][-1] for i in (1, 2, 3, 4)])
    return x + Rotation.from_quat(turn, scalar_first=True).apply(POINT)


def mujoco_run(case: Case, steps: int) -> np.ndarray:
    """The same by MuJoCo: its Runge-Kutta method of order 4."""
    import mujoco as mj

    assert case.mujoco is not None
    whole = case.mechanism().multibody
    model, rates, *controls = case.mujoco.build(whole)
    data = run_mujoco(model, rates, controls[0] if controls else None, case.stop, steps)
    last = mj.mj_name2id(model, mj.mjtObj.mjOBJ_BODY, whole.bodies[-1].name)
    return data.xpos[last] + data.xmat[last].reshape(3, 3) @ POINT


def run_mujoco(
    model: mujoco.MjModel, rates: np.ndarray, controls: np.ndarray | None, stop: float, steps: int
) -> mujoco.MjData:
    """MuJoCo's state after `steps` steps of its Runge-Kutta method from the pose of the model."""
    import mujoco as mj

    model.opt.timestep = stop / steps
    model.opt.integrator = mj.mjtIntegrator.mjINT_RK4
    model.opt.tolerance, model.opt.iterations = 0.0, 100
    data = mj.MjData(model)
    data.qvel[:] = rates
    if controls is not None:
        data.ctrl[:] = controls
    mj.mj_step(model, data, nstep=steps)
    mj.mj_kinematics(model, data)
    return data


RUNS = {"Exudyn": exudyn, "MuJoCo": mujoco_run}


def compare(case: Case) -> list[dict[str, Any]]:
    """A row for each code: distances from our point with h, with h/2 and extrapolated to h = 0 [m]."""
    finest = ours(case, 4 * case.steps)
    rows = []
    for code, peer in (("Exudyn", case.exudyn), ("MuJoCo", case.mujoco)):
        if peer is None:
            continue
        coarse, fine = (RUNS[code](case, steps) for steps in (case.steps, 2 * case.steps))
        limit = fine + (fine - coarse) / (2**peer.order - 1)
        names = {"element": case.element, "code": code, "there": peer.name, "note": peer.note}
        found = {"coarse": coarse, "fine": fine, "limit": limit}
        errors = {key: float(np.abs(x - finest).max()) for key, x in found.items()}
        rows.append(names | {"h": case.stop / case.steps} | errors)
    return rows
