"""The way of a newcomer, timed: from a clone to a mechanism of their own that moves in the browser."""

import os
import subprocess
import tempfile
import time
from pathlib import Path

from research.browser import Browser

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = (
    ("git clone {root} sigmafmu", "."),
    ("make setup", "sigmafmu"),
    ("make build", "sigmafmu"),
    (".venv/bin/sigmafmu init Pendulum", "sigmafmu"),
    (".venv/bin/sigmafmu view Pendulum.yaml --no-open --output Pendulum.html", "sigmafmu"),
)
SHOWN = "open `Pendulum.html` in Chromium, until it moves"


def table() -> str:
    """Markdown: elapsed and processor time of each command, all that it starts included."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for command, place in COMMANDS:
            elapsed, busy = _time(command.format(root=ROOT), Path(folder) / place)
            rows.append((f"`{command.format(root='URL')}`", elapsed, busy))
        rows.append((SHOWN, _open(Path(folder) / "sigmafmu" / "Pendulum.html"), None))
    total = sum(elapsed for _, elapsed, _ in rows)
    busy = sum(busy or 0.0 for _, _, busy in rows)
    lines = ["| command | elapsed | processor |", "|---|---|---|"]
    lines += [f"| {what} | {_s(elapsed)} | {_s(busy)} |" for what, elapsed, busy in (*rows, ("all", total, busy))]
    return "\n".join(lines) + "\n"


def _time(command: str, folder: Path) -> tuple[float, float]:
    environment = {name: value for name, value in os.environ.items() if name != "VIRTUAL_ENV" and "MAKE" not in name}
    before, began = os.times(), time.perf_counter()
    subprocess.run(command.split(), cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
    after = os.times()
    busy = after.children_user + after.children_system - before.children_user - before.children_system
    return time.perf_counter() - began, busy


def _open(page: Path) -> float:
    browser = Browser()
    try:
        began = time.perf_counter()
        browser.open(page)
        browser.wait("return sigmafmu.state.time > 0")
        return time.perf_counter() - began
    finally:
        browser.driver.quit()


def _s(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds:.1f} s" if seconds < 10 else f"{seconds:.0f} s"
