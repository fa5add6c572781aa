"""What steps cost: beside Exudyn, explicit codes in joint coordinates and limit kernels, in one run.

`python -m research bench` writes the page docs/speed.md with its tables, figures and CSV files. A section of it is a
module with `measure(Effort) -> rows`, which go into its CSV FILE, and `report(rows, folder) -> Markdown` of these.
"""

import platform
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from sigmafmu import __version__

PEERS = {"exudyn": "Exudyn", "mujoco": "MuJoCo", "pin": "Pinocchio", "scipy": "SciPy", "kvxopt": "KVXOPT"}
"""Distributions, and what they are called."""


@dataclass(frozen=True)
class Effort:
    """How much time a benchmark may take."""

    quick: bool
    rounds: int
    """Of all candidates in turn; each keeps its fastest."""
    tell: Callable[[str], None]
    """Called with what is measured next."""


def machine() -> str:
    """Processor and software that a result belongs to."""
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        cpu = names[0].split(":", 1)[1].strip() if names else cpu
    return f"{cpu}, {platform.system()}, sigmafmu {__version__}, {', '.join(_versions())}"


def _versions() -> list[str]:
    result = []
    for package, name in PEERS.items():
        try:
            result.append(f"{name} {version(package)}")
        except PackageNotFoundError:
            continue
    return result
