"""Every command and every piece of Python in docs/linearize.md runs, in the order of the page."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import sigmafmu
from sigmafmu.cli import app

PAGE = (Path(__file__).parents[2] / "docs" / "linearize.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_block_runs(number, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    language, text = BLOCKS[number]
    if language == "python":
        exec(compile(text, f"block {number} of docs/linearize.md", "exec"), {})
        return
    for line in text.splitlines():
        result = CliRunner().invoke(app, shlex.split(line)[1:], catch_exceptions=False)
        assert result.exit_code == 0, result.output


def test_the_page_has_commands_and_python():
    assert {language for language, _ in BLOCKS} == {"", "python"}


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
