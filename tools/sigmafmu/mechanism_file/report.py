"""What `sigmafmu check` tells about a mechanism that can start."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from sigmafmu import native
from sigmafmu.mechanism_file.definition import Json
from sigmafmu.mechanism_file.load import MechanismFile, folder_of

COUNTED = ("bodies", "joints", "forces", "loads", "tendons", "couplings", "drives", "sensors")
SHOWN = 20
"""Bodies that are listed; of more, the number."""


def report(file: MechanismFile) -> Iterator[str]:
    """Lines of text."""
    content = file.definition
    with folder_of(file.resources) as folder:
        told = native.freedom(file.text, folder)
    counts = ((key, len(content.get(key, ()))) for key in COUNTED)
    yield f"{content['name']}: " + ", ".join(f"{n} {key if n > 1 else _one(key)}" for key, n in counts if n)
    yield f"degrees of freedom: {told['freedom']}"
    constraints = _constraints(file)
    for group in told["groups"]:
        names = ", ".join(constraints[i] for i in group["joints"])
        yield f"redundant: {group['dependent']} of the {group['equations']} equations of {names} follow from the others"
    yield _masses(dict(zip(_names(content["bodies"]), told["masses"], strict=True)))
    for body, joint in file.placed_by.items():
        yield f"placed: {body} by {joint}"
    yield from _moves(file)
    yield from _unheld(file)


def _constraints(file: MechanismFile) -> list[str]:
    """Names of constraints in the core's order."""
    content = file.definition
    drives = [f"the drive of {drive['joint']}" for drive in content.get("drives", ())]
    return [*_names(content["joints"]), *drives, *_names(content.get("couplings", ()))]


def _names(elements: Iterable[Json]) -> list[str]:
    return [element["name"] for element in elements]


def _one(key: str) -> str:
    return {"bodies": "body"}.get(key, key.removesuffix("s"))


def _masses(masses: Mapping[str, float]) -> str:
    listed = ", ".join(f"{name} {mass:.6g}" for name, mass in list(masses.items())[:SHOWN])
    more = f" and {len(masses) - SHOWN} more" if len(masses) > SHOWN else ""
    return f"masses [kg]: {listed}{more}; together {sum(masses.values()):.6g}"


def _moves(file: MechanismFile) -> Iterator[str]:
    """What gave way when the mechanism was assembled."""
    if not file.moves:
        yield "assembled: nothing had to move"
    for move in file.moves[:SHOWN]:
        way = _amounts((move.position, "m"), (np.degrees(move.turn), "deg"))
        change = _amounts((move.velocity, "m/s"), (move.angular_velocity, "rad/s"))
        parts = [f"moved by {way}"] * bool(way) + [f"got another velocity, by {change}"] * bool(change)
        yield f"assembled: {move.body} {' and '.join(parts)}"
    if len(file.moves) > SHOWN:
        yield f"assembled: {len(file.moves) - SHOWN} more bodies moved"


def _amounts(*values: tuple[float, str]) -> str:
    return ", ".join(f"{value:.4g} {unit}" for value, unit in values if value)


def _unheld(file: MechanismFile) -> Iterator[str]:
    """Bodies that no joint and no force ties to anything: no error, but seldom meant."""
    content = file.definition
    tied = {
        body for key in ("joints", "forces") for element in content.get(key, ()) for body in element.get("bodies", ())
    }
    free = [name for name in _names(content["bodies"]) if name not in tied]
    if free:
        falls = "falls" if any(content["gravity"]) else "moves on"
        yield f"information: nothing holds {', '.join(free[:SHOWN])}, which {falls} freely"
