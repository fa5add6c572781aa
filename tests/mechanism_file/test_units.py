"""Numbers with units, against what the units are by definition."""

import math

import pytest

from sigmafmu.mechanism_file.units import DIMENSIONS, UnitError, example, to_si

DEGREE = math.pi / 180


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("30 deg", "angle", 30 * DEGREE),
        ("30°", "angle", 30 * DEGREE),
        ("-1.5 rad", "angle", -1.5),
        ("2 turns", "angle", 4 * math.pi),
        ("200000 rpm", "angular velocity", 200000 * 2 * math.pi / 60),
        ("90 deg/s", "angular velocity", math.pi / 2),
        ("180 deg/s^2", "angular acceleration", math.pi),
        ("150 mm", "length", 0.15),
        ("1e3 µm", "length", 1e-3),
        ("2 in", "length", 0.0508),
        ("800 g", "mass", 0.8),
        ("1 lb", "mass", 0.45359237),
        ("5 g cm^2", "inertia", 5e-7),
        ("5 g*cm**2", "inertia", 5e-7),
        ("4 kN/m", "stiffness", 4000.0),
        ("4 N/mm", "stiffness", 4000.0),
        ("7 N s/mm", "damping", 7000.0),
        ("3 N m/deg", "torsional stiffness", 3 / DEGREE),
        ("3 N m", "torsional stiffness", 3.0),
        ("3 N·m·s/rad", "torsional damping", 3.0),
        ("2 kN m", "torque", 2000.0),
        ("36 km/h", "velocity", 10.0),
        ("10 ms", "time", 0.01),
        ("5 1/s", "rate", 5.0),
    ],
)
def test_units(text, dimension, value):
    assert to_si(text, dimension) == pytest.approx(value, rel=4e-16)


@pytest.mark.parametrize("dimension", [d for d in DIMENSIONS if d != "number"])
def test_examples_in_messages_are_right(dimension):
    assert math.isfinite(to_si(example(dimension), dimension))


@pytest.mark.parametrize(
    ("text", "dimension", "what"),
    [
        ("5 mm", "mass", "is a length"),
        ("50 Hz", "angular velocity", "which is unknown"),
        ("50 1/s", "angular velocity", "is a rate"),
        ("3 N m/rad", "torque", "is a torsional stiffness"),
        ("3 N m", "force", "is a torque"),
        ("3 m^3", "length", "of another dimension"),
        ("3 Deg", "angle", "which is unknown"),
        ("3", "length", "has no unit"),
        ("long", "length", "is no number"),
        ("", "length", "is no number"),
        ("1 m; import os", "length", "which is none"),
        ("9**9**9**9 m", "length", "which is none"),
        ("1 m**99999999", "length", "which is none"),
        ("1 " + "(" * 300, "length", "is no number"),
        ("1 ((((m", "length", "which is unknown"),
        ("1 m m^-4 m^4 __import__", "length", "which is none"),
        ("1 m - m", "length", "which is unknown"),
    ],
)
def test_what_is_no_unit_of_the_dimension(text, dimension, what):
    with pytest.raises(UnitError, match=what.replace("(", r"\(")):
        to_si(text, dimension)
