"""docs/elements.md is what the loader's table, the comments in C++ and the FMUs say."""

from pathlib import Path

import pytest

from research.elements import catalogue, examples
from research.elements.examples import ACTING

PAGE = Path(__file__).parents[2] / "docs" / "elements.md"
COMMAND = "python -m research catalogue"


def test_the_page_is_up_to_date():
    assert PAGE.read_text(encoding="utf-8") == catalogue.text(), COMMAND


def test_every_element_has_a_figure():
    figures = {path.stem for path in (PAGE.parent / "elements").glob("*.png")}
    assert figures == {element.id for element in examples.elements()}, COMMAND


@pytest.mark.parametrize("element", examples.elements(), ids=lambda element: element.id)
def test_every_element_has_a_law_and_a_source(element):
    law = catalogue.law_of(element)
    assert "".join(law.lines).strip()
    assert law.files


def test_what_an_element_adds_to_an_fmu():
    spring = next(element for element in examples.elements() if element.name == "line_spring")
    rows = {row[0]: row[1:3] for row in catalogue.new_variables(spring)}
    assert rows["force"] == ("N", "output")
    assert rows["actuatorForce"] == ("N", "input")
    assert rows["stiffness"] == ("N/m", "tunable parameter")
    bushing = next(element for element in examples.elements() if element.name == "bushing")
    assert ("torque[1..3]", "N m", "output") in [row[:3] for row in catalogue.new_variables(bushing)]


def test_a_figure_is_drawn_again(tmp_path):
    for section, name in (("joints", "revolute"), (ACTING, "joint_springs")):
        (element,) = (e for e in examples.elements() if (e.section, e.name) == (section, name))
        catalogue.figure(element, tmp_path / "figure.png")
        assert (tmp_path / "figure.png").stat().st_size > 1000
