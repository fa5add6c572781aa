"""The command `sigmafmu` in this process, for the tests of its commands."""

import shlex

from typer.testing import CliRunner, Result

from sigmafmu.cli import app


def run(command: str) -> Result:
    """What follows `sigmafmu`, as a shell splits it."""
    return CliRunner().invoke(app, shlex.split(command), catch_exceptions=False)


def succeed(command: str) -> str:
    """What it prints."""
    result = run(command)
    assert result.exit_code == 0, result.output
    return result.stdout


def fail(command: str) -> str:
    """The single line that tells what is wrong."""
    result = run(command)
    assert result.exit_code == 1, result.output
    lines = [line for line in result.stderr.splitlines() if line.startswith("Error: ")]
    assert len(lines) == 1, result.output
    assert "Traceback" not in result.output
    return lines[0]
