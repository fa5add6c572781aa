"""Linear models in words and tables, for 80 columns."""

import numpy as np
from rich import box
from rich.table import Table

from sigmafmu.linear.model import LinearModel
from sigmafmu.linear.point import OperatingPoint

NEGLIGIBLE = 1e-6
"""Poles below this part of √‖A‖ (at least 1 rad/s) are shown as zero: rounding splits a double one by about that."""

ROUNDING = 1e-9
"""Real parts below this part of a pole are shown as zero."""


def headline(model: LinearModel) -> str:
    """What was linearised, and how large the model is."""
    sizes = [(len(model.states), "state"), (len(model.inputs), "input"), (len(model.outputs), "output")]
    return f"{model.title}: " + ", ".join(f"{count} {what}{'' if count == 1 else 's'}" for count, what in sizes)


def states(model: LinearModel) -> Table:
    """The operating point and its derivative."""
    table = Table("state", box=box.SIMPLE_HEAD)
    table.add_column("value", justify="right")
    table.add_column("derivative", justify="right")
    table.add_column("unit of value")
    for name, value, rate, unit in zip(model.states, model.x0, model.dx0, model.state_units, strict=True):
        table.add_row(name, f"{value + 0.0:.6g}", f"{rate + 0.0:.6g}", unit)
    return table


def inputs(point: OperatingPoint) -> str:
    """Inputs that are not zero; empty if all are."""
    values = [f"{name} = {value:.6g}" for name, value in point.inputs.items() if value]
    return ("inputs: " + ", ".join(values)) if values else ""


def warnings(model: LinearModel) -> list[str]:
    """What to keep in mind about this point."""
    result = []
    if not model.is_steady:
        result.append(
            f"no equilibrium: rates change with up to {model.residual:.3g} (SI units) at this point. The model tells "
            "how neighbours deviate from this motion, at this moment; its poles depend on the choice of states."
        )
    elif not model.is_equilibrium:
        result.append("no state of rest: the model tells how neighbours deviate from this steady motion.")
    spinning = [
        name for name, rate in zip(model.states, model.dx0, strict=True) if ".rotation" in name and abs(rate) > 1e-9
    ]
    if spinning:
        axes, other = ("W", "body") if model.frame == "world" else ("the body", "world")
        result.append(
            f"{spinning[0].split('.rotation')[0]} turns: its rotation is measured in axes of {axes}, and the poles "
            f"depend on that; compare with --frame {other}."
        )
    return result


def poles(model: LinearModel) -> Table:
    """Poles with frequency and damping ratio; of a complex pair only the upper one."""
    table = Table(box=box.SIMPLE_HEAD)
    discrete = model.sample_time > 0
    for title in ("pole" if discrete else "pole in 1/s", "frequency in Hz", "damping ratio"):
        table.add_column(title, justify="right")
    zero = NEGLIGIBLE * max(1.0, float(np.abs(model.A).max()) ** 0.5)
    for pole in model.poles():
        if pole.imag < 0:
            continue
        rate = np.log(pole) / model.sample_time if discrete else pole
        if (size := abs(rate)) < zero:
            table.add_row("1" if discrete else "0", "0", "")
            continue
        ratio = 0.0 if abs(rate.real) < ROUNDING * size else -rate.real / size
        real = 0.0 if abs(pole.real) < ROUNDING * abs(pole) else pole.real
        text = f"{real:.5g}" + (f" ± {pole.imag:.5g}i" if pole.imag > 0 else "")
        table.add_row(text, f"{size / (2 * np.pi):.4g}", f"{ratio:.3g}")
    return table
