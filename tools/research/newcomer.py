"""The way of a newcomer, timed: from a clone to a mechanism of their own that moves in the browser."""

import os
import platform
import re
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from research.bench import machine
from research.browser import Browser, programs
from sigmafmu import SigmafmuError
from sigmafmu.markdown import markdown_table

ROOT = Path(__file__).resolve().parents[2]
BEGIN, END = "<!-- measured: python -m research newcomer -->", "<!-- end of what was measured -->"
CLONE = "git clone {root} sigmafmu"
DOWNLOADS = (
    "python3 -m venv downloads",
    "downloads/bin/python sigmafmu/tools/requirements.py",
    "downloads/bin/python -m pip download -q -d packages -r requirements.txt",
)
"""Before `make demo`, which then takes packages from that folder: pip prefers it to the index."""
COMMANDS = (
    "make demo",
    "sigmafmu init Pendulum",
    "sigmafmu check Pendulum.yaml",
    "sigmafmu build Pendulum.yaml",
    "sigmafmu run Pendulum.fmu --stop-time 2 --plot pendulum.png",
    "sigmafmu view Pendulum.yaml --no-open",
)
PAGE = "Pendulum.html"
"""What the last one writes."""
SHOWN = f"`{PAGE}` in Chromium, until the pendulum moves"
MOVED = """
const { x, y } = sigmafmu.project(sigmafmu.view.motion.bodies[0].name);
window.first ??= [x, y];
return Math.hypot(x - first[0], y - first[1]) > 10;
"""
"""Whether the first body is ten pixels from where it was when this was asked for the first time."""
OURS = re.compile("VIRTUAL_ENV|PYTHONPATH|MAKE.*|MFLAGS|CMAKE_.*|CCACHE_.*|XDG_.*|SIGMAFMU_.*")
"""Variables of a developer's environment, which a newcomer has not got."""


def write(page: Path, tell: Callable[[str], None]) -> None:
    """Walk that way and put its table into `page`; raises SigmafmuError if that has no place for it."""
    text = page.read_text(encoding="utf-8")
    if BEGIN not in text or END not in text:
        raise SigmafmuError(f"{page} has no place for what is measured: {BEGIN} … {END}")
    rows = measure(tell)
    page.write_text(
        f"{text.partition(BEGIN)[0]}{BEGIN}\n\n{_where()}\n{_table(rows)}\n{END}{text.partition(END)[2]}",
        encoding="utf-8",
    )


def measure(tell: Callable[[str], None]) -> list[tuple[str, float, float]]:
    """What was done, and elapsed and processor time [s] of it and all that it started."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "home").mkdir()
        (folder / "packages").mkdir()
        environment = {k: v for k, v in os.environ.items() if not OURS.fullmatch(k)}
        links = " ".join([str(folder / "packages"), environment.get("PIP_FIND_LINKS", "")])
        environment |= {"HOME": str(folder / "home"), "PIP_FIND_LINKS": links.strip()}

        def time_of(what: str, *commands: str, place: Path) -> None:
            tell(what)
            began, before = time.perf_counter(), os.times()
            for command in commands:
                _run(command, place, environment)
            after = os.times()
            busy = after.children_user + after.children_system - before.children_user - before.children_system
            rows.append((what, time.perf_counter() - began, busy))

        clone = folder / "sigmafmu"
        time_of(f"`{CLONE.format(root='URL')}`", CLONE.format(root=ROOT), place=folder)
        time_of("downloads of `make demo`: packages from PyPI", *DOWNLOADS, place=folder)
        for command in COMMANDS:
            time_of(f"`{command}`", re.sub("^sigmafmu", ".venv/bin/sigmafmu", command), place=clone)
        tell(SHOWN)
        began = time.perf_counter()
        _open(clone / PAGE)
        rows.append((SHOWN, time.perf_counter() - began, 0.0))
    return rows


def _run(command: str, folder: Path, environment: dict[str, str]) -> None:
    """Run it; raises SigmafmuError with the end of what it printed."""
    done = subprocess.run(command.split(), cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SigmafmuError(f"`{command}` failed:\n{(done.stdout + done.stderr)[-2000:]}")
    if command.endswith("requirements.py"):
        (folder / "requirements.txt").write_text(done.stdout, encoding="utf-8")


def _open(page: Path) -> None:
    """Until the mechanism is seen to move."""
    browser = Browser()
    try:
        browser.open(page)
        browser.wait(MOVED)
    finally:
        browser.driver.quit()


def _where() -> str:
    """Machine and versions."""
    compiler = subprocess.run(["g++", "-dumpfullversion"], capture_output=True, text=True, check=True).stdout.strip()
    browser = subprocess.run([programs()[0], "--version"], capture_output=True, text=True, check=True).stdout.split()
    numbers = [word for word in browser if word[0].isdigit()]
    cores, load = len(os.sched_getaffinity(0)), os.getloadavg()[2]
    cpu = machine().partition(",")[0]
    versions = f"Python {platform.python_version()}, g++ {compiler}, Chromium {numbers[0]}"
    return f"""\
Measured in an empty folder with an empty home, on {cpu}, {cores} cores, with a mean load of
{load:.0f} over the last 15 minutes; {versions}. Elapsed time depends on the network and
on what else runs; processor time is that of all cores together.
"""


def _table(rows: list[tuple[str, float, float]]) -> str:
    total = ("all", sum(row[1] for row in rows), sum(row[2] for row in rows))
    shown = [(what, _time(elapsed), _time(busy)) for what, elapsed, busy in (*rows, total)]
    return markdown_table(("command", "elapsed", "processor"), shown)


def _time(seconds: float) -> str:
    return "" if seconds == 0 else f"{seconds:.1f} s" if seconds < 60 else f"{seconds / 60:.1f} min"
