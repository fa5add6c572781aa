"""Numbers with units: `"30 deg"`, `"4 kN/m"`. Pint knows the units; angles are a dimension of their own here.

Pint takes the radian for a plain number, so that `Hz` would pass for an angular rate, wrong by 2 pi. Here it does not.
"""

import math
import re
from collections.abc import Mapping
from functools import cache
from typing import Any

DIMENSIONS = {
    "number": "1",
    "length": "m",
    "angle": "rad",
    "time": "s",
    "mass": "kg",
    "inertia": "kg*m^2",
    "velocity": "m/s",
    "angular velocity": "rad/s",
    "acceleration": "m/s^2",
    "angular acceleration": "rad/s^2",
    "force": "N",
    "torque": "N*m",
    "stiffness": "N/m",
    "damping": "N*s/m",
    "torsional stiffness": "N*m/rad",
    "torsional damping": "N*m*s/rad",
    "rate": "1/s",
    "modulus": "Pa",
    "drag": "N*s^2/m^2",
    "rotational drag": "N*m*s^2",
    "slowness": "s/m",
    "torsional slowness": "s/rad",
}
"""What a number may be → its SI unit. Per radian may be left out: `N m` is a torsional stiffness too."""

UNITS = """
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
deci- = 1e-1 = d-
hecto- = 1e2 = h-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre
second = [time] = s = sec
kilogram = [mass] = kg
radian = [angle] = rad
gram = 1e-3 * kilogram = g
tonne = 1e3 * kilogram = t
degree = 3.14159265358979323846 / 180 * radian = deg = ° = degrees
revolution = 2 * 3.14159265358979323846 * radian = rev = turn = turns
minute = 60 * second = min
hour = 3600 * second = h
rpm = revolution / minute
newton = kilogram * meter / second ** 2 = N
joule = newton * meter = J
watt = joule / second = W
pascal = newton / meter ** 2 = Pa
bar = 1e5 * pascal
inch = 0.0254 * meter = in
foot = 0.3048 * meter = ft
pound = 0.45359237 * kilogram = lb
pound_force = 4.4482216152605 * newton = lbf
slug = 14.593902937206 * kilogram
"""
"""Of mechanics, as Pint's definitions."""

LONGEST = 60
"""Characters of a number with its unit."""

_TEXT = re.compile(r"\s*(?P<number>[-+]?(\.\d+|\d+(\.\d*)?)([eE][-+]?\d+)?)(?P<unit>[^\d].*)?")
_SYMBOLS = re.compile(r"[A-Za-zµμ°*·/^() -]*")
_EXPONENT = re.compile(r"(\^|\*\*)\s*-?[1-4](?!\d)")


class UnitError(ValueError):
    """A text that is no number with a unit of the right dimension; its message says what is wrong and allowed."""


def si_unit(dimension: str) -> str:
    """The SI unit of a dimension, as people write it; empty for plain numbers."""
    unit = DIMENSIONS[dimension]
    return "" if unit == "1" else unit.replace("*", " ").replace("^2", "²")


def example(dimension: str) -> str:
    """A text that has the dimension."""
    examples = {"angle": "30 deg", "angular velocity": "60 rpm", "stiffness": "4 kN/m", "length": "150 mm"}
    return examples.get(dimension, f"2 {DIMENSIONS[dimension].replace('*', ' ')}")


def to_si(text: str, dimension: str) -> float:
    """The number of a text like "30 deg" in SI units; raises UnitError.

    Nothing of the text is evaluated but names of units and small exponents.
    """
    match = _TEXT.fullmatch(text) if len(text) <= LONGEST else None
    if match is None:
        raise UnitError("is no number with a unit")
    unit = (match["unit"] or "").strip()
    if not unit:
        raise UnitError("has no unit; write the number without quotes if it is in SI units")
    factor, dimensions = _unit(unit)
    expected = _unit(DIMENSIONS[dimension])[1]
    per_radian = {name: power for name, power in expected.items() if (name, power) != ("[angle]", -1)}
    if dimensions not in (expected, per_radian):
        raise UnitError(f"is {_called(dimensions)}")
    return float(match["number"]) * factor


@cache
def _unit(text: str) -> tuple[float, Mapping[str, float]]:
    """Factor to SI and dimensions of a unit."""
    if text == "1":
        return 1.0, {}
    plain = _EXPONENT.sub("", text.removeprefix("1/"))
    if not _SYMBOLS.fullmatch(plain) or plain.count("*") != plain.replace("**", "").count("*"):
        raise UnitError(f'has the unit "{text}", which is none')
    try:
        quantity = _registry().Quantity(1.0, text.replace("·", "*").replace("^", "**")).to_root_units()
    except Exception as error:  # of many kinds, from Pint's tokenizer to its registry
        raise UnitError(f'has the unit "{text}", which is unknown; names are case-sensitive') from error
    factor = float(quantity.magnitude)
    if not (math.isfinite(factor) and factor > 0):
        raise UnitError(f'has the unit "{text}", which is out of range')
    return factor, {name: float(power) for name, power in quantity.dimensionality.items()}


def _called(dimensions: Mapping[str, float]) -> str:
    """What has these dimensions."""
    for name, unit in DIMENSIONS.items():
        if _unit(unit)[1] == dimensions:
            return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"
    return "of another dimension"


@cache
def _registry() -> Any:
    import pint  # takes a third of a second, and most files have SI numbers

    registry = pint.UnitRegistry(None)
    for line in UNITS.strip().splitlines():
        registry.define(line)
    return registry
