"""Numbers that docs/linearize.md tells; its examples are run by tests/docs/test_examples.py."""

import re
from pathlib import Path

import numpy as np

import sigmafmu

PAGE = (Path(__file__).parents[2] / "docs" / "linearize.md").read_text(encoding="utf-8")


def test_poles_of_the_upright_top_are_those_of_the_page():
    settings = {
        "top.initialPosition": [0, 0, 1],
        "top.initialQuaternion": [0.5**0.5, 0.5**0.5, 0, 0],
        "top.initialVelocity": [0, 0, 0],
        "top.initialAngularVelocity": [0, 300, 0],
    }
    for frame, told in (
        ("world", r"±(\d+\.\d+)i and\n?\s*±(\d+\.\d+)i in W"),
        ("body", r"±(\S+)i and ±(\S+)i in its own"),
    ):
        poles = sigmafmu.linearize("HeavyTop", parameters=settings, frame=frame).poles()
        found = np.unique(np.abs(poles.imag).round(9))[-2:]
        np.testing.assert_allclose(found, [float(x) for x in re.search(told, PAGE).groups()], rtol=1e-3)
