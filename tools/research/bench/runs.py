"""Timed runs of a mechanism from its start, in our core, through an FMU, in Exudyn, MuJoCo and Pinocchio."""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from time import process_time
from typing import Any, TypeVar

import numpy as np
from scipy.spatial.transform import Rotation

from research.bench.trees import mujoco_model, pinocchio_model
from research.reference.exudyn_models import Model, Settings, load_exudyn, of_definition, simulate
from sigmafmu import SigmafmuError, _core
from sigmafmu.fmu import Fmu
from sigmafmu.realtime import native_steps

FORMULATIONS = {"index3": 1, "index2": 2, "stabilizedIndex2": 3}
DEFAULT = "stabilizedIndex2"
INTERNAL_STEPS_PER_CALL = 10
"""Internal steps in one fmi2DoStep."""

Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True)
class Run:
    """What a run of some steps took."""

    seconds: float  # per step
    iterations: float  # of Newton's method per step; 0: explicit
    position: np.ndarray  # of a point of the last body at the end, in W


def fastest(candidates: Mapping[Key, Callable[[], Run]], rounds: int) -> dict[Key, Run]:
    """The fastest run of each; all in turn, so that another load on the machine meets all of them."""
    result: dict[Key, Run] = {}
    for _ in range(rounds):
        for key, candidate in candidates.items():
            run = candidate()
            if key not in result or run.seconds < result[key].seconds:
                result[key] = run
    return result


def core(
    mechanism: _core.Mechanism, h: float, steps: int, point: np.ndarray, *, body: int = -1, **settings: Any
) -> Run:
    """Our core, without an FMU around it; `settings` are members of its IntegratorSettings."""
    mechanism.integrator.step_size = h
    for name, value in settings.items():
        setattr(mechanism.integrator, name, value)
    simulation = _core.Simulation(mechanism)
    start = process_time()
    simulation.advance(h, steps)
    seconds = (process_time() - start) / steps
    state = simulation.state
    pose = state.q[: 7 * len(mechanism.multibody.bodies)].reshape(-1, 7)[body]
    position = pose[:3] + Rotation.from_quat(pose[3:], scalar_first=True).apply(point)
    return Run(seconds, state.counters.newton_iterations / steps, position)


def fmu(model: Fmu, output: str, h: float, steps: int, parameters: Mapping[str, float], formulation: str) -> Run:
    """An FMU, called from C++."""
    slave = model.instantiate()
    try:
        slave.setReal(model.references([*parameters]), [*parameters.values()])
        slave.setReal(model.references(["integrator.stepSize"]), [h])
        slave.setInteger(model.references(["integrator.formulation"]), [FORMULATIONS[formulation]])
        slave.setupExperiment()
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        calls = steps // INTERNAL_STEPS_PER_CALL
        start = process_time()
        native_steps(slave, INTERNAL_STEPS_PER_CALL * h, calls)
        seconds = (process_time() - start) / calls / INTERNAL_STEPS_PER_CALL
        (iterations,) = slave.getInteger(model.references(["integrator.newtonIterations"]))
        position = np.array(slave.getReal(model.references([f"{output}[{i}]" for i in (1, 2, 3)])))
        return Run(seconds, iterations / steps, position)
    finally:
        slave.freeInstance()


def start_exudyn() -> None:
    """Load its fast module. SigmafmuError: this machine or process cannot."""
    try:
        load_exudyn(fast=True)
    except RuntimeError as error:
        raise SigmafmuError(f"the benchmark cannot run: {error}") from error


def exudyn(
    mechanism: str | _core.Multibody | Callable[[Model], None],
    h: float,
    steps: int,
    point: np.ndarray,
    *,
    rho_inf: float = 0.9,
    modified: bool = False,
    sparse: bool = False,
    scheme: str = "index3",
    body: str = "",
) -> Run:
    """Exudyn's σ-modified index-3 scheme or another one, processor time of its solver.

    A mechanism of its own by name, ours, or what builds one; `body` has the point (default: the last one).
    """
    settings = Settings(h, rotation="lieGroup", scheme=scheme, rho_inf=rho_inf, modified_newton=modified, sparse=sparse)
    build: Callable[[Model], None] | None = None
    if not isinstance(mechanism, str):
        build = of_definition(mechanism) if isinstance(mechanism, _core.Multibody) else mechanism
    run = simulate(mechanism if isinstance(mechanism, str) else "", settings, stop_time=steps * h, build=build)
    last = body or next(key for key in reversed(run.history) if key.endswith(".angularVelocity[3]")).partition(".")[0]
    q = np.array([run.history[f"{last}.quaternion[{i}]"][-1] for i in (1, 2, 3, 4)])
    position = np.array([run.history[f"{last}.position[{i}]"][-1] for i in (1, 2, 3)])
    position += Rotation.from_quat(q, scalar_first=True).apply(point)
    return Run(run.cpu_time / run.steps, run.newton_iterations / run.steps, position)


def mujoco(definition: _core.Multibody, h: float, steps: int, point: np.ndarray, integrator: str) -> Run:
    """MuJoCo in joint coordinates; all steps in one call of its C code."""
    import mujoco as mj

    model, velocities = mujoco_model(definition)
    model.opt.timestep = h
    model.opt.integrator = getattr(mj.mjtIntegrator, f"mjINT_{integrator}")
    data = mj.MjData(model)
    data.qvel[:] = velocities
    start = process_time()
    mj.mj_step(model, data, nstep=steps)
    seconds = (process_time() - start) / steps
    mj.mj_kinematics(model, data)
    last = mj.mj_name2id(model, mj.mjtObj.mjOBJ_BODY, definition.bodies[-1].name)  # MuJoCo sorts by branches
    return Run(seconds, 0.0, data.xpos[last] + data.xmat[last].reshape(3, 3) @ point)


def pinocchio_aba(definition: _core.Multibody, count: int = 200, repeats: int = 5) -> float:
    """Seconds that Pinocchio takes for the accelerations of a tree, one thread, without the way through Python."""
    import pinocchio as pin

    model, v = pinocchio_model(definition)
    pool = pin.ModelPool(model, 1)
    q = np.asfortranarray(np.tile(pin.neutral(model)[:, None], count))
    v = np.asfortranarray(np.tile(v[:, None], count))
    zero = np.zeros_like(v, order="F")
    taken = []
    for _ in range(repeats):
        start = process_time()
        pin.abaInParallel(1, pool, q, v, zero)
        taken.append((process_time() - start) / count)
    return min(taken)


def pinocchio_rk4(definition: _core.Multibody, h: float, steps: int, point: np.ndarray, aba: float) -> Run:
    """The classical Runge-Kutta method in Pinocchio's joint coordinates: angles of hinges, quaternions of balls.

    A step counts as four times `aba` seconds, which is less than it takes. SigmafmuError: a body is free.
    """
    import pinocchio as pin

    model, v = pinocchio_model(definition)
    for name, joint in zip(model.names, model.joints, strict=True):
        if joint.nq > 4:
            raise SigmafmuError(f"body {name} has a free joint; these steps are for hinges and balls")
    data, q, zero = model.createData(), pin.neutral(model), np.zeros(model.nv)
    balls = [joint for joint in model.joints if joint.nq == 4]
    others = [joint for joint in model.joints if joint.nq == 1]
    quaternions, spins = (np.array([range(i, i + n) for i in at], dtype=int).reshape(-1, n) for at, n in (
        ([joint.idx_q for joint in balls], 4),
        ([joint.idx_v for joint in balls], 3),
    ))  # fmt: skip
    angles, rates = [joint.idx_q for joint in others], [joint.idx_v for joint in others]

    def derivative(q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        q = pin.normalize(model, q)
        qdot = np.zeros(model.nq)
        qdot[angles] = v[rates]
        (x, w), spin = (q[quaternions[:, :3]], q[quaternions[:, 3:]]), v[spins]
        qdot[quaternions[:, :3]] = 0.5 * (w * spin + np.cross(x, spin))
        qdot[quaternions[:, 3]] = -0.5 * np.sum(x * spin, axis=1)
        return qdot, pin.aba(model, data, q, v, zero).copy()

    for _ in range(steps):
        a = derivative(q, v)
        b = derivative(q + 0.5 * h * a[0], v + 0.5 * h * a[1])
        c = derivative(q + 0.5 * h * b[0], v + 0.5 * h * b[1])
        d = derivative(q + h * c[0], v + h * c[1])
        q, v = (x + h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]) for i, x in enumerate((q, v)))
        q = pin.normalize(model, q)
    pin.forwardKinematics(model, data, q)
    return Run(4 * aba, 0.0, data.oMi[model.njoints - 1].act(model.inertias[model.njoints - 1].lever + point))
