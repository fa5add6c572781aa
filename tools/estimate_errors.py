"""Writes models/errors/<Model>.csv: the errors of the reference and of the FMU at its default settings, per variable.

    .venv/bin/python tools/estimate_errors.py [MODEL ...]

Run it after the references, the integrator's defaults or a mechanism changed. The FMU's own error is estimated without
the reference: a method of second order that makes the error e with step h makes e/4 with h/2, so it is
e = 4/3 |x(h) - x(h/2)|. Figures are rounded up to two digits.
"""

import csv
import math
import sys
from pathlib import Path

import numpy as np

from research.reference import GROUPS, group_of
from sigmafmu.compare import read_reference
from sigmafmu.fmu import Fmu
from sigmafmu.model import Model

ROOT = Path(__file__).resolve().parents[1]
STEP = "integrator.stepSize"
NEGLIGIBLE = 1e-3
"""Own errors below this part of the reference's count as none: they are rounding, and differ between platforms."""

ROUNDING = 1e-16
"""Smaller own errors are stated as this: they are rounding, for example of a velocity that a joint keeps at zero."""


def own_errors(fmu: Fmu, variables: list[str], times: np.ndarray) -> dict[str, float]:
    """Largest error of each variable at the `times` (equally spaced), in its unit."""
    h = float(fmu.variables[STEP].start)
    coarse, fine = (
        Model(fmu).run(stop_time=times[-1], step_size=times[1], parameters={STEP: step}, outputs=variables)
        for step in (h, h / 2)
    )
    return {name: 4 / 3 * float(np.max(np.abs(coarse[name] - fine[name]))) for name in variables}


def stated_error(header: dict[str, str], variable: str) -> float:
    """What the reference states for this kind of variable, as `8.8e-10 m`."""
    return float(header[f"stated error, {group_of(variable)}"].split()[0])


def round_up(x: float) -> float:
    """Up to two significant digits."""
    if x == 0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(x)) - 1)
    return float(f"{math.ceil(x / unit * (1 - 1e-12)) * unit:.1e}")


def write(model: str) -> Path:
    """Writes the table of a model that has a reference."""
    header, history = read_reference(ROOT / "tests" / "references" / f"{model}.csv")
    variables = [name for name in history if name != "time" and ".quaternion[" not in name]
    errors = own_errors(Fmu.of_model(model), variables, history["time"])
    path = ROOT / "models" / "errors" / f"{model}.csv"
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["variable", "unit", "reference_error", "own_error"])
        for name in variables:
            stated, own = stated_error(header, name), round_up(max(errors[name], ROUNDING))
            table.writerow([name, GROUPS[group_of(name)], stated, own if own > NEGLIGIBLE * stated else 0.0])
    return path


if __name__ == "__main__":
    known = sorted(path.stem for path in (ROOT / "tests" / "references").glob("*.csv"))
    known.remove("SpinUpBeam")  # needs a torque; the FMU alone stays at rest
    for chosen in sys.argv[1:] or known:
        sys.stdout.write(f"wrote {write(chosen).relative_to(ROOT)}\n")
