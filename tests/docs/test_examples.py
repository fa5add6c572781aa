"""Every example in README.md and docs/ runs, in order, in a folder of its page; what cannot run says why.

Commands that take long have a shorter stand-in, in which the text around them stays true. Those that are not run are
parsed, so that no page shows an option that does not exist.
"""

import re
import shlex
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
import scipy.sparse
import typer
from typer.core import TyperGroup
from typer.testing import CliRunner

from research.cli import app as research
from sigmafmu.cli import app as sigmafmu
from sigmafmu.view import page as view_page

from ..modes.hexahedra import block as hexahedra
from .pages import ROOT, Block, blocks, command_lines, inline_commands, is_shell

NOT_RUN = {
    "make": "runs all of this; its targets are looked up",
    "pip": "installs",
    "cmake": "is what tests/fmu/test_sources.py does",
    "sigmafmu compat": "is what tests/masters does",
    "sigmafmu couple": "takes minutes; tests/cli/test_figures.py runs it with one stiffness",
    "sigmafmu sampling": "takes a minute; tests/loop/test_sampling.py runs its parts",
    "python -m sigmafmu.mechanism_file": "writes what tests/mechanism_file compares",
    "python -m research view": "takes pictures for minutes; tests/view has its parts",
    "python -m research sweeps": "takes minutes",
    "sigmafmu realtime HeavyTop --view": "waits for a browser; tests/view/test_live.py has one",
    "sigmafmu view models/library/": "names files of the sources; test_site.py compares the page with them",
    "python -m research gym": "measures for half a minute; tests/gym has its parts",
    "python -m research compare": "measures for minutes",
    "python -m research gallery": "takes pictures for minutes",
    "python -m research newcomer": "clones, sets up and builds",
    "python -m research study": "takes minutes; `make study QUICK=1` is part of CI",
}
"""Beginning of a command → why it is parsed only."""

SHORTER = {
    "sigmafmu realtime HeavyTop --rate 1000": ["--duration", "0.3"],
    "sigmafmu view ": ["--no-open", "--stop-time", "0.1"],
    "sigmafmu loop HighSpeedRotor --plot": ["--stop-time", "0.05"],
    "sigmafmu loop HighSpeedRotor --stop-time 1.5": ["--stop-time", "0.1", "--set", "controller.startTime=0.05"],
    "sigmafmu loop SliderCrank --plot": ["--stop-time", "0.3"],
    "sigmafmu loop HeavyTop --plot": ["--stop-time", "0.3"],
}
"""Beginning of a command → options that make it quick."""

NO_EXAMPLES = {
    "fmu_src/lie/": "a listing of folders",
    "from OMSimulator": "OMSimulator is not among the test's packages",
    "import OMSimulator": "OMSimulator is not among the test's packages",
    "dask scheduler": "wants machines; tests/sweeps/test_sweep.py has schedulers with processes",
    "gemseo_fmu": "GEMSEO wants an environment of its own; tests/masters/test_masters.py runs it there",
}
"""Beginning of a block → why it is none."""

FAILS = {"sigmafmu check Wrong.yaml"}
"""Commands that show what an error looks like."""

NEEDS = {"own-mechanism.md": ("libcosimpy", "ecospy")}
"""Page → packages that not every platform has."""

FILES = {".csv", ".png", ".json", ".ssp", ".md", ".npz", ".mat", ".nc"}
"""An --output with another ending is a variable."""

RUN = {"python", "yaml", "xml", "text"}
"""Languages of blocks that are run, written to a file, or compared with what was printed."""

APPS = {"sigmafmu": sigmafmu, "python -m research": research}
"""Beginning of a command → the application that parses it."""

HAS_VIEWER = Path(view_page.__file__).with_name(view_page.VIEWER).is_file()

ALL = blocks()


def reason_not_to_run(command: str) -> str:
    if not HAS_VIEWER and re.match("sigmafmu view (?!.*--gltf)|.*--animate", command):
        return "the package was built without npm, so it has no viewer"
    return next((why for start, why in NOT_RUN.items() if command.startswith(start)), "")


def is_no_example(block: Block) -> bool:
    return any(start in block.text[:120] for start in NO_EXAMPLES)


def resolve(command: str) -> tuple[str, Any, list[str]]:
    """Name, click command and remaining words."""
    beginning = next(b for b in APPS if command.startswith(b + " "))
    words, found, name = shlex.split(command)[len(beginning.split()) :], typer.main.get_command(APPS[beginning]), ""
    context = typer.Context(found)
    while isinstance(found, TyperGroup) and words:
        name, found, words = found.resolve_command(context, words)
    return name, found, words


def parse(command: str) -> None:
    """Raises click's error if the command or one of its options does not exist."""
    name, found, words = resolve(command)
    found.make_context(name, words)


def _finite_elements(folder: Path) -> None:
    """A bar of 459 nodes with nine in each end section, as the example has it."""
    K, M, X = hexahedra((1.0, 0.02, 0.02), (50, 2, 2), 210e9, 0.3, 7850.0)
    for name, matrix in (("K", K), ("M", M)):
        scipy.io.mmwrite(folder / f"{name}.mtx", scipy.sparse.coo_matrix(matrix), symmetry="symmetric", precision=17)
    np.savetxt(folder / "nodes.csv", X, delimiter=",")


def run_command(command: str) -> str:
    """What it prints."""
    shorter = next((options for start, options in SHORTER.items() if command.startswith(start)), [])
    words = [*shlex.split(command)[1:], *shorter]
    result = CliRunner().invoke(sigmafmu, words, catch_exceptions=False)
    assert result.exit_code == (command in FAILS), f"{command}\n{result.output}"
    for option, name in pairwise(words):
        if option in ("--output", "--plot", "--file") and Path(name).suffix in FILES:
            assert Path(name).stat().st_size > 0, f"{command} wrote no {name}"
            if option == "--plot":
                assert Path(name).read_bytes().startswith(b"\x89PNG")
    return result.output


@pytest.mark.parametrize("page", sorted({b.page for b in ALL}))
def test_examples_of(page, tmp_path, monkeypatch):
    """In order: a block may use what one before it has made."""
    absent = [package for package in NEEDS.get(page, ()) if not find_spec(package)]
    if absent:
        pytest.skip(f"not installed: {', '.join(absent)}")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    if page == "modes.md":
        _finite_elements(tmp_path)
    variables, printed = {"__name__": "__main__"}, ""
    for block in ALL:
        if block.page != page or is_no_example(block) or block.included.endswith(".py"):  # test_scripts.py runs them
            continue
        if is_shell(block):
            printed = run_shell(block)
        elif block.language == "text":  # what the commands before it print
            for line in block.text.splitlines():
                assert line in printed, f"{block.name}: {line}\n{printed}"
        elif file := re.match(r"(?:#|<!--) (\w+\.(py|yaml|urdf))\b", block.text):
            Path(file[1]).write_text(block.text, encoding="utf-8")
        elif part := re.match(r"# of (\w+\.yaml)\n", block.text):  # what a command before has written
            assert block.text[part.end() :] in Path(part[1]).read_text(encoding="utf-8"), block.name
        else:
            text = block.text if HAS_VIEWER else re.sub(r"^.*\.show\(\).*$", "", block.text, flags=re.MULTILINE)
            exec(compile(text, block.name, "exec"), variables)
    if page == "start.md":  # "one number starts a mechanism: the crank at 10 rad/s"
        angle = variables["result"]["crankPivot.angle"]
        assert (angle[1] - angle[0]) / 0.01 == pytest.approx(10.0, rel=0.1)


def run_shell(block: Block) -> str:
    """What its commands print."""
    printed = ""
    for command in command_lines(block):
        if command.startswith("make"):
            assert has_target(command), command
        elif command.startswith(tuple(APPS)):
            parse(command)
            if not reason_not_to_run(command):
                printed += run_command(command)
        else:
            assert reason_not_to_run(command), f"{block.name}: {command} is neither run nor excused"
    return printed


def test_nothing_is_left_out():
    """Every block is run, or has a reason not to be."""
    forgotten = [b.name for b in ALL if not (is_shell(b) or b.language in RUN or is_no_example(b))]
    assert forgotten == []


def has_target(command: str) -> bool:
    """Whether the Makefile knows what `make …` is to make."""
    target = next(word for word in command.split()[1:] if "=" not in word)
    return re.search(rf"^{target}:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE) is not None


@pytest.mark.parametrize("command", sorted({c for _, c in inline_commands() if c.startswith("make ")}))
def test_targets_in_sentences_exist(command):
    assert has_target(command)


@pytest.mark.parametrize("command", sorted({c for _, c in inline_commands() if c.startswith(tuple(APPS))}))
def test_commands_in_sentences_exist(command):
    """They are rarely complete, but what they name is there."""
    _, found, words = resolve(command)
    known = {option for parameter in found.params for option in (*parameter.opts, *parameter.secondary_opts)}
    assert {word for word in words if word.startswith("-")} <= known


@pytest.mark.parametrize(
    ("beginning", "name"), [(b, n) for b in APPS for n in typer.main.get_command(APPS[b]).commands]
)
def test_the_example_of_every_help_exists(beginning, name):
    command = typer.main.get_command(APPS[beginning]).commands[name]
    example = re.sub(r"\s+", " ", command.epilog or "").partition("Example: ")[2].partition(" | ")[0]
    if isinstance(command, TyperGroup) and not example:
        example = command.callback.__doc__ or ""
    assert example.startswith(f"{beginning} "), name
    parse(example)
