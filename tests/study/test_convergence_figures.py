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

from research.cli import app
from research.study import convergence, flexible_accuracy, lgt_accuracy
from research.study.cases import CASES
from sigmafmu.plots import STYLE

COMMITTED = Path(__file__).resolve().parents[2] / "docs" / "study"


@pytest.fixture
def figures(monkeypatch):
    """Figures that the chapters draw, in place of their files."""
    drawn = []

    @contextmanager
    def keep(_path, size):
        with mpl.rc_context(STYLE):
            drawn.append(Figure(figsize=size))
            FigureCanvasAgg(drawn[-1])
            yield drawn[-1]

    for chapter in (convergence, lgt_accuracy, flexible_accuracy):
        monkeypatch.setattr(chapter, "figure", keep)
    return drawn


@pytest.fixture(params=CASES)
def drawn(request, tmp_path, figures):
    """Mechanism, its curves and the figure of the committed results."""
    curves = convergence.read_curves(COMMITTED / f"convergence_{request.param}.csv", request.param)
    convergence._draw(tmp_path / "never.png", CASES[request.param], curves)
    return request.param, curves, figures[0]


@pytest.mark.parametrize("chapter", [convergence, lgt_accuracy, flexible_accuracy])
def test_at_most_six_curves_and_a_slope(chapter, figures):
    chapter.CHAPTER.redraw(COMMITTED)
    assert len(figures) == len(list(COMMITTED.glob(f"{chapter.CHAPTER.name}_*.csv")))
    slopes = 0
    for axes in [axes for figure in figures for axes in figure.axes]:
        curves = [line for line in axes.lines if line.get_linestyle() != "None"]
        assert 2 <= len(curves) <= 6
        triangles = [patch for patch in axes.patches if isinstance(patch, Polygon)]
        for triangle, label in zip(triangles, axes.texts, strict=True):
            x, y = np.log(triangle.get_xy()[:3]).T
            assert np.ptp(y) / np.ptp(x) == pytest.approx(int(label.get_text())), "the triangle has the slope it names"
            slopes += 1
    assert slopes >= sum(len(figure.axes) for figure in figures) // 2


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
