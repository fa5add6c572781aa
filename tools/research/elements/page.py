"""The page of comparisons."""

from collections.abc import Callable, Iterator
from textwrap import fill
from typing import Any

from research.bench import machine
from research.elements import Case, compare, forces, joints, robot, sensors
from sigmafmu.markdown import markdown_table
from sigmafmu.mechanism_file.table import coordinates, outputs, prescribed
from sigmafmu.mechanism_file.table import forces as force_table
from sigmafmu.mechanism_file.table import joints as joint_table

CASES: tuple[Case, ...] = (*joints.CASES, *forces.CASES)
OTHER_LAWS = {
    "fixed": "holds everything: nothing to compare",
    "free": "holds nothing",
    "cloud_contact": "a plane contact at each point; MuJoCo's contacts are soft constraints of another law",
    "rack_and_pinion": "a gear with other units",
    "differential": "a sum of three terms; codes in joint coordinates tie two",
    "sum": "codes in joint coordinates tie two",
}
"""What is compared with nothing → why."""


def all_elements() -> list[str]:
    """Types of joints, forces, couplings, sensors and of what acts on coordinates."""
    acting = coordinates.ACTING
    return [
        *joint_table.JOINT_TYPES,
        *acting,
        "motor",
        *prescribed.COUPLING_TYPES,
        *force_table.FORCE_TYPES,
        "load",
        *outputs.SENSOR_TYPES,
    ]


def compared() -> set[str]:
    """Elements that a case has."""
    return {case.element.partition(",")[0] for case in CASES} | {sensor for sensor, _ in sensors.THERE}


def not_compared() -> dict[str, str]:
    """Elements that no case has, and why where that is known."""
    return {name: OTHER_LAWS.get(name, "") for name in all_elements() if name not in compared()}


def page(tell: Callable[[str], None]) -> str:
    """All of it, measured now; takes half a minute."""
    return "\n\n".join(_parts(tell)) + "\n"


def _parts(tell: Callable[[str], None]) -> Iterator[str]:
    yield "# Elements beside other codes"
    yield _filled(
        """Written by `python -m research elements`: each element in a small mechanism with the same numbers in Exudyn
        and in MuJoCo, where these have it. Compared is a point of the last body after 0.4 s: with their step h, with
        h/2, and extrapolated to h = 0, with our result by `rkmk4` at h/4. Exudyn runs Newmark's method of order 2,
        MuJoCo its Runge-Kutta method of order 4. [Which code for what](compare.md) is about whole codes and
        mechanisms."""
    )
    yield _filled(f"{machine()}.")
    tell("robot arms beside Pinocchio and MuJoCo")
    yield "## Robot arms"
    yield _robot({name: robot.accelerations(name) for name in robot.ARMS}, robot.trajectory())
    yield "## Elements"
    rows = []
    for case in CASES:
        tell(case.element)
        rows += compare(case)
    yield _table(rows).rstrip()
    yield _notes(rows)
    yield "## Sensors"
    yield _filled(
        "On the second link of an arm that moves on two hinges; `motion` is seen from a frame of the first. Values "
        "are compared at one instant."
    )
    yield _sensors(sensors.compare()).rstrip()
    yield "## Not compared"
    yield "\n".join(f"- `{name}`: {why}" if why else f"- `{name}`" for name, why in not_compared().items())


def _robot(accelerations: dict[str, float], ends: dict[str, float]) -> str:
    first = f"""
        Arms of example-robot-data on hinges, with the damping and friction of their files or, where these have none,
        {robot.RESISTANCE[0]:g} N m s/rad and {robot.RESISTANCE[1]:g} N m, armatures from {robot.ARMATURES[0]:g} down to
        {robot.ARMATURES[1]:g} kg m², and motor torques. At {robot.STATES} random states our accelerations of the joints
        differ from those of Pinocchio's articulated-body algorithm by the given part of the largest at most. Pinocchio
        takes armatures into account by itself; damping and friction, tanh(rate / {robot.CREEP:g} rad/s) times its
        full value, are torques that its user gives it, and `joint_frictions` of ours."""
    table = markdown_table(
        ("arm", *(f"`{name}`" for name in accelerations)),
        [("difference", *(f"{value:.0e}" for value in accelerations.values()))],
    )
    second = f"""
        After a fall of {robot.STOP:g} s a point of the last link of `{robot.ARMS[0]}` is {ends["rkmk4"]:.0e} m
        from MuJoCo's converged result with `rkmk4`, and {ends["coarse"]:.1e} m and {ends["fine"]:.1e} m with the
        default method at h = 1 ms and 0.5 ms: order 2. MuJoCo had our law of friction as a passive force there. Its
        own, `frictionloss`, ends {ends["own friction"]:.0e} m away: it has full friction at any rate, and holds what
        stands still by a soft constraint. Ours that creeps at {robot.SHARP:g} in place of {robot.CREEP:g} rad/s is
        {ends["sharp friction"]:.1e} m from that."""
    return f"{_filled(first)}\n\n{table}\n{_filled(second)}"


def _filled(text: str) -> str:
    return fill(" ".join(text.split()), 120, break_on_hyphens=False)


def _table(rows: list[dict[str, Any]]) -> str:
    marks = {note: i + 1 for i, note in enumerate(dict.fromkeys(row["note"] for row in rows if row["note"]))}
    return markdown_table(
        ("element", "code", "there", "h [s]", "with h [m]", "with h/2 [m]", "h = 0 [m]"),
        [
            [
                _quoted(row["element"]),
                row["code"],
                row["there"] + (f" ({marks[row['note']]})" if row["note"] else ""),
                f"{row['h']:g}",
                *(f"{row[key]:.1e}" for key in ("coarse", "fine", "limit")),
            ]
            for row in rows
        ],
    )


def _sensors(rows: list[dict[str, Any]]) -> str:
    return markdown_table(
        ("sensor", "output", "MuJoCo", "largest component", "difference"),
        [
            [
                f"`{row['sensor']}`",
                f"`{row['output']}`",
                row["there"],
                f"{row['size']:.2g}",
                f"{row['difference']:.0e}",
            ]
            for row in rows
        ],
    )


def _quoted(element: str) -> str:
    name, comma, more = element.partition(",")
    return f"`{name}`{comma}{more}"


def _notes(rows: list[dict[str, Any]]) -> str:
    notes = dict.fromkeys(row["note"] for row in rows if row["note"])
    return "\n".join(fill(f"{i}. {note}", 120, subsequent_indent="   ") for i, note in enumerate(notes, 1))
