"""The mechanisms that tests and benchmarks share, a function each; `python -m research mechanisms` writes their files.

A family has mechanisms of any size: `named("Chain250")`.
"""

import re
from collections.abc import Callable
from pathlib import Path

from research.mechanisms.chains import random_tree, revolute_chain, spherical_chain
from research.mechanisms.free_body import free_body
from research.mechanisms.linkages import bricard, four_bar_row, planar_four_bar
from research.mechanisms.robots import humanoid, revolute_arm7
from sigmafmu import SigmafmuError, _core

MECHANISMS: dict[str, Callable[[], _core.Mechanism]] = {
    "FreeBody": free_body,
    "PlanarFourBar": planar_four_bar,
    "DoubleFourBar": lambda: four_bar_row(2),
    "Bricard": bricard,
    "RevoluteArm7": revolute_arm7,
    "Humanoid": humanoid,
}
FAMILIES: dict[str, Callable[[int], _core.Mechanism]] = {
    "Chain": spherical_chain,
    "RevoluteChain": revolute_chain,
    "RandomTree": random_tree,
    "FourBarRow": four_bar_row,
}
LARGEST = 1000
WRITTEN = (
    *(name for name in MECHANISMS if name != "Humanoid"),
    *(f"{family}{n}" for family in FAMILIES for n in (1, 2, 5, 10, 20, 50, 100, 200, 500, LARGEST)),
)
"""What is written when no names are given."""


def named(name: str) -> _core.Mechanism:
    """A mechanism by its name, that of a family with its size. SigmafmuError: there is none."""
    if name in MECHANISMS:
        return MECHANISMS[name]()
    match = re.fullmatch(r"([A-Za-z]+?)([1-9]\d*)", name)
    if match and match[1] in FAMILIES and int(match[2]) <= LARGEST:
        return FAMILIES[match[1]](int(match[2]))
    families = ", ".join(f"{family}N" for family in FAMILIES)
    raise SigmafmuError(f"no such mechanism: {name}; there are {', '.join(MECHANISMS)}, {families}, N = 1 … {LARGEST}")


def write(names: tuple[str, ...], folder: Path) -> list[Path]:
    """The JSON files of mechanisms."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{name}.json" for name in names]
    for name, path in zip(names, paths, strict=True):
        path.write_text(_core.to_json(named(name)), encoding="utf-8")
    return paths
