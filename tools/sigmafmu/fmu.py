"""An FMU opened through FMPy: unzipped, with its model description, ready to make instances."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import fmpy
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.model_description import ModelDescription, ModelVariable

from sigmafmu import SigmafmuError, fmu_path
from sigmafmu.platform import PLATFORM

STATUS_NAMES = ("info", "warning", "discard", "error", "fatal", "pending")


@dataclass(frozen=True)
class LogMessage:
    """One message from an FMU's logger."""

    status: str
    category: str
    text: str

    @property
    def is_complaint(self) -> bool:
        """Whether the FMU refused something, so that an error tells it anyway."""
        return self.status in {"discard", "error", "fatal"}

    def __str__(self) -> str:
        return f"{self.status}: {self.text}"


MessageHandler = Callable[[LogMessage], None]


def _extract(path: Path, folder: Path) -> None:
    fmpy.extract(path, folder, include=lambda name: not name.startswith("sources/"))  # many files


class Fmu:
    """An FMU in a directory that lives as long as this object; `fill` writes it there, by default by unzipping."""

    def __init__(self, path: Path | str, fill: Callable[[Path, Path], None] = _extract):
        self.path = Path(path)
        self._directory = tempfile.TemporaryDirectory(prefix=f"{self.path.stem}-")
        self.directory = Path(self._directory.name)
        fill(self.path, self.directory)
        self.description: ModelDescription = fmpy.read_model_description(self.directory)
        self.variables: dict[str, ModelVariable] = {v.name: v for v in self.description.modelVariables}

    @classmethod
    def of_model(cls, model: str) -> "Fmu":
        """Open the FMU of one of `sigmafmu.models()`."""
        return cls(fmu_path(model))

    @property
    def name(self) -> str:
        """Name of the model."""
        return self.description.modelName

    @classmethod
    def of_file(cls, path: Path | str) -> "Fmu":
        """Open an FMU file; raises SigmafmuError."""
        try:
            return cls(path)
        except (OSError, BadZipFile) as error:
            raise SigmafmuError(f"{path} is no FMU: {getattr(error, 'strerror', None) or error}") from error

    def references(self, names: list[str]) -> list[int]:
        """Value references of the variables `names`."""
        return [self.variables[name].valueReference for name in names]

    def instantiate(
        self, on_message: MessageHandler | None = None, *, instance_name: str | None = None, debug: bool = False
    ) -> FMU2Slave:
        """Make a slave in the state `instantiated`; the caller frees it with `freeInstance()`."""
        model = self.description.coSimulation.modelIdentifier
        slave = FMU2Slave(
            guid=self.description.guid,
            modelIdentifier=model,
            unzipDirectory=str(self.directory),
            instanceName=instance_name,
            libraryPath=str(self.directory / "binaries" / PLATFORM / f"{model}{fmpy.sharedLibraryExtension}"),
        )
        slave.instantiate(callbacks=_callbacks(on_message or (lambda _: None)), loggingOn=debug)
        return slave


def _callbacks(on_message: MessageHandler) -> fmi2CallbackFunctions:
    def logger(_environment: Any, _name: bytes, status: int, category: bytes, message: bytes) -> None:
        name = STATUS_NAMES[status] if 0 <= status < len(STATUS_NAMES) else f"status {status}"
        on_message(LogMessage(name, (category or b"").decode(), (message or b"").decode()))

    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(logger)
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
    return callbacks
