"""Parts of docs/ as HTML, so that a fact is told once, there.

Links to other files of docs/ become plain text: they are not in an FMU.
"""

import re

from markdown_it import MarkdownIt
from markdown_it.token import Token

_PARSER = MarkdownIt("commonmark", {"html": False}).enable("table")


def section(text: str, title: str) -> str | None:
    """The lines below `## title` up to the next heading of this level; None if there is no such heading."""
    found = re.search(rf"^## {re.escape(title)}\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    return found.group(1) if found else None


def preamble(text: str) -> str:
    """The lines between the title and the first section."""
    return re.sub(r"\A# .*\n", "", text).partition("\n## ")[0]


def html(text: str) -> str:
    """HTML of Markdown; headings go one level down, below those of the page."""
    tokens = _PARSER.parse(text)
    for token in tokens:
        if token.type.startswith("heading_"):
            token.tag = f"h{int(token.tag[1:]) + 1}"
        if token.children:
            token.children = _without_local_links(token.children)
    return _PARSER.renderer.render(tokens, _PARSER.options, {})


def _without_local_links(tokens: list[Token]) -> list[Token]:
    kept: list[Token] = []
    local = False
    for token in tokens:
        if token.type == "link_open":
            local = not str(token.attrs["href"]).startswith("http")
        if not (local and token.type in {"link_open", "link_close"}):
            kept.append(token)
    return kept
