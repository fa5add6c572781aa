"""A mechanism as an environment of Gymnasium."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from sigmafmu import SigmafmuError
from sigmafmu.gym.channels import Names, Outputs, acted, observed, read_also
from sigmafmu.gym.start import Start, Starts
from sigmafmu.instance import Instance, SimulationError, State
from sigmafmu.model import Model, load
from sigmafmu.steps import communication_steps
from sigmafmu.variables import SettingValue, parse_settings

Reward = str | Callable[[Outputs, np.ndarray], float]


class MechanismEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """A model on a live instance: its inputs are the actions, its outputs the observations.

    `model` is what `sigmafmu.load` takes, or a `Model`. `observations` are outputs: scalars, vectors or patterns, or a
    mapping of such names to bounds (low, high), which become those of the observation space and change nothing else.
    `actions` are inputs, or a mapping of them to bounds; both default to the minimum and maximum that the model tells.
    Spaces are boxes of float64: (observations,) in SI units, and (actions,) from -1, the lower bound, to 1, the upper
    one; what is outside is taken as the nearest of these. Inputs hold during a step of `H` [s] (default: the model's).

    `reward` is the name of an output, or a function of (outputs, action): values by name, with `time` [s], and an
    array (actions,) of what was set, in SI units. `terminated`, a function of the outputs, ends an episode. Both see
    the observations and `outputs`, more names. An episode is truncated after `max_steps`, or at `stop_time` [s]
    (default: the model's; infinity: never), and when the model refuses to go on: then `info["error"]` tells why, the
    observation is the last one, and the reward 0.

    `parameters` are constants, or distributions that each `reset` draws from: those of SciPy, or texts as in
    `sigmafmu sweep`, such as `U(-0.1,0.1)`. `info["parameters"]` of `reset` has what was drawn; its
    `options={"parameters": {…}}` sets values for one episode.

    Same seeds and actions give the same bits. Raises SigmafmuError for names, bounds and values that are wrong, and
    SimulationError if the model refuses to start.
    """

    def __init__(
        self,
        model: str | Path | Model,
        *,
        observations: Names,
        actions: Names,
        reward: Reward,
        H: float | None = None,
        terminated: Callable[[Outputs], bool] | None = None,
        outputs: Iterable[str] = (),
        parameters: Mapping[str, Start] | None = None,
        max_steps: int | None = None,
        stop_time: float | None = None,
    ):
        self.model = model if isinstance(model, Model) else load(model)
        """The model that runs."""
        fmu = self.model.fmu
        self.H = communication_steps(fmu, step_size=H).step_size
        """Communication step [s]."""
        self._most_steps = _most_steps(self.model, self.H, max_steps, stop_time)

        seen = observed(fmu, observations)
        self._observed = len(seen.names)
        self.observation_space = Box(seen.low, seen.high, dtype=np.float64)
        also = [*read_also(fmu, outputs), *(read_also(fmu, [reward]) if isinstance(reward, str) else ())]
        self._names = tuple(dict.fromkeys([*seen.names, *also]))
        self._reward = _named(reward) if isinstance(reward, str) else reward
        self._terminated = terminated

        self._acted = acted(fmu, actions)
        self._middle, self._half = (self._acted.high + self._acted.low) / 2, (self._acted.high - self._acted.low) / 2
        self.action_space = Box(-1.0, 1.0, self._middle.shape, dtype=np.float64)

        self._starts = Starts(fmu, parameters or {})
        self._instance: Instance | None = None
        self._initial: State | None = None
        self._steps = -1
        self._row = np.zeros(len(self._names))

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict]:
        """Start an episode; `options={"parameters": {…}}` are values for this one."""
        super().reset(seed=seed)
        drawn: dict[str, Any] = dict(self._starts.draw(self.np_random)) | self._chosen(options or {})
        if self._instance is None:
            self._instance = self.model.instance()
        if drawn or self._initial is None:
            self._instance.reset(self._starts.constants | drawn)
            self._instance.start()
            if not drawn:
                self._initial = self._instance.save()
        else:
            self._instance.restore(self._initial)
        self._steps = 0
        self._row = self._instance.get(self._names)
        return self._row[: self._observed].copy(), {"time": 0.0, "parameters": drawn}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Set the inputs, and step by `H`: observation, reward, terminated, truncated, info with `time` [s]."""
        if self._instance is None or self._steps < 0:
            raise SigmafmuError("the environment has not been started; call reset()")
        u = self._inputs(action)
        info: dict[str, Any] = {}
        self._steps += 1
        try:
            with self._instance.calls():
                self._instance.slave.setReal(self._acted.references, u)
            self._instance.step(self.H)
            self._row = self._instance.get(self._names)
        except SimulationError as error:
            info |= {"time": self._instance.time, "error": str(error)}
            return self._row[: self._observed].copy(), 0.0, False, True, info
        outputs = Outputs(zip(self._names, self._row.tolist(), strict=True), time=self._instance.time)
        reward = float(self._reward(outputs, u))
        terminated = bool(self._terminated and self._terminated(outputs))
        info["time"] = self._instance.time
        return self._row[: self._observed].copy(), reward, terminated, self._steps >= self._most_steps, info

    def close(self) -> None:
        """Free the instance."""
        if self._instance:
            self._instance.close()
        self._instance, self._initial, self._steps = None, None, -1

    def _inputs(self, action: np.ndarray) -> np.ndarray:
        a = np.asarray(action, dtype=float)
        if a.shape != self._middle.shape or not np.isfinite(a).all():
            raise SigmafmuError(f"an action is {len(self._middle)} finite numbers from -1 to 1, not {action!r}")
        return self._middle + self._half * np.clip(a, -1.0, 1.0)

    def _chosen(self, options: Mapping[str, Any]) -> dict[str, SettingValue]:
        if unknown := set(options) - {"parameters"}:
            raise SigmafmuError(f"reset has no option '{min(unknown)}'; it has 'parameters'")
        values = dict(options.get("parameters", {}))
        parse_settings(self.model.fmu, values)
        return values


def _named(name: str) -> Callable[[Outputs, np.ndarray], float]:
    return lambda outputs, _: outputs[name]


def _most_steps(model: Model, H: float, max_steps: int | None, stop_time: float | None) -> float:
    if max_steps is not None and stop_time is not None:
        raise SigmafmuError("an episode ends after max_steps or at stop_time; give one of them")
    if max_steps is not None:
        if max_steps < 1 or not float(max_steps).is_integer():
            raise SigmafmuError(f"max_steps must be a positive integer, not {max_steps}")
        return max_steps
    if stop_time is not None and math.isinf(stop_time) and stop_time > 0:
        return math.inf
    return len(communication_steps(model.fmu, stop_time, H))
