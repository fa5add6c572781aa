"""What to install when a command needs a package that is not there."""

EXTRAS = {"scipy": "loop", "pythonfmu": "loop", "lxml": "loop", "mujoco": "mjcf"}
"""Package → extra that brings it."""
EXTRA_OF_COMMAND = {"modes": "modes"}
"""Commands that have an extra of their own."""


def missing(package: str, command: str = "") -> str:
    """A sentence about the absent `package`, and how `command` gets it; empty if no extra brings it."""
    name = package.partition(".")[0]
    if name not in EXTRAS:
        return ""
    extra = EXTRA_OF_COMMAND.get(command, EXTRAS[name])
    return f"{name} is not installed; in the folder of sigmafmu's sources, pip install '.[{extra}]' brings it"
