"""The commands for mechanism files: what they print and write, and that mistakes are lines that editors understand."""

import csv
import re
import shutil

import pytest

from sigmafmu import fmu_path

from ..command_line import run, succeed
from .helpers import LIBRARY


def fail(command: str) -> list[str]:
    """The lines of the error."""
    result = run(command)
    assert result.exit_code == 1, result.output
    assert result.stdout == ""
    return result.stderr.splitlines()


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_what_init_writes_checks_and_runs(tmp_path):
    assert succeed("init Arm") == "wrote Arm.yaml\n"
    printed = succeed("check Arm.yaml")
    assert "Arm: 2 bodies, 2 joints" in printed
    assert "degrees of freedom: 4 " in printed
    assert "assembled: nothing had to move" in printed
    succeed("run Arm.yaml --stop-time 0.1 --variables 'shoulder.*' --output arm.csv")
    with (tmp_path / "arm.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 11
    assert float(rows[0]["shoulder.angle"]) == pytest.approx(0.5235987755982988, abs=1e-12)  # 30 deg


def test_init_overwrites_nothing(tmp_path):
    (tmp_path / "Arm.yaml").write_text("mine", encoding="utf-8")
    assert fail("init Arm") == ["Error: Arm.yaml exists; nothing was written"]
    assert (tmp_path / "Arm.yaml").read_text(encoding="utf-8") == "mine"


def test_init_wants_a_name():
    assert "is no name of a model" in fail("init 9x")[0]


@pytest.mark.parametrize("command", ["check", "run", "build"])
def test_mistakes_are_lines_for_editors(tmp_path, command):
    (tmp_path / "bad.yaml").write_text(
        "sigmafmu: 1\nname: A\nbodies:\n  a: {mass: 0, inertia: [1, 1]}\n", encoding="utf-8"
    )
    assert fail(f"{command} bad.yaml") == [
        "bad.yaml:4: bodies.a.inertia: has 2 entries; it must be a list of 3",
        "bad.yaml:4: bodies.a.mass: is 0 kg; it must be above 0",
    ]


@pytest.mark.parametrize("command", ["check", "run", "build"])
def test_a_file_that_is_not_there(command):
    assert fail(f"{command} absent.yaml") == ["absent.yaml:1: cannot be read: No such file or directory"]


def test_run_takes_fmus(tmp_path):
    shutil.copyfile(fmu_path("HeavyTop"), tmp_path / "top.fmu")
    assert succeed("run top.fmu --stop-time 0.01").startswith("HeavyTop: 0.01 s simulated")
    (tmp_path / "no.fmu").write_text("no zip", encoding="utf-8")
    assert fail("run no.fmu") == ["Error: no.fmu is no FMU: File is not a zip file"]
    assert fail("run absent.fmu") == ["Error: absent.fmu is no FMU: No such file or directory"]


def test_check_draws(tmp_path):
    pytest.importorskip("sigmafmu.contents.draw")
    succeed(f"check {LIBRARY / 'FlexibleSliderCrank.yaml'} --plot crank.png")
    assert (tmp_path / "crank.png").read_bytes().startswith(b"\x89PNG")


def test_build_makes_an_fmu_that_runs(tmp_path):
    pytest.importorskip("sigmafmu.packing")
    succeed(f"build {LIBRARY / 'FlexibleSliderCrank.yaml'} -o crank.fmu")
    assert "FlexibleSliderCrank: 0.01 s simulated" in succeed("run crank.fmu --stop-time 0.01")


def test_check_tells_redundant_equations_by_joint():
    printed = succeed(f"check {LIBRARY / 'PlanarFourBar.yaml'}")
    assert "3 of the 20 equations of hinge1, hinge2, hinge3, hinge4" in printed
    assert re.search(r"assembled: coupler moved by 0\.\d+ m, \d\.\d+ deg", printed)
    assert "placed: crank by hinge1" in printed


def test_run_sets_parameters_inputs_and_words():
    library = LIBRARY / "SliderCrank.yaml"
    printed = succeed(
        f"run {library} --stop-time 0.01 --set gravity=0,0,0 --set crank.mass=0.5 --set crankPivot.motorTorque=0.1 "
        "--set integrator.formulation=index3 --set integrator.stepSize=1e-3 --output out.csv"
    )
    assert "10 internal steps" in printed


@pytest.mark.parametrize(
    ("setting", "what"),
    [
        ("crank.mass=-1", "crank.mass is -1"),
        ("crank.weight=1", "has no variable 'crank.weight'; did you mean"),
        ("integrator.formulation=index4", "index4"),
        ("crank.mass=heavy", "'crank.mass' needs a number, not 'heavy'"),
    ],
)
def test_run_refuses_settings(setting, what):
    lines = fail(f"run {LIBRARY / 'SliderCrank.yaml'} --stop-time 0.01 --set {setting}")
    assert what in lines[-1]


def test_run_refuses_patterns_that_match_nothing():
    assert (
        "FreeBody has no variable 'nothing.*'" in fail(f"run {LIBRARY / 'FreeBody.yaml'} --variables 'nothing.*'")[-1]
    )
