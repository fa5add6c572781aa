"""The figures of the convergence chapter: few curves, slopes to compare with, and drawn anew without a run."""

import shutil
from contextlib import contextmanager
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from typer.testing import CliRunner

from sigmafmu.cli import app
from sigmafmu.plots import STYLE
from sigmafmu.study import convergence
from sigmafmu.study.cases import CASES

COMMITTED = Path(__file__).resolve().parents[2] / "docs" / "study"


@pytest.fixture(params=CASES)
def drawn(request, tmp_path, monkeypatch):
    """Mechanism, its curves and the figure of the committed results."""
    figures = []

    @contextmanager
    def keep(_path, size):
        with mpl.rc_context(STYLE):
            figures.append(Figure(figsize=size))
            FigureCanvasAgg(figures[-1])
            yield figures[-1]

    monkeypatch.setattr(convergence, "figure", keep)
    curves = convergence.read_curves(COMMITTED / f"convergence_{request.param}.csv", request.param)
    convergence._draw(tmp_path / "never.png", CASES[request.param], curves)
    return request.param, curves, figures[0]


def test_at_most_six_curves_and_a_slope(drawn):
    mechanism, _, figure = drawn
    for axes in figure.axes:
        curves = [line for line in axes.lines if line.get_linestyle() != "None"]
        assert 3 <= len(curves) <= 6, mechanism
        triangles = [patch for patch in axes.patches if isinstance(patch, Polygon)]
        assert triangles
        for triangle, label in zip(triangles, axes.texts, strict=True):
            x, y = np.log(triangle.get_xy()[:3]).T
            assert np.ptp(y) / np.ptp(x) == pytest.approx(int(label.get_text())), "the triangle has the slope it names"


def test_third_order_of_the_rotor_has_its_triangle(drawn):
    mechanism, _, figure = drawn
    shown = {text.get_text() for text in figure.axes[0].texts}
    assert shown == ({"2", "3"} if mechanism == "HighSpeedRotor" else {"2"})


def test_curves_are_those_of_the_file(drawn):
    mechanism, curves, figure = drawn
    error = CASES[mechanism].errors[0]
    (one,) = [c for c in curves if (c.corrector, c.label, c.formulation) == ("residual", "1", convergence.runs.INDEX3)]
    drawn_values = [line.get_ydata() for line in figure.axes[0].lines]
    assert any(np.array_equal(values, one.values(error), equal_nan=True) for values in drawn_values)


def test_redraw_runs_nothing(tmp_path):
    shutil.copy(COMMITTED / "convergence_HeavyTop.csv", tmp_path)
    options = ["study", "all", "--chapter", "convergence", "--redraw", "--output", str(tmp_path)]
    result = CliRunner().invoke(app, options, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in tmp_path.iterdir()) == ["convergence_HeavyTop.csv", "convergence_HeavyTop.png"]
