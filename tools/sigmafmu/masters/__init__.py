"""Other people's FMI tools, each behind the same few functions: masters that simulate an FMU, validators that check it.

One file per tool. A tool that is not installed says so in `missing()`; one that fails raises ToolError.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu


class ToolError(SigmafmuError):
    """A tool refused an FMU, crashed or could not be fetched."""


@dataclass(frozen=True)
class Run:
    """What a master shall do: `steps` communication steps of H seconds from t = 0, with `parameters` set before."""

    fmu: Fmu
    H: float
    steps: int
    parameters: Mapping[str, float] = field(default_factory=dict)

    @property
    def stop_time(self) -> float:
        """The last communication point."""
        return self.steps * self.H

    def outputs(self, fmi_type: str) -> list[str]:
        """Names of the outputs of this FMI type."""
        variables = self.fmu.description.modelVariables
        return [v.name for v in variables if v.causality == "output" and v.type == fmi_type]


Trajectory = dict[str, np.ndarray]
"""Values of every output at the communication points H, 2 H, …"""


class Tool(ABC):
    """A program or library that reads FMUs."""

    name: str
    source: str
    """Where it comes from."""
    command: str
    """What is run, for a reader who wants to repeat it."""
    heavy = False
    """Takes many seconds (Java)."""

    @abstractmethod
    def missing(self) -> str | None:
        """Why it cannot be used here, or None."""

    @abstractmethod
    def version(self) -> str:
        """Its version."""

    def download(self) -> str | None:
        """What `fetch` would download and whereto, or None."""
        return None

    def fetch(self) -> None:  # noqa: B027, most tools have nothing to fetch
        """Download what `download` says; `missing` tells whether that succeeded."""


class Validator(Tool):
    """Checks an FMU without simulating it."""

    @abstractmethod
    def validate(self, fmu: Fmu) -> list[str]:
        """What it finds wrong, a line each."""


class Master(Tool):
    """Simulates an FMU."""

    note = ""
    """What a user has to do for this master, if anything."""

    @abstractmethod
    def simulate(self, run: Run) -> Trajectory:
        """Values of every Real and Integer output after each communication step."""


def largest_difference(a: Trajectory, b: Trajectory) -> float:
    """Largest |a - b| of any output, relative to the largest value that this output has; 0 means the same bits."""
    if a.keys() != b.keys():
        raise ToolError(f"only one of the masters has {', '.join(sorted(a.keys() ^ b.keys()))}")
    differences = [0.0]
    for name in a:
        ours, theirs = np.asarray(a[name], dtype=float), np.asarray(b[name], dtype=float)
        if ours.shape != theirs.shape:
            raise ToolError(f"{len(ours)} instead of {len(theirs)} communication points")
        if ours.tobytes() != theirs.tobytes():
            tiny = np.finfo(float).tiny
            differences.append(max(np.max(np.abs(ours - theirs)), tiny) / max(np.max(np.abs(theirs)), tiny))
    return float(np.max(differences))  # not max(): a NaN must show


def tools() -> list[Tool]:
    """Every tool, FMPy first: its results are those that the others are compared with."""
    from sigmafmu.masters.ecos import Ecos
    from sigmafmu.masters.fmpy import FmpyMaster, FmpyValidator
    from sigmafmu.masters.fmu_manipulation_toolbox import FmuManipulationToolbox
    from sigmafmu.masters.libcosim import Libcosim
    from sigmafmu.masters.maestro import Maestro
    from sigmafmu.masters.vdmcheck import VdmCheck

    return [FmpyValidator(), FmuManipulationToolbox(), VdmCheck(), FmpyMaster(), Libcosim(), Ecos(), Maestro()]
