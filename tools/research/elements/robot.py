"""Robot arms of example-robot-data with friction, damping and armatures, beside Pinocchio and MuJoCo."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from research.bench.trees import mujoco_model
from research.elements import POINT, RKMK4, run_mujoco
from research.mechanisms.robots import example_urdf, from_pinocchio
from sigmafmu import _core

if TYPE_CHECKING:
    import pinocchio

ARMS = ("xarm7", "z1", "ur5_robot", "so101", "talos_left_arm")
"""URDF files; the first one falls beside MuJoCo."""
ARMATURES = (0.6, 0.1)
"""Of motors seen through their gears, from the first joint to the last, where a file has none [kg m²]."""
RESISTANCE = 0.5, 1.0
"""Damping and friction of joints where a file has none [N m s/rad], [N m]."""
CREEP = 0.05
"""Rate at which friction has 76 % [rad/s]. The files' is Coulomb's, without a law for joints at rest."""
SHARP = 0.002
"""Another such rate, near to Coulomb's law."""
STATES = 20
STOP, STEPS = 1.0, 1000


def model(name: str = ARMS[0]) -> pinocchio.Model:
    """In Pinocchio, with armatures, damping and friction in every joint."""
    path = str(example_urdf(f"{name}.urdf"))
    import pinocchio

    result = pinocchio.buildModelFromUrdf(path)
    result.armature = np.where(result.armature > 0, result.armature, np.linspace(*ARMATURES, result.nv))
    result.damping = np.where(result.damping > 0, result.damping, RESISTANCE[0])
    friction = np.where(result.upperDryFrictionLimit > 0, result.upperDryFrictionLimit, RESISTANCE[1])
    result.upperDryFrictionLimit, result.lowerDryFrictionLimit = friction, -friction
    return result


def resistance(arm: pinocchio.Model, v: np.ndarray) -> np.ndarray:
    """Torques of friction and damping, which Pinocchio's algorithms leave to its user."""
    return -arm.damping * v - arm.upperDryFrictionLimit * np.tanh(v / CREEP)


def mechanism(arm: pinocchio.Model, q: np.ndarray, v: np.ndarray, creep: float = CREEP) -> _core.Mechanism:
    """Ours at (q, v)."""
    result = from_pinocchio(arm, q, v, "Arm")
    for i in range(arm.nv):
        friction = float(arm.upperDryFrictionLimit[i])
        result.multibody.add(_core.JointFriction(i, friction, viscous_friction=float(arm.damping[i]), creep_rate=creep))
        result.multibody.add(_core.JointArmature(i, float(arm.armature[i])))
    return result


def accelerations(name: str = ARMS[0]) -> float:
    """Largest difference of joint accelerations from Pinocchio's, beside the largest of them, over random states."""
    import pinocchio

    arm, rng = model(name), np.random.default_rng(7)
    data, worst = arm.createData(), 0.0
    for _ in range(STATES):
        q, v, motors = rng.uniform(-np.pi, np.pi, arm.nq), rng.uniform(-2, 2, arm.nv), rng.uniform(-30, 30, arm.nv)
        expected = pinocchio.aba(arm, data, q, v, motors + resistance(arm, v))
        multibody = mechanism(arm, q, v).multibody
        system, (x, rates) = _core.System(multibody), _core.assemble(multibody)
        u = np.zeros(system.input_size)
        for i, motor in enumerate(motors):
            u[system.motor_index(i, 0)] = motor
        vdot, _ = system.accelerations(x, rates, u)
        found = [system.coordinate_acceleration(x, rates, vdot, i) for i in range(arm.nv)]
        worst = max(worst, float(np.abs(found - expected).max() / np.abs(expected).max()))
    return worst


START = np.array([0.3, -0.5, 0.4, 1.2, -0.3, 0.8, 0.2]), np.array([1.0, 0.5, -1.0, 0.8, 2.0, -1.5, 3.0])
"""Angles and rates from which the arm falls."""


def our_end(arm: pinocchio.Model, steps: int, creep: float = CREEP, **settings: Any) -> np.ndarray:
    """Where the point of the last link is at the end."""
    m = mechanism(arm, *START, creep)
    m.integrator.step_size = STOP / steps
    for name, value in settings.items():
        setattr(m.integrator, name, value)
    simulation = _core.Simulation(m)
    simulation.advance(STOP / steps, steps)
    last = simulation.state.q.reshape(-1, 7)[-1]
    return last[:3] + Rotation.from_quat(last[3:], scalar_first=True).apply(POINT)


def mujoco_end(arm: pinocchio.Model, steps: int, smooth: bool) -> np.ndarray:
    """The same by MuJoCo: with our law of friction as passive force, or with its own."""
    import mujoco as mj

    definition = mechanism(arm, *START).multibody
    friction = arm.upperDryFrictionLimit

    def edit(root: ElementTree.Element) -> None:
        for i, hinge in enumerate(root.iter("joint")):
            hinge.attrib |= {"armature": repr(float(arm.armature[i])), "damping": repr(float(arm.damping[i]))}
            if not smooth:
                hinge.attrib["frictionloss"] = repr(float(friction[i]))

    def passive(_: Any, data: Any) -> None:
        data.qfrc_passive[:] -= friction * np.tanh(data.qvel / CREEP)

    compiled, rates = mujoco_model(definition, edit)
    mj.set_mjcb_passive(passive if smooth else None)
    try:
        data = run_mujoco(compiled, rates, None, STOP, steps)
    finally:
        mj.set_mjcb_passive(None)
    last = mj.mj_name2id(compiled, mj.mjtObj.mjOBJ_BODY, definition.bodies[-1].name)
    return data.xpos[last] + data.xmat[last].reshape(3, 3) @ POINT


def trajectory() -> dict[str, float]:
    """Distances [m] from MuJoCo's converged end: ours by two methods. And from its end with its own law of friction:
    with our law, and with ours as it creeps at SHARP.
    """
    arm = model()
    ends = [mujoco_end(arm, steps, smooth=True) for steps in (STEPS, 2 * STEPS)]
    limit = ends[1] + (ends[1] - ends[0]) / 15
    tight = {"absolute_tolerance": 1e-13, "relative_tolerance": 1e-13}
    found = {
        "mujoco": ends[1],
        "rkmk4": our_end(arm, 2 * STEPS, method=RKMK4, **tight),
        "coarse": our_end(arm, STEPS),
        "fine": our_end(arm, 2 * STEPS),
    }
    own = mujoco_end(arm, 2 * STEPS, smooth=False)
    return {key: float(np.abs(x - limit).max()) for key, x in found.items()} | {
        "own friction": float(np.abs(own - limit).max()),
        "sharp friction": float(np.abs(own - our_end(arm, 4 * STEPS, SHARP)).max()),
    }
