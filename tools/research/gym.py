"""What a step of an environment costs: ours and Gymnasium's of MuJoCo, on the same pendulum, in the same run.

`python -m research gym` writes the table into docs/gym.md.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from time import process_time
from typing import Any, ClassVar
from xml.etree import ElementTree

import numpy as np
from scipy.integrate import solve_ivp

from research.bench import machine
from research.bench.trees import links, mujoco_tree
from research.page import check, put
from sigmafmu.gym import MechanismEnv
from sigmafmu.markdown import markdown_table
from sigmafmu.mechanism_file.load import load
from sigmafmu.realtime import native_steps

COMMAND = "python -m research gym"
PENDULUM = """
sigmafmu: 1
name: Pendulum
gravity: [0, -9.81, 0]
bodies: { rod: { mass: 1, inertia: [1.0e-4, 0.02, 0.02], position: [0.25, 0, 0] } }
joints: { hinge: { type: revolute, bodies: [ground, rod], point: [0, 0, 0], axis: [0, 0, 1] } }
experiment: { stop_time: 1 }
"""
MASS, INERTIA, LEVER, GRAVITY = 1.0, 0.02, 0.25, 9.81
H = 0.01  # s, of a step of an environment
INNER = (1, 10)
"""Internal steps in one of these."""
TORQUE = 1.0  # N m, for an action of 1
STEPS = 100
"""Of an episode; the error is that of the angle at its end."""
EPISODES = 5


def actions() -> np.ndarray:
    """Of an episode, between -1 and 1."""
    return np.random.default_rng(1).uniform(-1, 1, (STEPS, 1))


def exact() -> float:
    """The pendulum's angle at the end [rad]."""
    angle, rate = 0.0, 0.0
    for (u,) in TORQUE * actions():

        def rhs(_: float, y: np.ndarray, u: float = u) -> list[float]:
            return [y[1], (u - MASS * GRAVITY * LEVER * np.cos(y[0])) / (INERTIA + MASS * LEVER**2)]

        angle, rate = solve_ivp(rhs, (0.0, H), (angle, rate), "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return angle


class _Ours:
    """Environment and FMU of ours; `method` is one of the integrator's."""

    def __init__(self, file: Path, method: str, inner: int):
        parameters = {"integrator.method": method, "integrator.stepSize": H / inner}
        self.env = MechanismEnv(
            file,
            observations=["hinge.angle", "hinge.angularRate"],
            actions={"hinge.motorTorque": (-TORQUE, TORQUE)},
            reward="hinge.angle",
            H=H,
            parameters=parameters,
            max_steps=STEPS + 1,
        )
        self._model, self._parameters = self.env.model, parameters

    def alone(self) -> float:
        """Seconds of a step without an environment, called from C++."""
        with self._model.instance(self._parameters) as m:
            m.start()
            began = process_time()
            native_steps(m.slave, H, STEPS)
            return (process_time() - began) / STEPS


class _Theirs:
    """Gymnasium's environment of MuJoCo, and MuJoCo without it."""

    def __init__(self, xml: Path, integrator: str, inner: int):
        import mujoco as mj
        from gymnasium.envs.mujoco import MujocoEnv
        from gymnasium.spaces import Box

        class Pendulum(MujocoEnv):
            metadata: ClassVar[dict[str, Any]] = {
                "render_modes": ["human", "rgb_array", "depth_array", "rgbd_tuple"],
                "render_fps": round(1 / H),
            }

            def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
                self.do_simulation(action, self.frame_skip)
                x = self._read()
                return x, float(x[0]), False, False, {"time": self.data.time}

            def reset_model(self) -> np.ndarray:
                self.set_state(self.init_qpos, self.init_qvel)
                return self._read()

            def _read(self) -> np.ndarray:
                return np.concatenate([self.data.qpos, self.data.qvel])

        text = xml.read_text(encoding="utf-8")
        text = text.replace("<option ", f'<option timestep="{H / inner!r}" integrator="{integrator}" ')
        own = xml.with_name(f"{integrator}{inner}.xml")
        own.write_text(text, encoding="utf-8")
        self.env = Pendulum(str(own), inner, Box(-np.inf, np.inf, (2,), dtype=np.float64))
        self._mj, self._inner = mj, inner

    def alone(self) -> float:
        """Seconds of a step without an environment, called from C."""
        model = self.env.unwrapped.model
        data = self._mj.MjData(model)
        began = process_time()
        self._mj.mj_step(model, data, nstep=self._inner * STEPS)
        return (process_time() - began) / STEPS


def _episode(env: Any) -> tuple[float, float]:
    """Seconds of a step, and the angle at the end."""
    env.reset(seed=1)
    todo = actions()
    began = process_time()
    for a in todo:
        x, *_ = env.step(a)
    return (process_time() - began) / STEPS, float(x[0])


def _reset(env: Any) -> float:
    began = process_time()
    for _ in range(STEPS):
        env.reset()
    return (process_time() - began) / STEPS


def measure(rounds: int, tell: Callable[[str], None]) -> list[dict[str, Any]]:
    """A row for each way: medians of rounds, all in turn."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "Pendulum.yaml").write_text(PENDULUM, encoding="utf-8")
        multibody = load(folder / "Pendulum.yaml").mechanism.multibody
        root = mujoco_tree(multibody, links(multibody))
        motors = ElementTree.SubElement(root, "actuator")
        limits = {"ctrllimited": "true", "ctrlrange": "-1 1", "gear": repr(TORQUE)}
        ElementTree.SubElement(motors, "motor", joint="rod", **limits)
        (folder / "pendulum.xml").write_text(ElementTree.tostring(root, encoding="unicode"), encoding="utf-8")
        ways: dict[tuple[str, int], Any] = {}
        for inner in INNER:
            for method in ("generalizedAlpha", "rkmk4"):
                ways[f"ours, {method}", inner] = _Ours(folder / "Pendulum.yaml", method, inner)
            for label, integrator in (("Euler", "Euler"), ("RK4", "RK4")):
                ways[f"MuJoCo, {label}", inner] = _Theirs(folder / "pendulum.xml", integrator, inner)
        taken: dict[tuple[str, int], list[tuple[float, ...]]] = {key: [] for key in ways}
        for i in range(rounds):
            tell(f"round {i + 1} of {rounds}")
            for key, way in ways.items():
                seconds, angle = _episode(way.env)
                taken[key].append((seconds, way.alone(), _reset(way.env), angle))
        for way in ways.values():
            way.env.close()
    end = exact()
    rows = []
    for (label, inner), values in taken.items():
        step, alone, reset, angle = np.median(values, axis=0)
        rows.append(
            {"way": label, "h": H / inner, "step": step, "alone": alone, "reset": reset, "error": abs(angle - end)}
        )
    return rows


def table(rows: list[dict[str, Any]]) -> str:
    """With the ratio to MuJoCo's RK4 at the same h."""
    theirs = {row["h"]: row for row in rows if row["way"] == "MuJoCo, RK4"}
    return markdown_table(
        ("", "h [ms]", "steps per second", "beside MuJoCo, RK4", "step alone [µs]", "reset [µs]", "error [rad]"),
        [
            [
                row["way"],
                f"{1e3 * row['h']:g}",
                f"{round(1 / row['step'], -2):.0f}",
                f"{theirs[row['h']]['step'] / row['step']:.2f}",
                f"{1e6 * row['alone']:.1f}",
                f"{1e6 * row['reset']:.0f}",
                f"{row['error']:.0e}",
            ]
            for row in rows
        ],
    )


def write(page: Path, rounds: int, tell: Callable[[str], None]) -> None:
    """Measure, and put it into the page."""
    check(page, COMMAND)
    rows = measure(rounds, tell)
    put(page, COMMAND, f"{machine()},\nGymnasium {version('gymnasium')}. Medians of {rounds} rounds.\n\n{table(rows)}")
