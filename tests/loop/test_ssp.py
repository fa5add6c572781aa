"""The loops as SSP systems in other people's masters, and the commands."""

import re
import sys
import zipfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import typer
from fmpy import read_model_description
from fmpy.ssp.ssd import read_ssd
from fmpy.validation import validate_fmu
from typer.testing import CliRunner

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu
from sigmafmu.loop.cli import register
from sigmafmu.loop.closed_loop import run_closed_loop
from sigmafmu.loop.loops import CONTROLLER, LOOPS
from sigmafmu.loop.ssp import EXPONENTS, PLANT, write_ssp
from sigmafmu.loop.ssp_masters import simulate
from sigmafmu.loop.units import exponents
from sigmafmu.masters.ecos import Ecos
from sigmafmu.masters.libcosim import Libcosim
from sigmafmu.masters.process import output_of

pytest.importorskip("pythonfmu")
need_libcosim = pytest.mark.skipif(bool(Libcosim().missing()), reason="libcosimpy is not installed")
need_ecos = pytest.mark.skipif(bool(Ecos().missing()), reason="Ecos or its TBB is not installed")
FMPY, LIBCOSIM = "fmpy", pytest.param("libcosim", marks=need_libcosim)
ECOS = pytest.param("ecos", marks=need_ecos)

EXACT_H = 2**-9
"""s; a whole number of nanoseconds and of binary digits: every master passes the same bits to fmi2DoStep."""
STEPS = 60
EXACT = ("SliderCrank", "HeavyTop")
"""Loops that are compared bit by bit; the rotor's H is no such number."""

runner = CliRunner()
app = typer.Typer()
register(app)


@pytest.fixture(scope="module")
def ssp(tmp_path_factory):
    """Function that writes the SSP of a loop; each is written once."""
    folder = tmp_path_factory.mktemp("ssp")

    @cache
    def write(model):
        write_ssp(LOOPS[model], folder / f"{model}.ssp")
        return folder / f"{model}.ssp"

    return write


def blind_at_first(loop, **values):
    """The loop's controller, which gets zeros at the first sample, as FMPy does it."""
    law = loop.parts[CONTROLLER].law(**values)

    def step(time, H, measured):
        return law.step(time, H, measured if time > 0 else dict.fromkeys(measured, 0.0))

    return step


def base_units(description):
    """Unit → its exponents, None where there is no BaseUnit."""
    return {
        u.name: u.baseUnit and {si: int(getattr(u.baseUnit, si)) for si in EXPONENTS if int(getattr(u.baseUnit, si))}
        for u in description.unitDefinitions
    }


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("1", {}),
        ("N.m.s/rad", {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("kg.m2", {"kg": 1, "m": 2}),
        ("N/m", {"kg": 1, "s": -2}),
        ("rad/s2", {"rad": 1, "s": -2}),
        ("furlong", None),
    ],
)
def test_units_are_taken_apart(unit, expected):
    assert exponents(unit) == expected


def test_units_of_the_mechanisms_are_taken_apart(fmu, model):
    declared = base_units(fmu(model).description)
    assert {unit: exponents(unit) for unit in declared} == declared


@pytest.mark.parametrize("loop", LOOPS.values(), ids=list(LOOPS))
def test_system_is_valid_and_complete(ssp, loop, tmp_path):
    """FMPy checks the schema and every FMU; each wire of the table is a connection between connectors that exist."""
    path = ssp(loop.plant)
    with zipfile.ZipFile(path) as archive:
        assert len(archive.namelist()) == 2 + len(loop.parts)
        archive.extractall(tmp_path)
    system = read_ssd(path).system
    connectors = {(c.name, k.name): k.kind for c in system.elements for k in c.connectors}
    wires = {(c.startElement, c.startConnector): (c.endElement, c.endConnector) for c in system.connections}
    plant = Fmu(tmp_path / "resources" / "plant.fmu")
    plant_units = base_units(plant.description)
    for name, part in loop.parts.items():
        file = str(tmp_path / "resources" / f"{name}.fmu")
        assert validate_fmu(file) == []
        description = read_model_description(file)
        units = base_units(description)
        assert set(units) == {v.unit for v in description.modelVariables}
        assert None not in units.values(), "every unit says of what it consists"
        connected = {plant.variables[n].unit for n in [*part.measured.values(), *part.actuated.values()]}
        assert {unit: units[unit] for unit in connected} == {unit: plant_units[unit] for unit in connected}
        for ours, theirs in part.measured.items():
            assert (PLANT, theirs, name, ours) in {
                (c.startElement, c.startConnector, c.endElement, c.endConnector) for c in system.connections
            }
        for ours, theirs in part.actuated.items():
            assert wires[name, ours] == (PLANT, theirs)
    for start, end in wires.items():
        assert (connectors[start], connectors[end]) == ("output", "input")


@pytest.mark.parametrize("master", [LIBCOSIM, ECOS])
@pytest.mark.parametrize("model", EXACT)
def test_master_is_the_scripted_loop_with_a_delay_of_one(ssp, master, model):
    """To the last bit, and not with another delay."""
    loop = LOOPS[model]
    got = simulate(master, ssp(model), loop, EXACT_H, STEPS)
    runs = [run_closed_loop(loop, EXACT_H, STEPS * EXACT_H, delay=delay) for delay in (0, 1, 2)]
    for name in loop.outputs:
        np.testing.assert_array_equal(got[name], runs[1][name][1:])
    for other in (runs[0], runs[2]):
        assert any(not np.array_equal(got[name], other[name][1:]) for name in loop.outputs)


@pytest.mark.parametrize("model", EXACT)
def test_fmpy_is_the_same_but_for_zeros_at_the_first_sample(ssp, model):
    """To the last bit. It adds up its time, which is exact for this H."""
    loop = LOOPS[model]
    got = simulate(FMPY, ssp(model), loop, EXACT_H, STEPS)
    expected = run_closed_loop(loop, EXACT_H, STEPS * EXACT_H, blind_at_first(loop), delay=1)
    for name in loop.outputs:
        np.testing.assert_array_equal(got[name], expected[name][1:])


@pytest.mark.parametrize("master", [LIBCOSIM, ECOS, FMPY])
def test_rotor_with_its_bearings_and_seal(ssp, master):
    """Three FMUs at a decimal H: rounding of the time is all that differs. The rotor starts at zero, as FMPy has it.

    Rounding of H by 1e-16 in each of 200 steps: below 1e-12 of the largest value.
    """
    loop = LOOPS["HighSpeedRotor"]
    got = simulate(master, ssp("HighSpeedRotor"), loop, loop.H, 200)
    expected = run_closed_loop(loop, stop_time=200 * loop.H, delay=1)
    for name in loop.outputs:
        np.testing.assert_allclose(got[name], expected[name][1:], rtol=0, atol=1e-12 * np.abs(expected[name]).max())


@need_libcosim
def test_start_values_are_bound(tmp_path):
    """libcosim applies those of the plant and of the controller; FMPy knows those of the controller's FMU alone."""
    loop, values = LOOPS["SliderCrank"], {"gravity[3]": -1.62, "controller.setPoint": 8.0}
    path = tmp_path / "bound.ssp"
    write_ssp(loop, path, values)
    everything = run_closed_loop(loop, EXACT_H, STEPS * EXACT_H, start_values=values, delay=1)
    got = simulate("libcosim", path, loop, EXACT_H, STEPS)["crankPivot.angularRate"]
    np.testing.assert_array_equal(got, everything["crankPivot.angularRate"][1:])

    blind = blind_at_first(loop, setPoint=8.0)
    controller_alone = run_closed_loop(loop, EXACT_H, STEPS * EXACT_H, blind, delay=1)
    got = simulate(FMPY, path, loop, EXACT_H, STEPS)["crankPivot.angularRate"]
    np.testing.assert_array_equal(got, controller_alone["crankPivot.angularRate"][1:])


ONE_STEP = """
import sys
from libcosimpy.CosimExecution import CosimExecution
execution = CosimExecution.from_ssp_file(sys.argv[1])
print("reached", execution.step() and execution.status().current_time)
"""


@need_libcosim
def test_libcosim_finds_the_communication_step_in_the_file(ssp, tmp_path):
    output = output_of([sys.executable, "-c", ONE_STEP, ssp("HeavyTop")], tmp_path)
    assert f"reached {round(LOOPS['HeavyTop'].H * 1e9)}\n" in output


def test_snippets_of_the_documentation_run(tmp_path):
    """A function, a class in a file of its own, its FMU and its SSP."""
    page = (Path(__file__).parents[2] / "docs" / "control.md").read_text(encoding="utf-8")
    function, law, fmu_and_ssp = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    for name, code in (("function.py", function), ("governor.py", law), ("use.py", fmu_and_ssp)):
        (tmp_path / name).write_text(code, encoding="utf-8")
    assert -0.1 < float(output_of([sys.executable, "function.py"], tmp_path)) < 0.1  # braked
    output_of([sys.executable, "use.py"], tmp_path)
    assert validate_fmu(str(tmp_path / "fmus" / "Governor.fmu")) == []
    assert read_ssd(tmp_path / "governor.ssp").name == "SliderCrank"


def test_a_file_that_cannot_be_written(tmp_path):
    with pytest.raises(SigmafmuError, match=r"cannot write .*crank\.ssp"):
        write_ssp(LOOPS["SliderCrank"], tmp_path / "nowhere" / "crank.ssp")


# --- the commands ---


def test_loop_command(tmp_path):
    plot, csv = tmp_path / "loop.png", tmp_path / "loop.csv"
    options = ["--stop-time", "0.3", "--set", "controller.stepTime=0.1", "--plot", str(plot), "--output", str(csv)]
    result = runner.invoke(app, ["loop", "SliderCrank", *options], catch_exceptions=False)
    assert result.exit_code == 0
    row = next(line for line in result.output.splitlines() if "rise time" in line)
    assert 0.005 < float(re.search(r"([\d.]+) s", row)[1]) < 0.05  # inertia × step / torque limit = 14 ms
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert csv.read_text().splitlines()[0].startswith("time,crankPivot.angularRate")


@pytest.mark.parametrize(
    ("model", "row"), [("HighSpeedRotor", "largest bearing force"), ("HeavyTop", "largest torque")]
)
def test_loop_command_draws_the_others(model, row, tmp_path):
    plot = tmp_path / "loop.png"
    result = runner.invoke(app, ["loop", model, "--stop-time", "0.02", "--plot", str(plot)], catch_exceptions=False)
    assert result.exit_code == 0
    assert row in result.output
    assert plot.stat().st_size > 10_000


def test_ssp_command(tmp_path):
    path = tmp_path / "top.ssp"
    result = runner.invoke(app, ["ssp", "HeavyTop", "--output", str(path)], catch_exceptions=False)
    assert result.exit_code == 0
    assert read_ssd(path).name == "HeavyTop"
