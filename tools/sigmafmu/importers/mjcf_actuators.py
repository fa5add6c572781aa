"""Actuators of MJCF: force = gear (gain command + b0 + b1 length + b2 rate) on a joint, length = gear coordinate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sigmafmu.importers.robot import Robot

if TYPE_CHECKING:
    import mujoco

    from sigmafmu.importers.mjcf import Names


def add_actuators(m: mujoco.MjModel, names: Names, robot: Robot) -> None:
    """Motors are inputs that joints have anyway; servos become springs and dampers."""
    import mujoco

    motors, servos, absent = [], [], []
    for a in range(m.nu):
        name = m.actuator(a).name or f"actuator{a}"
        on_joint = mujoco.mjtTrn(m.actuator_trntype[a]) == mujoco.mjtTrn.mjTRN_JOINT
        direct = m.actuator_dyntype[a] == mujoco.mjtDyn.mjDYN_NONE
        plain = direct and m.actuator_gaintype[a] == mujoco.mjtGain.mjGAIN_FIXED
        bias = mujoco.mjtBias(m.actuator_biastype[a])
        b0, b1, b2 = (
            (float(x) for x in m.actuator_biasprm[a][:3]) if bias == mujoco.mjtBias.mjBIAS_AFFINE else (0, 0, 0)
        )
        known = bias in (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE)
        joint = robot.joints.get(names.joints[m.actuator_trnid[a][0]]) if on_joint else None
        if joint is None or joint.type not in ("revolute", "prismatic") or not (plain and known) or b1 > 0 or b2 > 0:
            absent.append(name)
            continue
        gear = float(m.actuator_gear[a][0])
        if b1 == 0 and b2 == 0 and b0 == 0:
            motors.append(f"{name} ({float(m.actuator_gainprm[a][0]) * gear:g} x its command at {joint.name})")
            continue
        _add_spring(joint.keys, -b1 * gear**2, -b2 * gear**2, b0 * gear)
        servos.append(f"{name} at {joint.name}")
    if motors:
        robot.tell(f"motors, whose forces are inputs of joints: {', '.join(motors)}")
    if servos:
        robot.tell(f"servos, which are springs and dampers with their command in `rest`: {', '.join(servos)}")
    if absent:
        robot.tell(f"other actuators: {', '.join(absent)}")


def _add_spring(keys: dict[str, Any], stiffness: float, damping: float, force: float) -> None:
    """A spring beside that which is there: k1 (r1 - x) + k2 (r2 - x) is one spring."""
    k, pull = keys.get("stiffness", 0.0), keys.get("stiffness", 0.0) * keys.get("rest", 0.0)
    if k + stiffness:
        keys["stiffness"] = k + stiffness
        if rest := (pull + force) / (k + stiffness):
            keys["rest"] = rest
    if damping:
        keys["damping"] = keys.get("damping", 0.0) + damping
