"""Reads MJCF through MuJoCo's own compiler: https://mujoco.readthedocs.io/en/stable/XMLreference.html.

What is read is the compiled model, in which defaults, includes, orientations and inertias of shapes are resolved.
Indices of its arrays are those of `mujoco.MjModel`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sigmafmu.importers import mjcf_actuators, mjcf_shapes
from sigmafmu.importers.inertia import Inertia, Pose
from sigmafmu.importers.meshes import Meshes
from sigmafmu.importers.robot import (
    GROUND,
    Body,
    Coupling,
    DescriptionError,
    Force,
    Joint,
    Robot,
    Tendon,
    start_within_limits,
)
from sigmafmu.importers.xml import axes_with_z
from sigmafmu.mechanism_file import rotations
from sigmafmu.mechanism_file.problems import one_line

if TYPE_CHECKING:
    import mujoco

LARGEST_STEP = 1e-3
"""Of the integrator [s]."""


def read_mjcf(path: Path, meshes: Meshes) -> Robot:
    """The robot of a file; DescriptionError: MuJoCo refuses it."""
    m, warnings = compiled(path)
    robot = Robot(bytes(m.names).split(b"\0", 1)[0].decode() or path.stem, path.name)
    for text in warnings:
        robot.tell(f"MuJoCo warns: {text}")
    robot.gravity = [float(x) for x in m.opt.gravity]
    robot.step_size = min(float(m.opt.timestep), LARGEST_STEP)
    names = Names(m)
    for i in range(1, m.nbody):
        _body(m, i, names, robot)
    mjcf_shapes.add_shapes(m, names.bodies, robot, meshes)
    _equalities(m, names, robot)
    _tendons(m, names, robot)
    mjcf_actuators.add_actuators(m, names, robot)
    _tell_rest(m, names, robot)
    for text in meshes.tell():
        robot.tell(text)
    return robot


def compiled(path: Path) -> tuple[mujoco.MjModel, list[str]]:
    """MuJoCo's model of a file, and what it warns of, which it would write into a file here."""
    import mujoco

    warnings: list[str] = []
    mujoco.set_mju_user_warning(lambda text: warnings.append(one_line(text)))
    try:
        return mujoco.MjModel.from_xml_path(str(path)), warnings
    except ValueError as error:
        raise DescriptionError(f"{path}: MuJoCo refuses it: {one_line(str(error))}") from error
    finally:
        mujoco.set_mju_user_warning(None)


class Names:
    """What bodies and joints are called: those without a name have one of their number."""

    def __init__(self, m: mujoco.MjModel):
        self.bodies = [m.body(i).name or f"body{i}" for i in range(m.nbody)]
        self.bodies[0] = GROUND
        self.joints = [m.joint(i).name or f"{self.bodies[m.jnt_bodyid[i]]}_joint{i}" for i in range(m.njnt)]


def pose(p: np.ndarray, q: np.ndarray) -> Pose:
    """A frame from MuJoCo's position and quaternion (w, x, y, z)."""
    return Pose(np.array(p, dtype=float), rotations.matrix(np.array(q, dtype=float) / np.linalg.norm(q)))


def _body(m: mujoco.MjModel, i: int, names: Names, robot: Robot) -> None:
    """A body and its joints: several need bodies between, which reduce.py gives what they must have."""
    import mujoco

    body = Body(names.bodies[i])
    axes = pose(np.zeros(3), m.body_iquat[i])
    J = axes.R @ np.diag(m.body_inertia[i]) @ axes.R.T
    body.inertia = Inertia(float(m.body_mass[i]), np.array(m.body_ipos[i]), J)
    body.inertia_axes = axes if np.abs(axes.R - np.eye(3)).max() > 1e-12 else None
    parent, place = names.bodies[m.body_parentid[i]], pose(m.body_pos[i], m.body_quat[i])
    joints = range(m.body_jntadr[i], m.body_jntadr[i] + m.body_jntnum[i])
    if not joints:
        if m.body_mocapid[i] >= 0:
            robot.tell(f"{body.name}: moved from outside in MuJoCo, is fixed")
        robot.joints[f"\0{i}"] = Joint(f"\0{i}", "fixed", (parent, body.name), (place, Pose()))
    for j in joints:
        kind = mujoco.mjtJoint(m.jnt_type[j])
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            at = m.jnt_qposadr[j]
            body.start = pose(m.qpos0[at : at + 3], m.qpos0[at + 3 : at + 7])
            if m.dof_damping[m.jnt_dofadr[j]] or m.dof_armature[m.jnt_dofadr[j]]:
                robot.tell(f"{names.joints[j]}: damping and armature of a free joint")
            continue
        last = j == joints[-1]
        child = body.name if last else f"{body.name}_{names.joints[j]}"
        if not last:
            robot.bodies[child] = Body(child)
        robot.joints[names.joints[j]] = _joint(m, j, names.joints[j], (parent, child), place, robot)
        parent, place = child, Pose()
    robot.bodies[body.name] = body


def _joint(m: mujoco.MjModel, j: int, name: str, bodies: tuple[str, str], place: Pose, robot: Robot) -> Joint:
    import mujoco

    dof, at = m.jnt_dofadr[j], np.array(m.jnt_pos[j])
    if m.jnt_type[j] == mujoco.mjtJoint.mjJNT_BALL:
        frames = (place @ Pose(at), Pose(at))
        resists = {"torsional_stiffness": float(m.jnt_stiffness[j]), "torsional_damping": float(m.dof_damping[dof])}
        if keys := {key: [value] * 3 for key, value in resists.items() if value}:
            robot.forces.append(Force(f"{name}_bushing", "bushing", bodies, frames, keys))
        if resists["torsional_damping"]:
            robot.tell(
                f"{name}: damping of a ball joint acts on the rate of its rotation vector, alike for small angles"
            )
        if m.dof_armature[dof] or m.dof_frictionloss[dof] or m.jnt_limited[j]:
            robot.tell(f"{name}: armature, friction and limits of a ball joint")
        return Joint(name, "spherical", bodies, frames)
    turns = m.jnt_type[j] == mujoco.mjtJoint.mjJNT_HINGE
    frame = Pose(at, axes_with_z(np.array(m.jnt_axis[j])))
    ref = float(m.qpos0[m.jnt_qposadr[j]])
    z = np.array([0.0, 0.0, ref])
    back = Pose(R=rotations.matrix(rotations.of_vector(-z))) if turns else Pose(-z)
    keys: dict[str, Any] = {"coordinate": ref} if ref else {}
    if m.jnt_stiffness[j]:
        keys["stiffness"] = float(m.jnt_stiffness[j])
        if rest := float(m.qpos_spring[m.jnt_qposadr[j]]):
            keys["rest"] = rest
    for key, value in (("damping", m.dof_damping), ("friction", m.dof_frictionloss), ("armature", m.dof_armature)):
        if value[dof]:
            keys[key] = float(value[dof])
    if m.jnt_limited[j]:
        keys["limits"] = [float(x) for x in m.jnt_range[j]]
        start_within_limits(robot, name, keys)
    if np.any(_later(m, "jnt_stiffnesspoly", m.njnt)[j]) or np.any(_later(m, "dof_dampingpoly", m.nv)[dof]):
        robot.tell(f"{name}: what is not linear of its stiffness and damping")
    axis = ", ".join(f"{x:.6g}" for x in m.jnt_axis[j] + 0.0)
    comment = f"axis [{axis}] of {bodies[1]}"
    return Joint(name, "revolute" if turns else "prismatic", bodies, (place @ frame @ back, frame), keys, comment)


def _later(m: mujoco.MjModel, name: str, count: int) -> np.ndarray:
    """An array that only later versions of MuJoCo have: zeros before."""
    return getattr(m, name, np.zeros(count))


def _ends(m: mujoco.MjModel, e: int, names: Names) -> tuple[tuple[str, str], tuple[Pose, Pose]]:
    """The bodies of an equality, and the frames of its sites if it has some."""
    import mujoco

    ids = (m.eq_obj1id[e], m.eq_obj2id[e])
    if m.eq_objtype[e] != mujoco.mjtObj.mjOBJ_SITE:
        return (names.bodies[ids[0]], names.bodies[ids[1]]), (Pose(), Pose())
    one, two = (names.bodies[m.site_bodyid[site]] for site in ids)
    first, second = (pose(m.site_pos[site], m.site_quat[site]) for site in ids)
    return (one, two), (first, second)


def _equalities(m: mujoco.MjModel, names: Names, robot: Robot) -> None:
    """Loops become joints, equations between coordinates couplings."""
    import mujoco

    kinds = mujoco.mjtEq
    for e in range(m.neq):
        kind = kinds(m.eq_type[e])
        name = m.equality(e).name or f"{kind.name.removeprefix('mjEQ_').lower()}{e}"
        data = m.eq_data[e]
        if not m.eq_active0[e]:
            robot.tell(f"{name}: an equality that is off at the start")
        elif kind in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
            bodies, (first, second) = _ends(m, e, names)
            sites = m.eq_objtype[e] == mujoco.mjtObj.mjOBJ_SITE
            if kind == kinds.mjEQ_CONNECT:
                frames = (first, second) if sites else (Pose(np.array(data[:3])), Pose(np.array(data[3:6])))
                robot.joints[name] = Joint(name, "spherical", bodies, frames, closes=True)
            else:
                frames = (first, second) if sites else (pose(data[3:6], data[6:10]), Pose(np.array(data[:3])))
                robot.joints[name] = Joint(name, "fixed", bodies, frames, closes=True)
        elif kind == kinds.mjEQ_JOINT:
            robot.couplings.append(_mimic(m, e, name, names))
        elif kind == kinds.mjEQ_TENDON and (coupling := _coupled_tendons(m, e, name, names)):
            robot.couplings.append(coupling)
        else:
            robot.tell(f"{name}: an equality of the kind {kind.name.removeprefix('mjEQ_').lower()}")
    if m.neq:
        robot.tell("equalities: they hold exactly here, as joints and couplings, and not by stiff springs")


def _mimic(m: mujoco.MjModel, e: int, name: str, names: Names) -> Coupling:
    """y - y0 = sum a_k (x - x0)^k, as a polynomial in x."""
    first, second = m.eq_obj1id[e], m.eq_obj2id[e]
    y0 = float(m.qpos0[m.jnt_qposadr[first]])
    if second < 0:
        held = {"polynomials": [[0, 1]], "offset": y0 + float(m.eq_data[e][0])}
        return Coupling(name, "sum", [names.joints[first]], held)
    x0 = float(m.qpos0[m.jnt_qposadr[second]])
    polynomial = np.polynomial.Polynomial(m.eq_data[e][:5])(np.polynomial.Polynomial([-x0, 1.0])) + y0
    coefficients = np.trim_zeros(polynomial.coef, "b").tolist()
    coefficients += [0.0] * (2 - len(coefficients))
    return Coupling(name, "mimic", [names.joints[first], names.joints[second]], {"polynomial": coefficients})


def _fixed_tendon(m: mujoco.MjModel, t: int) -> dict[int, float] | None:
    """Coefficients by the joint, if its length is a sum of coordinates."""
    import mujoco

    wraps = range(m.tendon_adr[t], m.tendon_adr[t] + m.tendon_num[t])
    if any(m.wrap_type[w] != mujoco.mjtWrap.mjWRAP_JOINT for w in wraps):
        return None
    return {int(m.wrap_objid[w]): float(m.wrap_prm[w]) for w in wraps}


def _coupled_tendons(m: mujoco.MjModel, e: int, name: str, names: Names) -> Coupling | None:
    """L1 - L1_0 = a0 + a1 (L2 - L2_0) of fixed tendons, as a sum that stays constant."""
    first, second, a = m.eq_obj1id[e], m.eq_obj2id[e], m.eq_data[e][:5]
    terms = _fixed_tendon(m, first)
    offset = float(m.tendon_length0[first] + a[0])
    if terms is None or np.any(a[2:]):
        return None
    if second >= 0:
        others = _fixed_tendon(m, second)
        if others is None:
            return None
        offset -= float(a[1] * m.tendon_length0[second])
        for joint, factor in others.items():
            terms[joint] = terms.get(joint, 0.0) - float(a[1]) * factor
    polynomials = [[0.0, factor] for factor in terms.values()]
    held = {"polynomials": polynomials, "offset": offset}
    return Coupling(name, "sum", [names.joints[joint] for joint in terms], held)


def straight_tendon(m: mujoco.MjModel, t: int, names: Names) -> tuple[tuple[str, str], tuple[Pose, Pose]] | None:
    """Bodies and frames of a tendon that goes straight from one site to another."""
    import mujoco

    wraps = range(m.tendon_adr[t], m.tendon_adr[t] + m.tendon_num[t])
    if len(wraps) != 2 or any(m.wrap_type[w] != mujoco.mjtWrap.mjWRAP_SITE for w in wraps):
        return None
    one, two = (int(m.wrap_objid[w]) for w in wraps)
    bodies = names.bodies[m.site_bodyid[one]], names.bodies[m.site_bodyid[two]]
    return (bodies, (Pose(np.array(m.site_pos[one])), Pose(np.array(m.site_pos[two])))) if len({*bodies}) == 2 else None


def tendon_name(m: mujoco.MjModel, t: int) -> str:
    """Its name, or its number."""
    return m.tendon(t).name or f"tendon{t}"


def _tendons(m: mujoco.MjModel, names: Names, robot: Robot) -> None:
    """Straight ones are line springs, those over coordinates tendons."""
    for t in range(m.ntendon):
        name, ends, terms = tendon_name(m, t), straight_tendon(m, t, names), _fixed_tendon(m, t)
        low, high = (float(x) for x in m.tendon_lengthspring[t])
        acts = {"stiffness": float(m.tendon_stiffness[t]), "damping": float(m.tendon_damping[t])}
        keys: dict[str, Any] = {key: value for key, value in acts.items() if value}
        if m.tendon_stiffness[t]:
            keys["free_length"] = low
        one_length = low == high or not m.tendon_stiffness[t]
        if ends and one_length:
            robot.forces.append(Force(name, "line_spring", *ends, keys))
        elif terms and one_length and keys:
            joints = [names.joints[joint] for joint in terms]
            robot.tendons.append(Tendon(name, joints, {"coefficients": list(terms.values())} | keys))
        elif keys:
            robot.tell(f"{name}: stiffness and damping of a tendon")
        if np.any(_later(m, "tendon_stiffnesspoly", m.ntendon)[t]) or np.any(
            _later(m, "tendon_dampingpoly", m.ntendon)[t]
        ):
            robot.tell(f"{name}: what is not linear of its stiffness and damping")
        armature = _later(m, "tendon_armature", m.ntendon)[t]
        if m.tendon_limited[t] or m.tendon_frictionloss[t] or armature:
            robot.tell(f"{name}: limits, friction and armature of a tendon")


def _tell_rest(m: mujoco.MjModel, names: Names, robot: Robot) -> None:
    """What a mechanism file has nothing for."""
    for text in _absent(m, names):
        robot.tell(text)


def _absent(m: mujoco.MjModel, names: Names) -> Iterator[str]:
    if np.any(m.geom_contype) or m.npair:
        yield "contacts"
    if m.opt.density or m.opt.viscosity or np.any(m.opt.wind):
        yield "forces of a fluid"
    if m.nsensor:
        yield "sensors"
    lifted = [names.bodies[i] for i in np.flatnonzero(m.body_gravcomp)]
    if lifted:
        yield f"gravity compensation of {', '.join(lifted)}"
    for count, what in (
        (m.nkey, "keyframes"),
        (m.nflex, "flexible bodies"),
        (m.nskin, "skins"),
        (m.nplugin, "plugins"),
    ):
        if count:
            yield what
