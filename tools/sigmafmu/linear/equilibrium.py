"""Search for equilibria and steady motions.

Unknown are the positions ξ and some inputs u, so that the accelerations η' vanish and held outputs have their values.
A step solves the linear model of the moment,

    [∂η'/∂ξ − μ  ∂η'/∂u] [δξ]   [−η'       ]
    [∂y/∂ξ       ∂y/∂u ] [δu] = [y_held − y],

in the least-squares sense. This is Newton's method with μ = 0. μ is proportional to what is left of the residual: far
away, steps follow the accelerations, which lead to a stable equilibrium where one is near; close by, they are Newton's.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from sigmafmu import SigmafmuError, _core
from sigmafmu.linear.coordinates import FRAMES, Coordinates
from sigmafmu.linear.linearization import Linearization
from sigmafmu.linear.names import choose
from sigmafmu.linear.point import OperatingPoint, operating_point
from sigmafmu.model import Model
from sigmafmu.variables import SettingValue

MAX_STEPS = 200
LARGEST_STEP = 0.3
"""Of positions in one step, as part of the mechanism's size (1 rad)."""
TOLERANCE = 1e-9
"""Of accelerations relative to those at the start (at least 1 in SI units), of held values in SI units."""


def trim(
    model: Model | str | Path,
    at: float = 0.0,
    *,
    parameters: Mapping[str, SettingValue] | None = None,
    u0: Mapping[str, SettingValue] | None = None,
    inputs: Iterable[str] = (),
    hold: Mapping[str, float] | None = None,
) -> OperatingPoint:
    """An equilibrium of `model`, near where it is at time `at` [s].

    `inputs` are those that may change; others stay at `u0`. `hold` gives outputs their values. Without it, positions
    stay as they are if there are `inputs`, and are sought if there are none. The mechanism is at rest, except for
    rates of coordinates in `hold`, such as `top.angularVelocity[2]`: then the motion is steady with these rates.
    Raises SigmafmuError for names and values that are wrong, and if no equilibrium is found, with what is left.
    """
    start = operating_point(model, at, parameters=parameters, u0=u0)
    return _Search(start, inputs, dict(hold or {})).run()


def _rates(point: OperatingPoint, frame: str) -> dict[str, str]:
    """Names of coordinates by the names of their rates."""
    coordinates = Coordinates(point.mechanism, _core.System(point.mechanism.multibody), frame)
    return {c.rate: c.name for c in coordinates.all}


class _Search:
    def __init__(self, start: OperatingPoint, inputs: Iterable[str], hold: dict[str, float]):
        rates = {frame: _rates(start, frame) for frame in FRAMES}
        self.frame = max(FRAMES, key=lambda frame: len(rates[frame].keys() & hold.keys()))
        first = Linearization(start, self.frame)
        self.rate_values: dict[str, float] = {}
        held: dict[int, float] = {}
        for name, value in hold.items():
            if not np.isfinite(value):
                raise SigmafmuError(f"'{name}' must be finite, not {value}")
            if name in rates[self.frame]:
                self.rate_values[name] = value
            else:
                (index, *others) = choose(first.outputs.names, [name], "output", start.model)
                if others:
                    raise SigmafmuError(f"'{name}' is a vector; hold its elements, such as {name}[1]")
                held[index] = value
        self.wanted = [rates[self.frame][name] for name in self.rate_values]
        self.columns = choose(first.outputs.inputs, inputs, "input", start.model)
        self.rows, self.values = list(held), np.array(list(held.values()))
        self.moves = bool(hold) or not inputs
        self.start = start

    def run(self) -> OperatingPoint:
        linear = self._at(self.start.q, self.start.u, self.start.turned)
        accelerations, gap = self._residual(linear)
        allowed = TOLERANCE * max(1.0, float(np.abs(accelerations).max()))
        for _ in range(MAX_STEPS):
            found = np.abs(accelerations).max() <= allowed and np.abs(gap).max(initial=0.0) <= TOLERANCE
            linear = self._step(linear, accelerations, gap)  # if found, the step that brings it down to rounding
            if found:
                return linear.point
            accelerations, gap = self._residual(linear)
        raise SigmafmuError(self._failure(linear, accelerations, gap))

    def _at(self, q: np.ndarray, u: np.ndarray, turned: np.ndarray) -> Linearization:
        """The point at these positions, with the velocities of the motion that is sought."""
        still = replace(self.start, q=q, v=np.zeros_like(self.start.v), u=u, turned=turned, time=0.0)
        linear = Linearization(still, self.frame, self.wanted)
        if not self.rate_values:
            return linear
        rates = np.array([self.rate_values.get(c.rate, 0.0) for c in linear.rates])
        return Linearization(replace(still, v=linear.rates_to_velocities(rates)), self.frame, self.wanted)

    def _residual(self, linear: Linearization) -> tuple[np.ndarray, np.ndarray]:
        """What should vanish: accelerations, and what is missing to held outputs."""
        accelerations, y = linear.accelerations_and_outputs()
        return accelerations, y[self.rows] - self.values

    def _step(self, linear: Linearization, accelerations: np.ndarray, gap: np.ndarray) -> Linearization:
        point, freedom = linear.point, len(linear.chosen)
        by_input = linear.by_input(self.columns)
        blocks = [np.vstack([by_input.accelerations, by_input.outputs[self.rows]])]
        if self.moves:
            by_position = linear.by_position()
            follow = linear.rates_to_velocities(accelerations)
            damping = np.abs(follow / linear.size).max() / LARGEST_STEP
            damped = by_position.accelerations - damping * linear.motion_of_rates().T
            blocks.insert(0, np.vstack([damped, by_position.outputs[self.rows]]))
        step = np.linalg.lstsq(np.hstack(blocks), -np.concatenate([accelerations, gap]), rcond=1e-12)[0]
        q = point.q
        if self.moves:
            size = np.abs(linear.selection.motions @ step[:freedom] / linear.size).max()
            step *= min(1.0, LARGEST_STEP / size) if size else 1.0
            q = self._moved(linear, linear.selection.motions @ step[:freedom])
        u = point.u.copy()
        u[self.columns] += step[len(step) - len(self.columns) :]
        return self._at(q, u, linear.coordinates.turned(q, point.turned))

    def _moved(self, linear: Linearization, motion: np.ndarray) -> np.ndarray:
        try:
            return linear.system.project_positions(linear.system.compose(linear.point.q, motion))
        except RuntimeError as error:
            raise SigmafmuError(f"found no equilibrium of {self.start.model}: on the way, {error}") from error

    def _failure(self, linear: Linearization, accelerations: np.ndarray, gap: np.ndarray) -> str:
        what = f"found no equilibrium of {self.start.model}"
        worst = int(np.abs(accelerations).argmax())
        coordinate = linear.rates[worst]
        told = f"der({coordinate.rate}) is still {accelerations[worst]:.3g} {coordinate.rate_unit}²"
        if gap.size and np.abs(gap).max() > TOLERANCE:
            name = linear.outputs.names[self.rows[int(np.abs(gap).argmax())]]
            told += f" and {name} is off by {np.abs(gap).max():.3g}"
        return f"{what}: {told}; free other inputs, hold something else or start closer"
