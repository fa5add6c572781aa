"""Choosing inputs, outputs and coordinates by name."""

import difflib
from collections.abc import Iterable, Sequence

from sigmafmu import SigmafmuError
from sigmafmu.variables import pattern, vectors


def choose(names: Sequence[str], wanted: Iterable[str], kind: str, model: str) -> list[int]:
    """Indices of the `names` that `wanted` means: one name, vector or pattern with `*` and `?`, or several."""
    wanted = [wanted] if isinstance(wanted, str) else wanted
    chosen: dict[int, None] = {}  # an ordered set
    for text in wanted:
        matches = [i for i, name in enumerate(names) if pattern(text).fullmatch(name)]
        if not matches:
            raise SigmafmuError(f"{model} has no {kind} '{text}'; {_hint(names, text)}")
        chosen |= dict.fromkeys(matches)
    return list(chosen)


def _hint(names: Sequence[str], text: str) -> str:
    bases = sorted(vectors(names))
    close = difflib.get_close_matches(text, bases, n=3)
    if close:
        return f"did you mean {' or '.join(close)}?"
    return f"there are {', '.join(bases[:12])}{' and more' if len(bases) > 12 else ''}"
