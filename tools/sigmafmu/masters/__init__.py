"""Other people's FMI tools, each behind the same few functions: masters that simulate an FMU, validators that check it.

One file per tool. A tool that is not installed says so in `missing()`; one that fails raises ToolError.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu
from sigmafmu.variables import outputs


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

    def recorded(self, fmi_type: str) -> list[str]:
        """Names of the variables of this FMI type that a master records: the outputs, and the counters."""
        return [v.name for v in outputs(self.fmu) if v.type == fmi_type]


Trajectory = dict[str, np.ndarray]
"""Values of every recorded variable at the communication points H, 2 H, …"""


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
    records = ("Real", "Integer")
    """FMI types that it can read."""

    @abstractmethod
    def simulate(self, run: Run) -> Trajectory:
        """Values of every recorded variable of the types `records` after each communication step."""


def comparable(reference: Trajectory, run: Run, master: Master) -> Trajectory:
    """The part of `reference` that `master` can read."""
    return {name: reference[name] for fmi_type in master.records for name in run.recorded(fmi_type)}


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
    from sigmafmu.masters.fmi_sim import FmiSim
    from sigmafmu.masters.fmpy import FmpyMaster, FmpyValidator
    from sigmafmu.masters.fmu_manipulation_toolbox import FmuManipulationToolbox
    from sigmafmu.masters.gemseo import Gemseo
    from sigmafmu.masters.libcosim import Libcosim
    from sigmafmu.masters.maestro import Maestro
    from sigmafmu.masters.vdmcheck import VdmCheck

    validators = [FmpyValidator(), FmuManipulationToolbox(), VdmCheck()]
    return [*validators, FmpyMaster(), Libcosim(), Ecos(), Maestro(), FmiSim(), Gemseo()]
