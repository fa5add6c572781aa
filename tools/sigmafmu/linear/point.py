"""The point that a mechanism is linearised about."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from sigmafmu import SigmafmuError, _core
from sigmafmu.model import Model, load
from sigmafmu.variables import SettingValue, Value, parse_settings

STEPS_PER_REPORT = 1000


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """Positions and velocities that satisfy the constraints, and inputs."""

    mechanism: "_core.Mechanism"
    q: np.ndarray
    v: np.ndarray
    u: np.ndarray
    turned: np.ndarray  # coordinates of joints: angles with their turns [rad], displacements [m]
    time: float = 0.0  # s
    units: Mapping[str, str] = field(default_factory=dict)  # of the FMU's variables
    parameters: Mapping[str, Value] = field(default_factory=dict)  # those that were set

    @property
    def model(self) -> str:
        """Name of the mechanism."""
        return self.mechanism.name

    @property
    def inputs(self) -> dict[str, float]:
        """Inputs by name."""
        return dict(zip(_core.Outputs(self.mechanism).inputs, map(float, self.u), strict=True))

    def start_values(self) -> dict[str, Value]:
        """Settings, initial values and inputs that start the FMU here, for `run`, FMPy or any other master."""
        system = _core.System(self.mechanism.multibody)
        values: dict[str, Value] = dict(self.parameters)

        def add(name: str, numbers: np.ndarray) -> None:
            values.update({f"{name}[{i + 1}]": float(x) for i, x in enumerate(numbers)})

        modal_q, modal_v = (x[len(x) - system.modal_count :] for x in (self.q, self.v))
        for i, body in enumerate(self.mechanism.multibody.bodies):
            add(f"{body.name}.initialPosition", self.q[7 * i : 7 * i + 3])
            add(f"{body.name}.initialQuaternion", self.q[7 * i + 3 : 7 * i + 7])
            add(f"{body.name}.initialVelocity", self.v[6 * i : 6 * i + 3])
            add(f"{body.name}.initialAngularVelocity", self.v[6 * i + 3 : 6 * i + 6])
            if (first := system.modal_index(i)) >= 0:
                modes = slice(first, first + system.modes(i))
                add(f"{body.name}.initialModal", modal_q[modes])
                add(f"{body.name}.initialModalRate", modal_v[modes])
        return values | self._initial_coordinates(system) | self.inputs

    def _initial_coordinates(self, system: "_core.System") -> dict[str, float]:
        """Those of joints, as far as the FMU has them: a body's zero counts as not set, and would give way."""
        _, joints = system.kinds_of_coordinates()
        values = {}
        for words, numbers in (
            (("initialAngle", "initialDisplacement"), self.turned),
            (("initialAngularRate", "initialRate"), system.coordinates(self.q, self.v)[1]),
        ):
            for i, (j, number) in enumerate(zip(joints, numbers, strict=True)):
                joint = self.mechanism.multibody.joints[j]
                name = f"{joint.name}.{joint.word(i - list(joints).index(j), *words)}"
                if name in self.units:
                    values[name] = float(number)
        return values


def operating_point(
    model: Model | str | Path,
    at: float = 0.0,
    *,
    parameters: Mapping[str, SettingValue] | None = None,
    u0: Mapping[str, SettingValue] | None = None,
    on_time: Callable[[float], None] | None = None,
) -> OperatingPoint:
    """The point that `model` reaches at time `at` [s] with constant inputs; `parameters` as in `Model.run`."""
    if not (math.isfinite(at) and at >= 0):
        raise SigmafmuError(f"the time must be a finite number of seconds, at least 0, not {at:g}")
    model = model if isinstance(model, Model) else load(model)
    name = model.name
    assignments = parse_settings(model.fmu, parameters or {})
    for variable, value in parse_settings(model.fmu, u0 or {}):
        if variable.causality != "input":
            raise SigmafmuError(f"'{variable.name}' is no input of {name}; it belongs to the parameters")
        assignments.append((variable, value))
    try:
        mechanism = model.mechanism()
        inputs = dict.fromkeys(_core.Outputs(mechanism).inputs, 0.0)
        for variable, value in assignments:
            if variable.causality != "input":
                mechanism.set(variable.name, value)
            elif math.isfinite(value):
                inputs[variable.name] = value
            else:
                raise SigmafmuError(f"'{variable.name}' must be finite, not {value}")
        u = np.array(list(inputs.values()), dtype=float)
        simulation = _core.Simulation(mechanism)
        simulation.set_input(u, np.zeros_like(u), 0.0)
        simulation.start()
    except (ValueError, RuntimeError) as error:
        raise SigmafmuError(f"{name} cannot start: {error}") from error
    try:
        _run(simulation, at, mechanism.integrator.step_size, on_time or (lambda _: None))
    except RuntimeError as error:
        raise SigmafmuError(f"{name} does not get to t = {at:g} s: {error}") from error
    state = simulation.state
    units = {variable.name: variable.unit or "" for variable in model.fmu.variables.values()}
    chosen = {v.name: value for v, value in assignments if v.causality == "parameter" and not _starts(v.name)}
    return OperatingPoint(mechanism, state.q.copy(), state.v.copy(), u, state.turned.copy(), at, units, chosen)


def _starts(name: str) -> bool:
    """Whether a parameter is an initial value, which a point replaces by its own."""
    return name.rpartition(".")[2].startswith("initial")


def _run(simulation: "_core.Simulation", end: float, step: float, on_time: Callable[[float], None]) -> None:
    """Equal internal steps, as an FMU takes them in one communication step."""
    total = math.ceil(end / step * (1 - 1e-9))
    done = 0
    while done < total:
        count = min(STEPS_PER_REPORT, total - done)
        done += count
        now = end * done / total
        simulation.run(now, count)
        on_time(now)
