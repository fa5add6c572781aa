"""A model: one of the package's, a mechanism file or an FMU, and what can be done with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sigmafmu import SigmafmuError, fmu_path
from sigmafmu.fmu import Fmu, MessageHandler
from sigmafmu.instance import Instance
from sigmafmu.mechanism_file import MECHANISM_FILES
from sigmafmu.recorder import TakeRows
from sigmafmu.result import Result
from sigmafmu.signals import Signal
from sigmafmu.steps import communication_steps
from sigmafmu.variables import SettingValue, Variable

if TYPE_CHECKING:
    from sigmafmu.linear import Campbell, LinearModel, OperatingPoint

EVERYTHING = {"expose": {key: ["*"] for key in ("inputs", "outputs", "parameters")}}


def load(target: str | Path) -> Model:
    """A model by its name (see `sigmafmu.models()`), from a mechanism file (.yaml, .yml, .json) or from an FMU (.fmu).

    Raises SigmafmuError if there is none; for a mechanism file with mistakes, MechanismFileError with a line for each.
    """
    name = str(target)
    if name.endswith(MECHANISM_FILES):
        return Model(fmu_of_mechanism_file(Path(name)))
    return Model(Fmu.of_file(name) if name.endswith(".fmu") else Fmu(fmu_path(name)))


def fmu_of_mechanism_file(path: Path, *, seen: bool = False) -> Fmu:
    """A mechanism as an FMU without documentation, which is made in some hundredths of a second.

    One that is to be `seen` has all outputs, whatever the file exposes, and the meshes of its bodies.
    """
    from sigmafmu.mechanism_file.drawing import shapes_of
    from sigmafmu.mechanism_file.load import folder_of
    from sigmafmu.mechanism_file.load import load as read
    from sigmafmu.packing import fill_runnable

    file = read(path)
    definition = file.definition | (EVERYTHING if seen else {})

    def fill(_path: Path, tree: Path) -> None:
        with folder_of(file.resources) as resources:
            fill_runnable(definition, resources, tree, shapes_of(file, meshes=seen))

    return Fmu(path, fill)


class Model:
    """A model that can be run, stepped and linearised. `sigmafmu.load` makes them."""

    def __init__(self, fmu: Fmu):
        self.fmu = fmu
        """The FMU that runs it, unpacked."""

    def __repr__(self) -> str:
        return f"<Model {self.name}: {len(self.inputs)} inputs, {len(self.outputs)} outputs>"

    def __reduce__(self) -> tuple[Any, ...]:
        return load, (str(self.fmu.path.resolve()),)  # another process reads the same file

    @property
    def name(self) -> str:
        """Name of the mechanism."""
        return self.fmu.name

    @property
    def description(self) -> str:
        """A line about it."""
        return self.fmu.description.description or ""

    @cached_property
    def variables(self) -> Mapping[str, Variable]:
        """All scalar variables by name, with units and descriptions."""
        return {name: Variable.of(v) for name, v in self.fmu.variables.items()}

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the scalar parameters."""
        return self._names("parameter")

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the scalar inputs."""
        return self._names("input")

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the scalar outputs; counters of the integrator are not among them."""
        return self._names("output")

    def _names(self, causality: str) -> tuple[str, ...]:
        return tuple(name for name, v in self.fmu.variables.items() if v.causality == causality)

    @property
    def stop_time(self) -> float:
        """Where a run ends if it is not told otherwise [s]."""
        return communication_steps(self.fmu).end

    @property
    def step_size(self) -> float:
        """Communication step H of a run that is not told otherwise [s]."""
        return communication_steps(self.fmu).step_size

    def run(
        self,
        stop_time: float | None = None,
        *,
        step_size: float | None = None,
        parameters: Mapping[str, SettingValue] | None = None,
        inputs: Mapping[str, Signal] | None = None,
        outputs: Iterable[str] = (),
        keep_every: int = 1,
        on_rows: TakeRows | None = None,
        on_time: Callable[[float], None] | None = None,
        on_message: MessageHandler | None = None,
    ) -> Result:
        """Run from 0 to `stop_time` [s] in communication steps of `step_size` [s], and record outputs at each of them.

        Both times default to the model's own. `parameters` are values by name in SI units: numbers, sequences for
        vectors, names of enumerations' items; an input there is constant. `inputs` are constants, tables (times,
        values), or functions of time; between communication points they are straight lines. `outputs` are names,
        vectors or patterns with `*` and `?`, by default all outputs and counters.

        The result holds every `keep_every`-th row and the last; `on_rows(names, rows)` gets all of them, in pieces.
        `on_time(t)` is called after each step, `on_message` with what the model reports. Raises SigmafmuError for
        names, values and times that are wrong, and SimulationError if the model refuses, with the result so far.
        """
        with self.instance(parameters, on_message=on_message) as instance:
            return instance.run(
                stop_time,
                step_size=step_size,
                inputs=inputs,
                outputs=outputs,
                keep_every=keep_every,
                on_rows=on_rows,
                on_time=on_time,
            )

    def instance(
        self, parameters: Mapping[str, SettingValue] | None = None, *, on_message: MessageHandler | None = None
    ) -> Instance:
        """A live instance, for steps of your own; use it in a `with` statement. A model can have many at once."""
        return Instance(self.fmu, parameters, on_message)

    def linearize(
        self,
        at: float = 0.0,
        *,
        parameters: Mapping[str, SettingValue] | None = None,
        u0: Mapping[str, SettingValue] | None = None,
        inputs: Iterable[str] | None = None,
        outputs: Iterable[str] | None = None,
        coordinates: Iterable[str] = (),
        frame: str = "world",
    ) -> LinearModel:
        """Linear model about the point of the motion at time `at` [s]; see `sigmafmu.linearize`."""
        from sigmafmu.linear import linearize

        return linearize(
            self,
            at,
            parameters=parameters,
            u0=u0,
            inputs=inputs,
            outputs=outputs,
            coordinates=coordinates,
            frame=frame,
        )

    def trim(
        self,
        at: float = 0.0,
        *,
        parameters: Mapping[str, SettingValue] | None = None,
        u0: Mapping[str, SettingValue] | None = None,
        inputs: Iterable[str] = (),
        hold: Mapping[str, float] | None = None,
    ) -> OperatingPoint:
        """An equilibrium or a steady motion near the point at time `at` [s]; see `sigmafmu.trim`."""
        from sigmafmu.linear import trim

        return trim(self, at, parameters=parameters, u0=u0, inputs=inputs, hold=hold)

    def campbell(
        self,
        rate: str,
        speeds: Iterable[float],
        *,
        parameters: Mapping[str, SettingValue] | None = None,
        on_speed: Callable[[float], None] | None = None,
    ) -> Campbell:
        """Frequencies of a rotor over its speed, and critical speeds.

        `rate` is the rate of a coordinate that spins, such as `shaft.angularRate` or `rotor.angularVelocityW[1]`;
        `speeds` are its values [rad/s], two or more that increase. Raises SigmafmuError where there is no steady
        motion.
        """
        from sigmafmu.linear.campbell import campbell

        return campbell(self, rate, speeds, parameters=parameters, on_speed=on_speed)

    def mechanism(self) -> Any:
        """The mechanism in this process as a new `sigmafmu._core.Mechanism`; SigmafmuError if the FMU tells none.

        It is not part of the public interface.
        """
        from sigmafmu import _core

        resources = self.fmu.directory / "resources"
        file = resources / "mechanism.json"
        if not file.is_file():
            if self.name not in _core.mechanisms():
                raise SigmafmuError(f"{self.name} is not in this package's core, which linear models are made with")
            return _core.mechanism(self.name)
        mechanism = _core.from_json(file.read_text(encoding="utf-8"))
        _core.load_modal_files(mechanism, str(resources))
        mechanism.validate()
        return mechanism
