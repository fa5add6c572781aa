"""Choosing inputs, outputs and coordinates by name."""

import difflib
import re
from collections.abc import Iterable, Sequence

from sigmafmu import SigmafmuError
from sigmafmu.variables import split_element


def choose(names: Sequence[str], wanted: Iterable[str], kind: str, model: str) -> list[int]:
    """Indices of the `names` that `wanted` means: one name, vector or pattern with `*` and `?`, or several."""
    wanted = [wanted] if isinstance(wanted, str) else wanted
    chosen: dict[int, None] = {}  # an ordered set
    for pattern in wanted:
        regex = re.compile(re.escape(pattern).replace(r"\*", ".*").replace(r"\?", ".") + r"(\[\d+\])?")
        matches = [i for i, name in enumerate(names) if regex.fullmatch(name)]
        if not matches:
            raise SigmafmuError(f"{model} has no {kind} '{pattern}'; {_hint(names, pattern)}")
        chosen |= dict.fromkeys(matches)
    return list(chosen)


def _hint(names: Sequence[str], pattern: str) -> str:
    bases = sorted({element[0] if (element := split_element(name)) else name for name in names})
    close = difflib.get_close_matches(pattern, bases, n=3)
    if close:
        return f"did you mean {' or '.join(close)}?"
    return f"there are {', '.join(bases[:12])}{' and more' if len(bases) > 12 else ''}"
