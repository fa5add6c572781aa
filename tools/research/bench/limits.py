"""Limit kernels: programs outside of this project that do one step of one mechanism as fast as anybody knows how.

The environment variable SIGMAFMU_LIMITS names the folder with them: top_base, sc_base, rotor_base and chain_base. Each
prints lines with a name of what was run and `min` nanoseconds or microseconds per step; those that are read are in
`KERNELS`. What is missing is left out of the tables.
"""

import os
import re
import subprocess
from functools import cache
from pathlib import Path

from sigmafmu import SigmafmuError

VARIABLE = "SIGMAFMU_LIMITS"
KERNELS = {  # mechanism: program, line that is read; index 3 with full Newton, general blocks
    "HeavyTop": ("top_base", r"dense hand9 LU tol +h=1e-04 rho=0.65 warm=0 J=0 *: min +([\d.]+)"),
    "SliderCrank": ("sc_base", r"block-tri tol +h=1e-03 warm=0 J=0: min +([\d.]+)"),
    "HighSpeedRotor": ("rotor_base", r"DROP=0 rotor full +tol +h=1.0e-05 min ([\d.]+)"),
}
CHAIN = r"N= *(\d+) block6 LU +min +([\d.]+) med +[\d.]+ us/step +it +[\d.]+ +min +([\d.]+) ns/body/it"


def seconds_per_step(mechanism: str) -> float | None:
    """Of the kernel for a mechanism; None: there is none. SigmafmuError: it prints something else."""
    if mechanism not in KERNELS:
        return None
    program, line = KERNELS[mechanism]
    text = _output(program)
    if text is None:
        return None
    found = re.search(line, text)
    if not found:
        raise SigmafmuError(f"{program} does not print the line {line!r}")
    return 1e-9 * float(found[1])


def chains() -> dict[int, tuple[float, float]]:
    """Seconds per step, and per body and iteration, of spherical chains by their number of links."""
    text = _output("chain_base") or ""
    return {int(n): (1e-6 * float(step), 1e-9 * float(body)) for n, step, body in re.findall(CHAIN, text)}


@cache
def _output(program: str) -> str | None:
    folder = os.environ.get(VARIABLE)
    if not folder:
        return None
    path = Path(folder) / program
    if not path.exists():
        raise SigmafmuError(f"{VARIABLE} is {folder}; there is no program {program} in it")
    budget = {**os.environ, "BUDGET": "0.2"}  # seconds for each line
    return subprocess.run([path], capture_output=True, text=True, check=True, env=budget).stdout
