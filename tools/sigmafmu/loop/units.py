"""What SI units consist of, for FMI's BaseUnit."""

import re
from collections import Counter

ATOMS = {
    "1": {},
    "kg": {"kg": 1},
    "m": {"m": 1},
    "s": {"s": 1},
    "A": {"A": 1},
    "K": {"K": 1},
    "rad": {"rad": 1},
    "Hz": {"s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
}
_FACTOR = re.compile(r"(?P<atom>1|[A-Za-z]+)(?P<power>\d*)")


def exponents(unit: str) -> dict[str, int] | None:
    """Exponents of the base units of `N.m.s/rad`, `kg.m2` and the like; None for a unit that is not known here."""
    result: Counter[str] = Counter()
    numerator, *denominators = unit.split("/")
    for side, sign in ((numerator, 1), *((d, -1) for d in denominators)):
        for factor in side.split("."):
            match = _FACTOR.fullmatch(factor)
            if not match or match["atom"] not in ATOMS:
                return None
            for si, exponent in ATOMS[match["atom"]].items():
                result[si] += sign * exponent * int(match["power"] or 1)
    return {si: exponent for si, exponent in result.items() if exponent}
