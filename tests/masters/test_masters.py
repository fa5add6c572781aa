"""Every FMU in every master and validator that is installed; `-m heavy` runs those that need Java."""

import re
import shlex
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

import fmpy
import numpy as np
import pytest
from typer.testing import CliRunner

from sigmafmu import SigmafmuError, compat
from sigmafmu.cli import app
from sigmafmu.compat import PARAMETERS, standard_run
from sigmafmu.masters import Master, Run, Tool, ToolError, Validator, comparable, java, largest_difference, tools
from sigmafmu.masters.fmi_sim import FmiSim
from sigmafmu.masters.fmpy import FmpyMaster
from sigmafmu.masters.gemseo import PYTHON_VARIABLE, Gemseo
from sigmafmu.masters.java import CACHE_VARIABLE
from sigmafmu.masters.maestro import Maestro
from sigmafmu.masters.process import ProcessError, output_of
from sigmafmu.model import Model

VALIDATORS = [tool for tool in tools() if isinstance(tool, Validator)]
MASTERS = [tool for tool in tools() if isinstance(tool, Master) and not isinstance(tool, FmpyMaster)]


def each(chosen: list[Tool]) -> pytest.MarkDecorator:
    """A parameter `tool`, the heavy ones marked."""
    return pytest.mark.parametrize(
        "tool", [pytest.param(t, id=t.name, marks=pytest.mark.heavy if t.heavy else ()) for t in chosen]
    )


def need(tool: Tool) -> None:
    tool.fetch()
    if reason := tool.missing():
        pytest.skip(f"{tool.name}: {reason}")


@each(VALIDATORS)
def test_validator_finds_nothing(fmu, model, tool):
    need(tool)
    assert tool.validate(fmu(model)) == []


@each(MASTERS)
def test_master_gets_the_bits_of_fmpy(fmu, model, tool):
    """Of every output, after parameters were set; see compat.py for why bits can be asked for."""
    need(tool)
    run = standard_run(fmu(model))
    expected, got = FmpyMaster().simulate(run), tool.simulate(run)
    assert len(expected["integrator.steps"]) == run.steps
    assert largest_difference(got, comparable(expected, run, tool)) == 0


def test_parameters_of_the_standard_run_matter(fmu, model):
    """Otherwise equal bits would not show that the masters set them."""
    run = standard_run(fmu(model))
    expected = FmpyMaster().simulate(run)
    for left_out in PARAMETERS:
        others = {name: value for name, value in PARAMETERS.items() if name != left_out}
        assert largest_difference(FmpyMaster().simulate(Run(run.fmu, run.H, run.steps, others)), expected) > 0


@each([tool for tool in MASTERS if not tool.heavy])
def test_a_decimal_step_differs_by_rounding_only(fmu, model, tool):
    """FMPy passes t[i+1] - t[i] to doStep, the others H itself or whole nanoseconds: those differ in the last bits.

    What follows from that is rounding in up to 2e4 internal steps, amplified by the rotor's stiff supports. Measured:
    4e-11 of the largest value with the same unit; the bound leaves a factor 25 for other processors. Where all values
    of a unit are rounding, as at a frame's origin that a joint holds, so are the differences.
    """
    rounding = 1e-12
    need(tool)
    run = Run(fmu(model), 1e-3, 100, PARAMETERS)
    expected, got = FmpyMaster().simulate(run), tool.simulate(run)
    scale: dict[str | None, float] = {}
    for name, values in expected.items():
        unit = run.fmu.variables[name].unit
        scale[unit] = max(scale.get(unit, 0.0), np.max(np.abs(values)))
    for name in run.recorded("Real"):
        assert np.max(np.abs(got[name] - expected[name])) <= max(
            rounding, 1e-9 * scale[run.fmu.variables[name].unit]
        ), name


def test_our_own_loop_gets_the_bits_of_fmpy(fmu, model):
    run = standard_run(fmu(model))
    result = Model(run.fmu).run(stop_time=run.stop_time, step_size=run.H, parameters=PARAMETERS)
    got = {name: result[name][1:] for name in result.names}
    assert largest_difference(got, FmpyMaster().simulate(run)) == 0


def test_fmpy_simulates_with_the_default_experiment(fmu, model):
    """The way most people try an FMU first: hardly more than the name of the file."""
    result = fmpy.simulate_fmu(str(fmu(model).path), stop_time=0.1)
    assert result["time"][-1] == pytest.approx(0.1)
    names = [name for name in result.dtype.names if name != "time"]
    assert names, "outputs are recorded without asking for them"
    assert all(np.isfinite(result[name]).all() for name in names)


@pytest.mark.heavy
def test_maestro_still_needs_the_copy_without_enumerations(fmu):
    """When this fails, Maestro has learnt enumerations and its note can go."""
    tool = Maestro()
    need(tool)
    run = standard_run(fmu("HeavyTop"))
    with pytest.raises(ToolError, match="Enumeration not supported"):
        tool.simulate_file(run, run.fmu.path)


# --- sigmafmu compat --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("other", "difference"),
    [([1.0, -2.0], 0.0), ([1.0, -2.5], 0.25), ([1.0, np.nan], np.nan)],
)
def test_difference_is_relative_and_shows_nan(other, difference):
    got = largest_difference({"x": np.array(other)}, {"x": np.array([1.0, -2.0])})
    np.testing.assert_equal(got, difference)


def test_difference_needs_the_same_outputs_and_points():
    zero, one = np.zeros(3), np.zeros(2)
    assert largest_difference({"x": -zero}, {"x": zero}) > 0, "the sign of zero is a bit, too"
    with pytest.raises(ToolError, match="only one of the masters has y"):
        largest_difference({"x": zero, "y": zero}, {"x": zero})
    with pytest.raises(ToolError, match="2 instead of 3 communication points"):
        largest_difference({"x": one}, {"x": zero})


@pytest.mark.parametrize(
    ("code", "text"),
    [("import os; os.abort()", "crashed with signal 6"), ("exit('no such FMU')", "exit code 1: no such FMU")],
)
def test_a_crash_of_a_tool_is_told(tmp_path, code, text):
    with pytest.raises(ProcessError, match=text):
        output_of([sys.executable, "-c", code], tmp_path)


class Absent(Validator):
    name, source, command = "Absent", "nowhere", "absent FMU"

    def missing(self) -> str:
        return "not installed"

    def version(self) -> str:
        raise AssertionError("a missing tool has no version")

    def validate(self, fmu) -> list[str]:
        raise AssertionError("a missing tool cannot be run")


class Strict(Absent):
    name = "Strict"

    def missing(self) -> None:
        return None

    def version(self) -> str:
        return "1.0"

    def validate(self, fmu) -> list[str]:
        return ["something is wrong", "something else"]


class Crashing(Strict):
    name = "Crashing"

    def validate(self, fmu) -> list[str]:
        raise ToolError("crashed with signal 11")


def test_missing_failing_and_complaining_tools_are_told(models):
    count = []
    columns = compat.check(models, [Absent(), Strict(), Crashing()], lambda: count.append(1))
    assert len(count) == 3 * len(models)
    cells = {column.tool.name: set(column.cells) for column in columns}
    assert cells == {
        "Absent": {"not installed"},
        "Strict": {"2 findings: something is wrong"},
        "Crashing": {"fails: crashed with signal 11"},
    }
    page = compat.page(models, columns)
    assert "| Absent | – | nowhere | `absent FMU` |" in page
    assert "| Strict | 1.0 | nowhere | `absent FMU` |" in page


class Peculiar(Master):
    source, command = "nowhere", "peculiar FMU"
    records = ("Real",)

    def __init__(self, name, note, missing=None):
        self.name, self.note, self._missing = name, note, missing

    def missing(self):
        return self._missing

    def version(self) -> str:
        return "1.0"

    def simulate(self, run: Run):
        recorded = FmpyMaster().simulate(run)
        return {name: recorded[name] for name in run.recorded("Real")}


def test_every_note_has_its_mark():
    chosen = [Peculiar("A", "A is slow"), Peculiar("B", "B is rare", "not installed"), Peculiar("C", "C is strict")]
    columns = compat.check(["HeavyTop"], chosen, lambda: None)
    assert [c.cells for c in columns] == [["same bits as FMPy ¹"], ["not installed"], ["same bits as FMPy ²"]]
    assert compat.notes(columns) == ["¹ A is slow.", "² C is strict."]


@pytest.mark.parametrize("tool", [FmiSim(), Gemseo()], ids=lambda t: t.name)
def test_optional_tools_say_that_they_are_missing(tool, monkeypatch):
    monkeypatch.delenv(PYTHON_VARIABLE, raising=False)
    monkeypatch.setattr(shutil, "which", lambda *_, **__: None)
    assert tool.missing().startswith("not installed")


def snippet(page: str, word: str) -> str:
    """The Python example of a page that imports `word`."""
    text = (Path(__file__).parents[2] / page).read_text(encoding="utf-8")
    (found,) = [code for code in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if f"from {word}" in code]
    return found


@pytest.mark.heavy
def test_the_example_for_gemseo_runs_and_sets_the_fixed_parameter(fmu, tmp_path):
    tool = Gemseo()
    need(tool)
    crank = fmu("SliderCrank")
    shutil.copy(crank.path, tmp_path)
    (tmp_path / "example.py").write_text(snippet("docs/fmi.md", "gemseo_fmu") + "\nprint(float(energy[-1]))\n")
    shown = output_of([tool._python, "example.py"], tmp_path)
    settings = {"gravity[3]": -1.62, "crank.mass": 0.3}
    expected = Model(crank).run(stop_time=0.1, parameters=settings, outputs=["energy.total"])["energy.total"][-1]
    assert float(shown.split()[-1]) == pytest.approx(expected, rel=1e-9)


def test_the_example_for_omsimulator_names_what_exists(fmu):
    code = snippet("docs/start.md", "OMSimulator")
    compile(code, "docs/start.md", "exec")
    (name,) = re.findall(r'CRef\("default", "crank", "([^"]+)"\)', code)
    assert fmu("SliderCrank").variables[name].causality == "input"
    if find_spec("OMSimulator"):
        exec(code, {})


def test_command_prints_the_matrix_and_writes_the_page(tmp_path, models):
    file = tmp_path / "page.md"
    result = CliRunner().invoke(app, shlex.split(f"compat --tool fmpy --output {file}"), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    assert result.stdout.count("simulates") == len(models)
    text = file.read_text(encoding="utf-8")
    assert all(f"| `{model}` | simulates |" in text for model in models)
    assert FmpyMaster().version() in text


def test_java_tools_say_what_is_missing(tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    monkeypatch.setattr(shutil, "which", lambda program: program if program == "java" else None)
    assert "Maven (mvn) is not installed" in Maestro().missing()
    monkeypatch.setattr(shutil, "which", lambda program: None)
    assert Maestro().missing() == "Java is not installed"


def test_nothing_is_downloaded_without_consent(tmp_path, monkeypatch):
    """Without a terminal and --yes the answer is no; with --yes Maven is asked for what is missing, once."""
    commands = []

    def maven(command, folder):
        commands.append(command)
        raise ProcessError("mvn", "failed", "no route to host")

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv(CACHE_VARIABLE, raising=False)
    monkeypatch.setattr(shutil, "which", lambda program: program)
    monkeypatch.setattr(java, "output_of", maven)
    monkeypatch.setattr(java, "failures", {})
    assert java.cache() == tmp_path / "sigmafmu" / "tools"
    assert "64 MB" in Maestro().download()
    result = CliRunner().invoke(app, ["compat", "--tool", "maestro"], catch_exceptions=False)
    assert "--yes" in result.stdout
    assert commands == []
    CliRunner().invoke(app, ["compat", "--tool", "maestro", "--yes"], catch_exceptions=False)
    assert len(commands) == 1
    assert "no route to host" in Maestro().missing()


def test_unknown_tool_names_the_known_ones():
    with pytest.raises(SigmafmuError, match=r"unknown tool 'cosim'; known tools: .*libcosim"):
        compat.choose(["cosim"])
