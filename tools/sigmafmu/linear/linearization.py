"""A, B, C and D of a mechanism in the coordinates of `sigmafmu.linear.coordinates`.

Let x = (ξ, η) be deviations from the motion through the point: of the chosen coordinates and of their rates
η = L(q) v. Neighbours that satisfy the constraints B v = 0 are, to first order,

    δq = E ξ,   δv = E η + D ξ      with  B E = 0, L E = 1,  B D = −(∂(B v)/∂q) E,  L D = −(∂(L v)/∂q) E,

and v̇ from the index-1 equations gives, with ∂ along these motions,

    ξ' = G ξ + η,                      G = dL/dt E − ∂(L v)/∂q E − L v̂ E
    η' = ∂(L v̇ + dL/dt v).

G is zero for coordinates that are integrals of their rates. For rotations it is ω̃ in W and −ω̃ in the body.

Joints that roll hold velocities more than positions: of B, E has the rows of positions alone. Then there are fewer
rates than coordinates, those of some of them, with a gradient L_v and motions E_v of their own, and

    δq = E ξ,   δv = E_v η + D ξ    with  B E_v = 0, L_v E_v = 1,  L_v D = −(∂(L_v v)/∂q) E,

    ξ' = G ξ + L E_v η,                G = L D + dL/dt E − L v̂ E.

All derivatives are differences of order 8. Those with respect to inputs are exact, since accelerations are affine in
them.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sigmafmu import SigmafmuError, _core
from sigmafmu.linear.coordinates import Coordinates, difference_time, select, sizes
from sigmafmu.linear.differences import RELATIVE_STEP, derivative
from sigmafmu.linear.model import LinearModel
from sigmafmu.linear.names import choose
from sigmafmu.linear.point import OperatingPoint, operating_point
from sigmafmu.model import Model
from sigmafmu.variables import SettingValue

DIAGNOSTICS = ("constraint.", "integrator.")
"""Outputs that tell about the solver; they are no functions of the state."""


def linearize(
    model: Model | str | Path | OperatingPoint,
    at: float = 0.0,
    *,
    parameters: Mapping[str, SettingValue] | None = None,
    u0: Mapping[str, SettingValue] | None = None,
    inputs: Iterable[str] | None = None,
    outputs: Iterable[str] | None = None,
    coordinates: Iterable[str] = (),
    frame: str = "world",
) -> LinearModel:
    """Linearise `model` at time `at` [s] of its motion with the constant inputs `u0`, or about a point from `trim`.

    `model` is a `Model`, or what `load` takes; `parameters` are those of `Model.run`. `inputs` and `outputs` are names,
    whole vectors or patterns; default: all. `coordinates` are wanted among the states. `frame` is that of rotations and
    displacements of bodies: `world` or `body`. Raises SigmafmuError for names and values that are wrong, and where the
    mechanism does not get to `at`, cannot move or is singular.
    """
    if not isinstance(model, OperatingPoint):
        point = operating_point(model, at, parameters=parameters, u0=u0)
    elif parameters or u0 or at:
        raise SigmafmuError("a point has its time, parameters and inputs already")
    else:
        point = model
    return Linearization(point, frame, coordinates).model(inputs, outputs)


@dataclass(frozen=True, eq=False)
class Derivatives:
    """How accelerations η' and outputs change with ξ, η and u."""

    accelerations: np.ndarray
    outputs: np.ndarray


class Linearization:
    """The equations of motion about one point."""

    def __init__(self, point: OperatingPoint, frame: str = "world", wanted: Iterable[str] = ()):
        self.point = point
        self.system = _core.System(point.mechanism.multibody)
        self.outputs = _core.Outputs(point.mechanism)
        self.coordinates = Coordinates(point.mechanism, self.system, frame)
        self.frame = frame
        self.size = sizes(point.mechanism, self.system)
        names = [c.name for c in self.coordinates.all]
        _, _, self._constraint, self._constraint_rate = self.system.constraints(point.q, point.v)
        chosen = choose(names, wanted, "coordinate", point.model)
        of_positions = np.delete(self._constraint, self.system.velocity_equations, axis=0)
        self.selection = select(self.coordinates, point.q, of_positions, self.size, chosen)
        self.moving = self.selection
        """The coordinates whose rates are states: all of them, unless something rolls."""
        if len(of_positions) < len(self._constraint):
            self.moving = select(self.coordinates, point.q, self._constraint, self.size, chosen, self.selection.indices)
        self.chosen = [self.coordinates.all[i] for i in self.selection.indices]
        self.rates = [self.coordinates.all[i] for i in self.moving.indices]
        if not self.chosen:
            raise SigmafmuError(f"{point.model} cannot move: it has no degree of freedom")
        self._time = difference_time(point.v, self.size)

    def model(self, inputs: Iterable[str] | None, outputs: Iterable[str] | None) -> LinearModel:
        """The linear model."""
        point, chosen = self.point, self.chosen
        columns = self._choose(self.outputs.inputs, inputs, "input")
        rows = self._choose(self.outputs.names, outputs, "output")
        rows = [i for i in rows if outputs is not None or not self.outputs.names[i].startswith(DIAGNOSTICS)]
        for i in rows:
            if self.outputs.names[i].startswith(DIAGNOSTICS):
                raise SigmafmuError(f"'{self.outputs.names[i]}' tells about the solver; it is no function of the state")
        drift = self._drift()
        by_position, by_rate = self.by_position(drift), self.by_rate()
        by_input = self.by_input(columns)
        accelerations, y = self.accelerations_and_outputs()
        rates = self.coordinates.rates(point.q, point.v)
        values = self.coordinates.values(point.q, point.turned)[self.selection.indices]
        input_names = tuple(self.outputs.inputs[i] for i in columns)
        output_names = tuple(self.outputs.names[i] for i in rows)
        return LinearModel(
            A=np.block(
                [
                    [self._convection(drift), self._coordinates_by_rate()],
                    [by_position.accelerations, by_rate.accelerations],
                ]
            ),
            B=np.vstack([np.zeros((len(chosen), len(columns))), by_input.accelerations]),
            C=np.hstack([by_position.outputs, by_rate.outputs])[rows],
            D=by_input.outputs[rows],
            x0=np.concatenate([values, rates[self.moving.indices]]),
            u0=point.u[columns],
            y0=y[rows],
            dx0=np.concatenate([rates[self.selection.indices], accelerations]),
            states=(*(c.name for c in chosen), *(c.rate for c in self.rates)),
            inputs=input_names,
            outputs=output_names,
            state_units=(*(c.unit for c in chosen), *(c.rate_unit for c in self.rates)),
            input_units=tuple(point.units.get(name, "") for name in input_names),
            output_units=tuple(point.units.get(name, "") for name in output_names),
            name=point.model,
            time=point.time,
            frame=self.frame,
            start_values=point.start_values(),
        )

    def rates_to_velocities(self, rates: np.ndarray) -> np.ndarray:
        """The velocities v that satisfy the constraints with these rates, of `self.rates`."""
        return self.moving.motions @ rates

    def motion_of_rates(self) -> np.ndarray:
        """Which of the chosen coordinates change with which of the rates: 1 where a coordinate has the rate."""
        return np.equal.outer(self.selection.indices, self.moving.indices).astype(float)

    def accelerations_and_outputs(self) -> tuple[np.ndarray, np.ndarray]:
        """η' and all outputs at the point."""
        return self._evaluate(self.point.q, self.point.v, self.point.u)

    def by_position(self, drift: np.ndarray | None = None) -> Derivatives:
        """With respect to ξ."""
        drift = self._drift() if drift is None else drift
        result = self._columns(
            [
                self._response(motion, velocity, RELATIVE_STEP / np.abs(motion / self.size).max())
                for motion, velocity in zip(self.selection.motions.T, drift.T, strict=True)
            ]
        )
        # outputs that jump, such as a rotation vector that is π long, have a derivative that does not
        jumping = self.outputs.jumping
        for k, motion in enumerate(self.selection.motions.T):
            result.outputs[jumping, k] = self.outputs.rates(self.point.q, motion)
        return result

    def by_rate(self) -> Derivatives:
        """With respect to η."""
        point = self.point
        still = np.zeros_like(point.v)
        speed = max(1.0, float(np.abs(point.v / self.size).max()))
        result = self._columns(
            [
                self._response(still, motion, RELATIVE_STEP * speed / np.abs(motion / self.size).max())
                for motion in self.moving.motions.T
            ]
        )
        result.outputs[self.outputs.jumping] = 0.0
        return result

    def by_input(self, columns: list[int]) -> Derivatives:
        """With respect to u. Everything is affine in u, with the same slope at rest, where there is less to cancel; but
        for powers, which are products with velocities."""
        q, still = self.point.q, np.zeros_like(self.point.v)
        powers = self.outputs.powers

        def response(unit: np.ndarray, v: np.ndarray) -> np.ndarray:
            return np.concatenate(self._evaluate(q, v, unit)) - np.concatenate(self._evaluate(q, v, -unit))

        units = np.eye(len(self.point.u))[columns]
        result = self._columns([response(unit, still) / 2 for unit in units])
        if powers:
            moving = self._columns([response(unit, self.point.v) / 2 for unit in units])
            result.outputs[powers] = moving.outputs[powers]
        result.outputs[self.outputs.jumping] = 0.0
        return result

    def _choose(self, names: list[str], wanted: Iterable[str] | None, kind: str) -> list[int]:
        return list(range(len(names))) if wanted is None else choose(names, wanted, kind, self.point.model)

    def _evaluate(self, q: np.ndarray, v: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """η' and all outputs."""
        try:
            vdot = self.system.accelerations(q, v, u)[0]
            y = self.outputs.values(q, v, u, self.point.turned)
        except RuntimeError as error:
            where = f"{self.point.model} at t = {self.point.time:g} s"
            raise SigmafmuError(f"cannot linearise {where}: {error}") from error
        return self.coordinates.accelerations(q, v, vdot, self._time)[self.moving.indices], y

    def _response(self, motion: np.ndarray, velocity: np.ndarray, step: float) -> np.ndarray:
        """d(η', y) along a motion and a change of velocity."""
        point = self.point

        def at(s: float) -> np.ndarray:
            q = self.system.compose(point.q, s * motion)
            return np.concatenate(self._evaluate(q, point.v + s * velocity, point.u))

        return derivative(at, step)

    def _columns(self, columns: list[np.ndarray]) -> Derivatives:
        freedom = len(self.rates)
        both = np.column_stack(columns) if columns else np.zeros((freedom + len(self.outputs.names), 0))
        return Derivatives(both[:freedom], both[freedom:])

    def _along(self, direction: np.ndarray, velocities: np.ndarray, step: float, indices: list[int]) -> np.ndarray:
        """d(L v) along a motion, for each column v of `velocities`, which are held; L of these coordinates."""

        def at(s: float) -> np.ndarray:
            q = self.system.compose(self.point.q, s * direction)
            return np.column_stack([self.coordinates.rates(q, v)[indices] for v in velocities.T])

        return derivative(at, step)

    def _rates_by_position(self) -> np.ndarray:
        """∂(L_v v)/∂q E."""
        v = self.point.v[:, None]
        return np.hstack(
            [
                self._along(motion, v, RELATIVE_STEP / np.abs(motion / self.size).max(), self.moving.indices)
                for motion in self.selection.motions.T
            ]
        )

    def _drift(self) -> np.ndarray:
        """D."""
        E, L = self.selection.motions, self.moving.gradient
        matrix = np.vstack([self._constraint, L]) * self.size
        right = np.vstack([-self._constraint_rate @ E, -self._rates_by_position()])
        return self.size[:, None] * np.linalg.lstsq(matrix, right, rcond=None)[0]

    def _convection(self, drift: np.ndarray) -> np.ndarray:
        """G."""
        E, L = self.selection.motions, self.selection.gradient
        v = self.point.v
        turned = np.zeros_like(E)  # v̂ E: zero for translations, ω × for rotations
        for i in range(3, len(v) - self.system.modal_count, 6):
            turned[i : i + 3] = np.cross(v[i : i + 3], E[i : i + 3], axisb=0, axisc=0)
        result = self._along(v, E, self._time, self.selection.indices) + L @ drift - L @ turned
        moving = np.isin(self.selection.indices, self.moving.indices)
        result[[i for i, c in enumerate(self.chosen) if c.integral and moving[i]]] = 0.0
        return result

    def _coordinates_by_rate(self) -> np.ndarray:
        """L E_v: a unit matrix where all rates are states."""
        own = self.motion_of_rates()
        others = own.sum(axis=1) == 0
        own[others] = (self.selection.gradient @ self.moving.motions)[others]
        return own
