"""The command line: what each command prints and writes, and that every mistake gets one clear line."""

import csv
from pathlib import Path

import numpy as np
import pytest

import sigmafmu
from sigmafmu.cli import app
from sigmafmu.model import Model

from ..command_line import fail, succeed

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
SHORT = "run HeavyTop --stop-time 0.02 --step-size 0.001"


def read_csv(path: Path) -> tuple[list[str], np.ndarray]:
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    return header, np.array(rows, dtype=float)


def test_version():
    assert succeed("--version") == f"sigmafmu {sigmafmu.__version__}\n"


@pytest.mark.parametrize("command", ["", *(c.name or c.callback.__name__ for c in app.registered_commands)])
def test_every_help_has_an_example(command):
    assert "Example: sigmafmu" in succeed(f"{command} --help")


def test_list_names_every_model(models):
    lines = succeed("list").splitlines()
    assert [line.split()[0] for line in lines] == models


def test_path_is_the_fmu(model, fmus_dir):
    assert Path(succeed(f"path {model}").strip()) == fmus_dir / f"{model}.fmu"


def test_info_names_every_variable_and_enumeration_item(model, fmu):
    short, full = succeed(f"info {model}"), succeed(f"info {model} --all")
    for variable in fmu(model).description.modelVariables:
        assert variable.name.partition("[")[0] in short
        assert f"{variable.name} " in full
        if variable.type == "Enumeration":
            assert all(item.name in short for item in variable.declaredType.items)


def test_info_tells_the_degrees_of_freedom():
    assert "1 (18 velocities, 17 independent joint equations)" in succeed("info SliderCrank")
    assert "6 (6 velocities, 0 independent joint equations)" in succeed("info HighSpeedRotor")


def test_run_reports_steps_and_cost():
    output = succeed(SHORT + " --set integrator.stepSize=0.0005")
    assert "0.02 s simulated" in output
    assert "40 internal steps" in output
    assert "times real time" in output


def test_csv_holds_exactly_what_was_recorded(tmp_path, fmu, model):
    succeed(f"run {model} --stop-time 0.002 --step-size 0.0005 --output {tmp_path / 'out.csv'}")
    header, table = read_csv(tmp_path / "out.csv")
    result = Model(fmu(model)).run(stop_time=0.002, step_size=0.0005)
    assert header == ["time", *result.names]
    np.testing.assert_array_equal(table, np.column_stack((result.time, result.values)))


def test_variables_are_chosen_by_name_vector_or_pattern(tmp_path):
    out = tmp_path / "out.csv"
    succeed(f"{SHORT} --variables top.velocity[2] --variables top.position --variables 'energy.*' --output {out}")
    header, _ = read_csv(out)
    position = [f"top.position[{i}]" for i in (1, 2, 3)]
    energy = ["energy.kinetic", "energy.potential", "energy.total"]
    assert header == ["time", "top.velocity[2]", *position, *energy]


def test_pattern_takes_outputs_but_a_name_takes_anything(tmp_path):
    succeed(f"{SHORT} --variables 'top.*osition' --variables top.mass --output {tmp_path / 'out.csv'}")
    header, table = read_csv(tmp_path / "out.csv")
    assert header == ["time", "top.position[1]", "top.position[2]", "top.position[3]", "top.mass"]
    assert set(table[:, -1]) == {15.0}


def test_failed_run_keeps_what_it_has(tmp_path):
    out = tmp_path / "out.csv"
    grid = "--stop-time 1 --step-size 0.01 --set integrator.stepSize=0.01"
    message = fail(f"run HeavyTop {grid} --set top.torque=0,1e6,0 --output {out}")  # spins up beyond half a turn a step
    assert "stopped at t = 0." in message
    assert "top" in message
    header, table = read_csv(out)
    assert 1 < len(table) < 101
    assert np.isfinite(table).all()
    assert header[0] == "time"


def test_settings_change_the_result(tmp_path):
    def final_position(setting: str) -> np.ndarray:
        succeed(f"{SHORT} --set {setting} --variables top.position --output {tmp_path / 'out.csv'}")
        return read_csv(tmp_path / "out.csv")[1][-1, 1:]

    default = final_position("integrator.sigma=1")
    assert np.linalg.norm(final_position("integrator.sigma=1.6") - default) > 1e-9
    assert np.linalg.norm(final_position("integrator.formulation=index3") - default) > 1e-12
    assert np.linalg.norm(final_position("gravity=0,0,-1.62") - default) > 1e-6
    np.testing.assert_array_equal(final_position("integrator.sigma=1.0"), default)


def test_plot_is_a_png(tmp_path, model):
    succeed(f"run {model} --stop-time 0.002 --step-size 0.0005 --plot {tmp_path / 'out.png'}")
    assert (tmp_path / "out.png").read_bytes().startswith(PNG_SIGNATURE)


def test_plot_of_any_choice_of_variables(tmp_path):
    succeed(f"{SHORT} --variables energy.total --plot {tmp_path / 'out.png'}")
    assert (tmp_path / "out.png").read_bytes().startswith(PNG_SIGNATURE)


def test_unknown_model_names_the_known_ones(models):
    for command in ("info", "path", "run"):
        message = fail(f"{command} HeavyTopp")
        assert "'HeavyTopp'" in message
        assert all(model in message for model in models)


def test_missing_fmus_say_where_they_were_sought(tmp_path, monkeypatch):
    monkeypatch.setenv(sigmafmu.FMUS_VARIABLE, str(tmp_path))
    assert str(tmp_path) in fail("list")
    assert str(tmp_path) in fail("path HeavyTop")


@pytest.mark.parametrize(
    ("options", "parts"),
    [
        ("--set top.mas=1", ["'top.mas'", "top.mass"]),
        ("--variables top.positon", ["'top.positon'", "top.position"]),
        ("--set top.position[1]=1", ["'top.position[1]'", "output"]),
        ("--set top.mass=heavy", ["'top.mass'", "a number", "'heavy'"]),
        ("--set top.mass=-1", ["top.mass", "-1"]),
        ("--set integrator.spectralRadius=1.5", ["integrator.spectralRadius", "1.5"]),
        ("--set integrator.formulation=index4", ["index4", "index3", "index2", "stabilizedIndex2"]),
        ("--set gravity=1,2", ["gravity", "3 elements", "2 given"]),
        ("--set integrator.sigma", ["NAME=VALUE"]),
        ("--stop-time -1", ["stop time", "-1"]),
        ("--step-size 0", ["step size"]),
        ("--output no/such/folder/out.csv", ["no/such/folder"]),
        ("--output .", ["cannot write ."]),
        ("--plot no/such/folder/out.png", ["no/such/folder"]),
        ("--plot out.nonsense", ["out.nonsense", "png"]),
    ],
)
def test_mistakes_are_explained_in_one_line(options, parts, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    message = fail(f"{SHORT} {options}")
    assert all(part in message for part in parts), message


def test_realtime_keeps_the_pace(tmp_path):
    png = tmp_path / "latency.png"
    assert "HeavyTop at 200 Hz: 100 steps" in succeed(f"realtime HeavyTop --rate 200 --duration 0.5 --plot {png}")
    assert png.read_bytes().startswith(b"\x89PNG")
    assert "must be positive" in fail("realtime HeavyTop --rate 0")
