"""MJCF files beside MuJoCo: accelerations without contacts, limits, friction, fluid and equalities."""

from pathlib import Path

import numpy as np

from research.robots import STATES, Compared, Json, State, center_of_mass, compared, without_one_sided
from sigmafmu.importers.convert import convert
from sigmafmu.importers.mjcf import Names, compiled
from sigmafmu.importers.robot import Robot, valid_name


def compare(path: Path, package: str, states: int = STATES) -> Compared:
    """An MJCF file at random states."""
    text, robot = convert(path, Path())
    content = without_one_sided(text)
    _open_loops(content, robot)
    return compared(path, package, robot, content, Reference(path, robot, content), states)


def _open_loops(content: Json, robot: Robot) -> None:
    """MuJoCo's equalities are springs: they are off on both sides, but not what holds the angle of a planar joint."""
    for name, joint in robot.joints.items():
        if joint.closes:
            del content["joints"][name]
    kept = {c.name for c in robot.couplings if c.name.endswith("_angle") and len(c.joints) == 1}
    content["couplings"] = {name: c for name, c in content.get("couplings", {}).items() if name in kept}


class Reference:
    """MuJoCo's model of the same file."""

    def __init__(self, path: Path, robot: Robot, content: Json):
        import mujoco

        self.content = content
        self.model = m = compiled(path)[0]
        self.data = mujoco.MjData(m)
        m.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        m.opt.density = m.opt.viscosity = 0
        m.body_gravcomp[:] = 0
        names = Names(m)
        kinds = mujoco.mjtJoint
        self.hinges = {
            j: robot.coordinates[names.joints[j]]
            for j in range(m.njnt)
            if kinds(m.jnt_type[j]) in (kinds.mjJNT_HINGE, kinds.mjJNT_SLIDE) and names.joints[j] in robot.coordinates
        }
        bodies = {kind: [m.jnt_bodyid[j] for j in range(m.njnt) if m.jnt_type[j] == kind] for kind in (0, 1)}
        self.free = {valid_name(names.bodies[i]): i for i in bodies[int(kinds.mjJNT_FREE)]}
        self.balls = {valid_name(names.bodies[i]): i for i in bodies[int(kinds.mjJNT_BALL)]}

    def at_random(self, rng: np.random.Generator) -> tuple[State, np.ndarray]:
        """A state and its accelerations."""
        import mujoco

        m, data = self.model, self.data
        data.qpos[:] = m.qpos0
        mujoco.mj_integratePos(m, data.qpos, rng.uniform(-1, 1, m.nv), 1.0)
        data.qvel[:] = rng.uniform(-1, 1, m.nv)
        mujoco.mj_forward(m, data)
        state, expected = State(), []
        for j, name in self.hinges.items():
            state.coordinates[name] = float(data.qpos[m.jnt_qposadr[j]]), float(data.qvel[m.jnt_dofadr[j]])
            expected.append(data.qacc_smooth[m.jnt_dofadr[j]])
        for name, i in self.free.items():
            dof = m.body_dofadr[i]
            R, c, w = data.xmat[i].reshape(3, 3), center_of_mass(self.content, name), data.qvel[dof + 3 : dof + 6]
            turning = data.qacc_smooth[dof + 3 : dof + 6]
            state.bodies[name] = {
                "position": data.xpos[i].tolist(),
                "orientation": {"quaternion": data.xquat[i].tolist()},
                "velocity": (data.qvel[dof : dof + 3] + R @ np.cross(w, c)).tolist(),
                "angular_velocity": w.tolist(),
            }
            at_center = np.cross(turning, c) + np.cross(w, np.cross(w, c))
            expected += [*(data.qacc_smooth[dof : dof + 3] + R @ at_center), *turning]
        for name, i in self.balls.items():
            velocity = np.zeros(6)
            mujoco.mj_objectVelocity(m, data, mujoco.mjtObj.mjOBJ_XBODY, i, velocity, 1)
            turned = {"quaternion": data.xquat[i].tolist()}
            state.on_balls[name] = {"orientation": turned, "angular_velocity": velocity[:3].tolist()}
        return state, np.array(expected)
