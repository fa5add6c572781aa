"""The tables of docs/mechanism-file.md, made of the loader's table.

    python -m sigmafmu.mechanism_file.reference docs/mechanism-file.md

writes them anew, below the line that begins them.
"""

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from sigmafmu.mechanism_file.structures import Key, Struct
from sigmafmu.mechanism_file.table import bodies, ends, forces, joints, mechanism, outputs, prescribed, tendons

BEGIN = "<!-- Made of the loader's table: python -m sigmafmu.mechanism_file.reference docs/mechanism-file.md -->"
ALWAYS = ("type", "bodies", "frame1", "frame2")
"""Keys that every joint or force has."""


def tables() -> str:
    """All of them, as Markdown."""
    return "\n".join(_sections()) + "\n"


def write(page: Path) -> None:
    """Put them into the page."""
    text = page.read_text(encoding="utf-8")
    page.write_text(text[: text.index(BEGIN)] + BEGIN + "\n\n" + tables(), encoding="utf-8")


def _sections() -> Iterator[str]:
    yield from _section("The file", mechanism.MECHANISM.keys)
    yield from _section("`bodies`: NAME: …", bodies.BODY_KEYS.keys)
    yield from _section("Inertia as a mapping", bodies.INERTIA.keys)
    yield from _section("Orientations: one of", ends.ORIENTATION.keys)
    yield from _section("`flexible` as a mapping", bodies.FLEXIBLE.keys)
    yield from _section("`shapes`: a list of", bodies.SHAPE.keys)
    yield from _joints()
    yield from _forces()
    yield from _section("`loads`: NAME: …", forces.LOAD.keys)
    yield from _section("`tendons`: NAME: …", tendons.TENDON.keys)
    for name, coupling in prescribed.COUPLINGS.types.items():
        yield from _section(f"`couplings`: `{name}`: {prescribed.COUPLING_TYPES[name].meaning}", coupling.keys[1:])
    yield from _section("`drives`: JOINT: …", prescribed.DRIVE.keys)
    yield from _section("`motions`: NAME: …", prescribed.MOTION.keys)
    yield from _section("`stations`: NAME: …", outputs.STATION.keys)
    for name, sensor in outputs.SENSORS.types.items():
        yield from _section(f"`sensors`: `{name}`: {outputs.SENSOR_TYPES[name].meaning}", sensor.keys[1:])
    yield from _section("`expose` as a mapping", mechanism.EXPOSE.keys)
    yield from _section("`experiment`", mechanism.EXPERIMENT.keys)


def _section(title: str, keys: Iterable[Key]) -> Iterator[str]:
    yield f"### {title}\n"
    yield from _table(keys)


def _table(keys: Iterable[Key]) -> Iterator[str]:
    yield "| key | value | meaning | default |"
    yield "|---|---|---|---|"
    for key in keys:
        default = "required" if key.required else key.default
        yield f"| `{key.name}` | {key.kind.text} | {key.meaning} | {default} |".replace("|  |", "| |")
    yield ""


def _joints() -> Iterator[str]:
    yield "### `joints`: NAME: …\n"
    common = next(iter(joints.JOINTS.types.values()))
    yield from _table(key for key in common.keys if key.name in ALWAYS)
    yield "| type | what it does | in W | coordinates |"
    yield "|---|---|---|---|"
    for name, joint in joints.JOINT_TYPES.items():
        geometry = ", ".join(f"`{key}`" for key in dict.fromkeys(key for end in joint.ends for key in end.in_w))
        free = ", ".join(c.word for c in joint.coordinates)
        yield f"| `{name}` | {joint.meaning} | {geometry} | {free} |".replace("|  |", "| |")
    yield ""
    used = {key for joint in joints.JOINT_TYPES.values() for end in joint.ends for key in end.in_w}
    yield from _section("Geometry of joints in W", (key for name, key in ends.IN_W.items() if name in used))
    yield from _section("`reaction` of a joint", joints.REACTION.keys)
    yield from _section("On coordinates of joints", _different(map(_on_coordinates, joints.JOINTS.types.values())))


def _on_coordinates(joint: Struct) -> list[Key]:
    return [key for key in joint.keys if key.name not in ends.IN_W and key.name not in ALWAYS]


def _different(groups: Iterable[Iterable[Key]]) -> list[Key]:
    """Every key once; of those of one name for angles and for displacements, both."""
    seen: dict[tuple[str, str], Key] = {}
    for group in groups:
        for key in group:
            seen.setdefault((key.name, key.kind.text), key)
    return sorted(seen.values(), key=lambda key: list(dict.fromkeys(name for name, _ in seen)).index(key.name))


def _forces() -> Iterator[str]:
    for name, force in forces.FORCES.types.items():
        yield from _section(f"`forces`: `{name}`: {forces.FORCE_TYPES[name].meaning}", force.keys[1:])


if __name__ == "__main__":
    write(Path(sys.argv[1]))
