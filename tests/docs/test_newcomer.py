"""The newcomer's way that is timed is one that there is, and its table is the page's."""

import re
import shlex

import pytest
import typer

from research import newcomer
from sigmafmu import SigmafmuError
from sigmafmu.cli import app

from .pages import ROOT, read


@pytest.mark.parametrize("command", newcomer.COMMANDS)
def test_every_command_exists(command):
    program, name, *words = shlex.split(command)
    if program == "make":
        assert re.search(rf"^{name}:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    else:
        typer.main.get_command(app).commands[name].make_context(name, words)


def test_the_table_goes_between_its_marks(tmp_path, monkeypatch):
    page = tmp_path / "page.md"
    page.write_text(f"before\n{newcomer.BEGIN}\nold\n{newcomer.END}\nafter\n", encoding="utf-8")
    monkeypatch.setattr(newcomer, "measure", lambda tell: [("`make demo`", 125.0, 200.0), ("`run`", 2.04, 0.0)])
    monkeypatch.setattr(newcomer, "_where", lambda: "Here.\n")
    newcomer.write(page, print)
    text = page.read_text(encoding="utf-8")
    assert text.startswith(f"before\n{newcomer.BEGIN}\n\nHere.\n\n| command | elapsed | processor |\n")
    assert "| `make demo` | 2.1 min | 3.3 min |\n| `run` | 2.0 s |  |\n| all | 2.1 min | 3.3 min |\n" in text
    assert text.endswith(f"{newcomer.END}\nafter\n")
    assert "old" not in text
    page.write_text("no marks", encoding="utf-8")
    with pytest.raises(SigmafmuError, match="has no place for what is measured"):
        newcomer.write(page, print)


def test_a_command_that_fails_is_told(tmp_path):
    with pytest.raises(SigmafmuError, match=r"^`ls nothing` failed:\n.*nothing"):
        newcomer._run("ls nothing", tmp_path, {"PATH": "/usr/bin:/bin"})


def test_the_page_times_these_commands():
    measured = read(ROOT / "docs" / "start.md").partition(newcomer.BEGIN)[2].partition(newcomer.END)[0]
    if measured.strip():
        assert re.findall(r"^\| `((?:make|sigmafmu) .*?)` \|", measured, re.MULTILINE) == list(newcomer.COMMANDS)
