"""docs/study keeps the figures that pages show and the tables that sentences are compared with; no more."""

import re
from pathlib import Path

from .pages import PAGES, ROOT, read

STUDY = ROOT / "docs" / "study"
READERS = [Path(__file__).with_name("test_numbers.py"), ROOT / "tests" / "study" / "test_convergence_figures.py"]


def test_every_figure_is_shown():
    shown = {Path(image).name for page in PAGES for image in re.findall(r"\]\((?:docs/)?study/([^)]+)\)", read(page))}
    assert {path.name for path in STUDY.glob("*.png")} == shown


def test_every_table_is_read():
    """Names end with the mechanism, if they have one."""
    names = {re.sub(r"_[A-Z]\w+$", "", path.stem) for path in STUDY.glob("*.csv")}
    text = "".join(map(read, READERS))
    assert {name for name in names if name not in text} == set()


def test_there_is_nothing_else():
    assert {path.suffix for path in STUDY.iterdir()} == {".csv", ".png"}
