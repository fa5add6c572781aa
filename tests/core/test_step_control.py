"""Step control on mechanisms that fixed steps get wrong: chains with links of 1 g beside links of a ton."""

from dataclasses import dataclass

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import (
    GROUND,
    INDEX3,
    STABILIZED,
    Rotation,
    coordinates,
    frame_pose,
    random_body,
    random_frame,
    relative_pose,
)
from .methods import BLIEDF2, GENERALIZED_ALPHA, RKMK4

TREES = range(100)
ERROR_CONTROL = 2
H, STOP = 1e-3, 0.5
ALLOWED = 1e-2
"""Of the energy, over the largest kinetic energy."""
WARNED = 3e-4
"""The estimate above which the FMU warns."""


def tree(seed: int, bodies: int = 5) -> _core.Mechanism:
    """Revolute, spherical and universal joints; masses from 1 g to 1 t, each with the inertia of its size."""
    rng = np.random.default_rng(seed)
    mechanism = _core.Mechanism()
    multibody = mechanism.multibody
    multibody.gravity = np.array([0, 0, -9.81])
    poses, joints = {GROUND: np.eye(4)}, []
    kinds = (_core.JointType.revolute, _core.JointType.spherical, _core.JointType.universal)
    for i in range(bodies):
        parent, kind = int(rng.integers(-1, i)), kinds[rng.integers(3)]
        one, two = random_frame(rng), random_frame(rng)
        relative = relative_pose(kind, rng.uniform(-1, 1, 3))
        poses[i] = poses[parent] @ frame_pose(one) @ relative @ np.linalg.inv(frame_pose(two))
        joints.append(_core.Joint(f"joint{i}", kind, parent, one, i, two))
        body = random_body(rng, f"body{i}")
        factor = 10 ** rng.uniform(-3, 3) / body.mass
        body.mass *= factor
        body.inertia, body.inertia_products = body.inertia * factor, body.inertia_products * factor
        q = coordinates(poses[i])
        body.initial_position, body.initial_quaternion = q[:3], q[3:]
        body.initial_angular_velocity = rng.uniform(-3, 3, 3)
        multibody.add(body)
    for joint in joints:
        multibody.add(joint)
    return mechanism


@dataclass
class Run:
    energy_error: float
    """NaN if a step failed."""
    estimate: float
    steps: int


def run(seed: int, **settings: float) -> Run:
    mechanism = tree(seed)
    mechanism.integrator.step_size = H
    for name, value in settings.items():
        setattr(mechanism.integrator, name, value)
    simulation, system = _core.Simulation(mechanism), _core.System(mechanism.multibody)
    mechanism.multibody.gravity = np.zeros(3)
    weightless = _core.System(mechanism.multibody)  # its energy is the kinetic one
    state = simulation.state
    start, kinetic, worst = system.energy(state.q, state.v), weightless.energy(state.q, state.v), 0.0
    for i in range(round(STOP / H)):
        try:
            simulation.run((i + 1) * H, 1)
        except RuntimeError:
            worst = np.nan
            break
        state = simulation.state
        worst = max(worst, abs(system.energy(state.q, state.v) - start))
        kinetic = max(kinetic, weightless.energy(state.q, state.v))
    state = simulation.state
    return Run(worst / kinetic, state.largest_error, state.counters.steps)


def wrong(runs: list[Run]) -> list[Run]:
    return [r for r in runs if not r.energy_error < ALLOWED]


@pytest.mark.parametrize("formulation", [STABILIZED, INDEX3])
def test_fixed_steps_that_go_wrong_are_told(formulation):
    """The estimate tells those whose energy is wrong by a percent, and hardly any other."""
    runs = [run(seed, formulation=formulation) for seed in TREES]
    assert wrong(runs), "there is something to tell"
    assert all(r.estimate > WARNED for r in wrong(runs))
    assert sum(r.estimate > WARNED for r in runs) <= len(wrong(runs)) + 3


@pytest.mark.parametrize(
    ("method", "formulation", "rho"),
    [
        (GENERALIZED_ALPHA, STABILIZED, 0.9),
        (GENERALIZED_ALPHA, INDEX3, 0.9),
        (BLIEDF2, STABILIZED, 0.9),
        (RKMK4, STABILIZED, 0.9),
    ],
)
def test_step_control_makes_them_right(method, formulation, rho):
    chosen = {"method": method, "formulation": formulation, "spectral_radius": rho}
    runs = [run(seed, step_control=ERROR_CONTROL, error_tolerance=1e-7, **chosen) for seed in TREES]
    assert wrong(runs) == []
    assert max(r.estimate for r in runs) <= 1e-7
    assert min(r.steps for r in runs) == pytest.approx(STOP / H, abs=2), "easy ones take no steps that they do not need"


def test_index_3_without_damping_is_right_or_stops():
    """Its multipliers oscillate, which the estimate takes for what it is; a few steps become too short."""
    chosen = {"formulation": INDEX3, "spectral_radius": 1.0, "step_control": ERROR_CONTROL, "error_tolerance": 1e-6}
    runs = [run(seed, **chosen) for seed in TREES[:20]]
    assert all(np.isnan(r.energy_error) for r in wrong(runs))
    assert len(wrong(runs)) <= 1


def test_energy_that_rkmk4_loses_at_a_change_point_is_told():
    """Crank and rod of equal length; they pass the position where the slider is in the middle and the rod may turn with
    the crank. Steps of 10 ms lose up to half of the energy there."""
    lost = []
    for angle in np.linspace(0.7, 1.2, 15):
        simulation, system = equal_slider_crank(angle, method=RKMK4, step_size=1e-2)
        start = system.energy(simulation.state.q, simulation.state.v)
        try:
            simulation.run(1.0, 100)
        except RuntimeError:  # told as well
            continue
        state = simulation.state
        lost.append((abs(system.energy(state.q, state.v) / start - 1), state.largest_error))
    assert max(energy for energy, _ in lost) > 0.1, "there is something to tell"
    assert all(estimate > WARNED for energy, estimate in lost if energy > ALLOWED)


def equal_slider_crank(angle: float, **settings: float) -> tuple[_core.Simulation, _core.System]:
    """In the plane y = 0, starting at that angle of the crank with 36 rad/s or so."""
    mechanism, length = _core.Mechanism(), 0.2
    multibody, joint = mechanism.multibody, _core.JointType
    along_crank = np.array([np.cos(angle), 0, np.sin(angle)])
    along_rod = along_crank * [1, 1, -1]
    pin, slider = length * along_crank, 2 * length * along_crank * [1, 0, 0]

    def add(
        name: str, mass: float, inertia: tuple, position: np.ndarray, x: np.ndarray, velocity: np.ndarray, spin: float
    ):
        body = _core.RigidBody()
        body.name, body.mass, body.inertia = name, mass, np.array(inertia)
        body.initial_position, body.initial_velocity = position, velocity
        rotation = np.column_stack([x, [0, 1, 0], np.cross(x, [0, 1, 0])])
        body.initial_quaternion = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
        body.initial_angular_velocity = np.array([0, spin, 0])
        return multibody.add(body)

    rate = 36.0
    of_pin = rate * length * np.array([-np.sin(angle), 0, np.cos(angle)])
    of_slider = 2 * of_pin * [1, 0, 0]
    crank = add("crank", 0.12, (1e-5, 1e-4, 1e-4), pin / 2, along_crank, of_pin / 2, -rate)
    rod = add("rod", 0.5, (4e-4, 4e-3, 4e-3), (pin + slider) / 2, along_rod, (of_pin + of_slider) / 2, rate)
    block = add("slider", 2.0, (1e-4,) * 3, slider, np.array([1.0, 0, 0]), of_slider, 0.0)
    about_y, along_x = _core.axes_with_z(np.array([0, 1.0, 0])), _core.axes_with_z(np.array([1.0, 0, 0]))
    end = np.array([length / 2, 0, 0])
    frame, origin, axes = _core.Frame, np.zeros(3), np.eye(3)
    multibody.add(_core.Joint("pivot", joint.revolute, GROUND, frame(origin, about_y), crank, frame(-end, about_y)))
    multibody.add(_core.Joint("pin", joint.spherical, crank, frame(end, axes), rod, frame(-end, axes)))
    multibody.add(_core.Joint("wrist", joint.universal, rod, frame(end, axes), block, frame(origin, about_y)))
    multibody.add(_core.Joint("guide", joint.prismatic, GROUND, frame(origin, along_x), block, frame(origin, along_x)))
    for name, value in settings.items():
        setattr(mechanism.integrator, name, value)
    return _core.Simulation(mechanism), _core.System(multibody)
