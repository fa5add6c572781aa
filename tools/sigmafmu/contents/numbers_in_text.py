"""Keeps a number and its unit on one line of an HTML page."""

import re

_UNIT = r"(?:[µmk]?m|k?g|m?s|[MG]?Pa|k?N|J|W|Hz|deg|rpm|rad|turns?|[MG]B|%|steps?|iterations?)"
_UNITS = rf"{_UNIT}(?:[²³⁴]|[/ ]{_UNIT}[²³⁴]?)*(?![\w-])"
_NUMBER = r"[−-]?\d+(?:\.\d+)?(?: \d{3})*(?:e[−-]?\d+)?"
_FOUND = re.compile(rf"(?<![\w.]){_NUMBER}(?: (?:{_UNITS}|1/s))?(?![\w])")
_BREAKABLE = re.compile(r"[ −-]")
_AS_IT_IS = {"pre", "code", "style", "title"}
_TAG = re.compile(r"(<[^>]+>)")


def keep_together(html: str) -> str:
    """`html` with a span around every number in its text that a line could break at; code stays as it is."""
    parts, inside = [], 0
    for part in _TAG.split(html):
        if part.startswith("<"):
            name = part.strip("</>").split()[0] if part.strip("</>") else ""
            inside += (name in _AS_IT_IS) * (-1 if part.startswith("</") else 1)
            parts.append(part)
        else:
            parts.append(part if inside else _FOUND.sub(_span, part))
    return "".join(parts)


def _span(match: re.Match[str]) -> str:
    found = match[0]
    return f'<span class="nb">{found}</span>' if _BREAKABLE.search(found) else found
