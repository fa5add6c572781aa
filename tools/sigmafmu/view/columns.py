"""Which variables of a result go into an animation, and which its plots show at first."""

from collections.abc import Iterable

from sigmafmu.contents.layout import Layout
from sigmafmu.variables import pattern

COORDINATES = ("angle", "displacement")
ENERGIES = ("energy.kinetic", "energy.potential", "energy.total")
SHOWN = 6
"""So many curves at most are shown at first in a plot."""
MOST = 600
"""Columns at most; what is plotted at first comes first, then what arrows need."""


def coordinates(available: Iterable[str], layout: Layout) -> list[str]:
    """Coordinates of joints: `J.angle`, `J.angle1`, `J.displacement`, …"""
    joints = {link.name for link in layout.joints}
    return [
        name
        for name in available
        if name.rpartition(".")[0] in joints and name.rpartition(".")[2].rstrip("0123456789") in COORDINATES
    ]


def chosen(available: list[str], layout: Layout, patterns: Iterable[str] = ()) -> list[str]:
    """Scalars to show in plots and arrows: those of `patterns`, coordinates, energies, forces, modal coordinates."""
    known = set(available)
    wanted = _named(available, patterns)
    wanted += coordinates(available, layout) + [name for name in ENERGIES if name in known]
    links = {link.name for link in (*layout.joints, *layout.forces)}
    vectors = ("reactionForce", "reactionTorque", "force", "torque")
    for name in available:
        owner, _, rest = name.rpartition(".")
        kind, bracket, _ = rest.partition("[")
        flexible = owner in layout.bodies and kind == "modal"
        alone = len(layout.bodies) == 1 and owner in layout.bodies and kind == "position"
        if bracket and ((owner in links and kind in vectors) or flexible or alone):
            wanted.append(name)
    return list(dict.fromkeys(wanted))[:MOST]


def _named(names: list[str], patterns: Iterable[str]) -> list[str]:
    """Scalars that patterns, vectors or scalars name."""
    return [name for text in patterns for name in names if pattern(text).fullmatch(name)]


def plotted(columns: list[str], layout: Layout, patterns: Iterable[str] = ()) -> list[str]:
    """Of these, what is plotted at first: what was asked for, else coordinates (or what moves) and energies."""
    if asked := _named(columns, patterns):
        return asked
    found = [[name for name in columns if kind in name] for kind in (".modal[", ".position[")]
    moving = coordinates(columns, layout) or found[0] or found[1]
    return moving[:SHOWN] + [name for name in columns if name in ENERGIES]
