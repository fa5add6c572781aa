"""What `sigmafmu run --plot` draws."""

from pathlib import Path

import numpy as np
import pytest
from mpl_toolkits.mplot3d import Axes3D

import sigmafmu
from sigmafmu import plots
from sigmafmu.loop import studies
from sigmafmu.model import Model
from sigmafmu.result import Result, Statistics

LIBRARY = Path(__file__).parents[2] / "models" / "library"
SPATIAL = {"HeavyTop", "SliderCrank", "FlexiblePendulum", "FlexibleSliderCrank"}
MOVED = {"SpinUpBeam": {"hubPivot.motorTorque": 5.0}}


def panels(figure):
    return [axes for axes in figure.axes if axes.lines or isinstance(axes, Axes3D)]


def test_six_panels_at_most_and_a_path_in_space(fmu, model):
    result = Model(fmu(model)).run(stop_time=0.2, step_size=0.002, parameters=MOVED.get(model))
    figure = plots.figure(result)
    assert 3 <= len(panels(figure)) <= plots.MAX_PANELS
    assert any(isinstance(axes, Axes3D) for axes in figure.axes) == (model in SPATIAL)
    for axes in panels(figure):
        assert axes.get_title(loc="left") or axes.get_title(), "every panel says what it shows"


@pytest.mark.parametrize(
    ("name", "reactions"),
    [
        ("AndrewsSqueezer", "Reaction force (6 of "),
        ("DoubleWishbone", "Reaction force"),
        ("StewartPlatform", "Reaction force (6 of "),
    ],
)
def test_a_file_has_an_overview(name, reactions):
    """Forces along lines and in space, numbered coordinates, more of each than a panel shows."""
    figure = plots.figure(sigmafmu.load(LIBRARY / f"{name}.yaml").run(0.002, step_size=0.001))
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert [titles[0].split()[0], titles[1].split(" (")[0]] == ["Paths", "Joint angle"]
    assert any(title.startswith(reactions) for title in titles)
    assert len(panels(figure)) == plots.MAX_PANELS
    assert all(len(axes.lines) <= 2 * plots.MAX_CURVES for axes in figure.axes)


def test_motion_in_a_plane_is_drawn_in_it(fmu):
    figure = plots.figure(Model(fmu("SpinUpBeam")).run(stop_time=5.0, step_size=0.05, parameters=MOVED["SpinUpBeam"]))
    assert figure.axes[0].get_xlabel() == "x in m"
    assert figure.axes[0].get_ylabel() == "y in m"


def test_named_variables_are_drawn_and_nothing_else(fmu):
    names = ["crankPivot.angle", "guide.rate"]
    result = Model(fmu("SliderCrank")).run(stop_time=0.02, step_size=0.001, outputs=names)
    figure = plots.figure(result, named=True)
    assert len(panels(figure)) == 2
    for axes, name in zip(figure.axes, names, strict=True):
        np.testing.assert_array_equal(axes.lines[0].get_ydata(), result[name])


def test_many_named_quantities_are_told_to_be_left_out():
    names = tuple(f"q{i}" for i in range(9))
    time = np.linspace(0, 1, 5)
    units = {name: f"u{i}" for i, name in enumerate(names)}
    result = Result("Machine", time, names, np.outer(time, np.ones(9)), Statistics(1.0, 0.0, 4), units)
    figure = plots.figure(result, named=True)
    assert len(panels(figure)) == plots.MAX_PANELS
    assert "without 3 of the quantities" in figure.get_suptitle()


@pytest.mark.parametrize("sizes", [[2e-3], [4e-3, 2e-3]])
def test_the_example_of_couple_draws_lines(sizes):
    """With one H there is no order to show, but there are errors over time."""
    runs = studies.spring_runs([1e5], sizes)
    for axes in studies.spring_figure(runs).axes:
        assert len(axes.lines) >= 2
        assert all(len(line.get_xdata()) > 1 for line in axes.lines)
        assert all(np.isfinite(np.asarray(line.get_ydata(), dtype=float)).any() for line in axes.lines)
