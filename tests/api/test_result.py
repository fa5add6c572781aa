"""What a result gives to others: pandas, xarray, files, figures."""

import csv
import json
import sys

import numpy as np
import pytest
from matplotlib.figure import Figure

import sigmafmu
from sigmafmu import NotRecordedError, SigmafmuError

NAMES = ["guide.displacement", "slider.position", "integrator.steps"]


@pytest.fixture(scope="module")
def result():
    return sigmafmu.load("SliderCrank").run(0.02, outputs=NAMES)


def test_fewer_variables(result):
    fewer = result.only(["slider.position[2]", "guide.*"])
    assert fewer.names == ("slider.position[2]", "guide.displacement")
    np.testing.assert_array_equal(fewer["guide.displacement"], result["guide.displacement"])
    assert fewer.units == {"slider.position[2]": "m", "guide.displacement": "m"}
    for take in (result.only, lambda name: result[name]):
        with pytest.raises(NotRecordedError, match=r"crank\.position"):
            take("crank.position")


def test_csv_has_every_bit(result, tmp_path):
    result.to_csv(tmp_path / "x.csv")
    with (tmp_path / "x.csv").open(encoding="utf-8") as file:
        assert next(csv.reader(file)) == ["time", *result.names]
    table = np.loadtxt(tmp_path / "x.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(table, np.column_stack((result.time, result.values)))


def test_pandas(result):
    frame = result.to_pandas()
    assert frame.index.name == "time"
    np.testing.assert_array_equal(frame["slider.position[1]"], result["slider.position"][:, 0])
    assert frame.attrs["units"]["guide.displacement"] == "m"


def test_xarray(result):
    data = result.to_xarray()
    assert data["slider.position"].dims == ("time", "slider.position_")
    assert data["slider.position"].attrs == {"units": "m"}
    np.testing.assert_array_equal(data["slider.position"].sel({"slider.position_": 2}), result["slider.position[2]"])
    np.testing.assert_array_equal(data.time, result.time)


def test_parquet(result, tmp_path):
    fastparquet = pytest.importorskip("fastparquet")
    result.to_parquet(tmp_path / "x.parquet")
    file = fastparquet.ParquetFile(str(tmp_path / "x.parquet"))
    np.testing.assert_array_equal(
        file.to_pandas()[["time", *result.names]], np.column_stack((result.time, result.values))
    )
    assert json.loads(file.key_value_metadata["units"])["guide.displacement"] == "m"


@pytest.mark.parametrize(
    ("package", "use"),
    [
        ("pandas", lambda r, _: r.to_pandas()),
        ("xarray", lambda r, _: r.to_xarray()),
        ("fastparquet", lambda r, path: r.to_parquet(path / "x.parquet")),
    ],
)
def test_a_missing_package_is_told(result, tmp_path, monkeypatch, package, use):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(SigmafmuError, match=rf"{package} is not installed; pip install 'sigmafmu\[data\]' brings it"):
        use(result, tmp_path)


def test_files_that_cannot_be_written_are_told(result, tmp_path):
    for write in (result.to_csv, result.to_parquet, result.plot):
        with pytest.raises(SigmafmuError, match="cannot write"):
            write(tmp_path / "no folder" / "x.png")


def test_plots_are_figures(result):
    assert isinstance(result.plot(), Figure)
    named = result.plot(names=["guide.displacement"])
    (axes,) = named.axes
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), result["guide.displacement"])


def test_phase_portraits_show_joint_coordinates_that_move():
    run = sigmafmu.load("SliderCrank").run(0.5, step_size=0.01)
    figure = run.plot(phase=True)
    labels = [axes.get_xlabel() for axes in figure.axes]
    assert labels == [f"{c} in {u}" for c, u in (("crankPivot.angle", "rad"), ("wristPin.angle1", "rad"),
                                               ("wristPin.angle2", "rad"), ("guide.displacement", "m"))]  # fmt: skip
    np.testing.assert_array_equal(figure.axes[0].lines[0].get_ydata(), run["crankPivot.angularRate"])
    with pytest.raises(SigmafmuError, match="no coordinate that moves"):
        run.plot(names=["energy.total"], phase=True)
