"""The published schema is that of the loader's table, and agrees with what the loader accepts."""

from pathlib import Path

import jsonschema
import pytest
import yaml

import sigmafmu
from sigmafmu.mechanism_file import reference, schema
from sigmafmu.mechanism_file.units import DIMENSIONS, example

from .helpers import BALL, HEAD, LIBRARY, ROOT

PUBLISHED = "tools/sigmafmu/mechanism_file/schema.json"
VALIDATOR = jsonschema.Draft202012Validator(schema.schema())


def is_valid(text: str) -> bool:
    return VALIDATOR.is_valid(yaml.safe_load(text))


def test_the_published_file_is_made_of_the_table():
    assert (ROOT / PUBLISHED).read_text(encoding="utf-8") == schema.text(), (
        f"python -m sigmafmu.mechanism_file.schema > {PUBLISHED}"
    )
    installed = Path(sigmafmu.__file__).parent / "mechanism_file" / "schema.json"
    assert installed.read_text(encoding="utf-8") == schema.text()


def test_it_is_a_schema():
    jsonschema.Draft202012Validator.check_schema(schema.schema())


@pytest.mark.parametrize("path", sorted(LIBRARY.glob("*.yaml")), ids=lambda path: path.stem)
def test_the_library_is_valid(path):
    # PyYAML's own scalars are those of YAML 1.1; the library writes numbers so that both are the same
    assert list(VALIDATOR.iter_errors(yaml.safe_load(path.read_text(encoding="utf-8")))) == []


@pytest.mark.parametrize("dimension", [d for d in DIMENSIONS if d != "number"])
def test_texts_with_units_are_valid(dimension):
    validator = jsonschema.Draft202012Validator({"$ref": f"#/$defs/{dimension.replace(' ', '_')}", **defs()})
    assert validator.is_valid(example(dimension))
    assert validator.is_valid(-1.5)
    assert not validator.is_valid("5")
    assert not validator.is_valid("heavy")


def defs():
    return {"$defs": schema.schema()["$defs"]}


GOOD = HEAD + f"bodies: {{a: {BALL}}}\n"


@pytest.mark.parametrize(
    "text",
    [
        GOOD.replace("sigmafmu: 1", "sigmafmu: 2"),
        GOOD.replace("name: Some", "name: 9x"),
        GOOD.replace("mass:", "mas:"),
        GOOD.replace("mass: 2", "mass: 0"),
        GOOD.replace("mass: 2", "mass: heavy"),
        GOOD.replace("mass: 2", "mass: true"),
        GOOD.replace("inertia: [1, 2, 2.5]", "inertia: [1, 2]"),
        GOOD.replace("{a:", "{a b:"),
        GOOD + "gravty: [0, 0, 0]",
        GOOD + "joints: {j: {type: ball, bodies: [ground, a]}}",
        GOOD + "joints: {j: {bodies: [ground, a]}}",
        GOOD + "joints: {j: {type: spherical, bodies: [a], point: [0, 0, 0]}}",
        GOOD + "joints: {j: {type: spherical, bodies: [ground, a], point: [0, 0, 0], axis: [0, 0, 1]}}",
        GOOD + "joints: {j: {type: revolute, bodies: [ground, a], point: [0, 0, 0], axis: [0, 0, 0]}}",
        GOOD + "expose: some",
        GOOD + "experiment: {stop_time: 0}",
    ],
)
def test_what_a_schema_can_see_is_invalid(text):
    assert is_valid(GOOD)
    assert not is_valid(text)


def test_empty_sections_are_valid():
    assert is_valid(GOOD + "joints:\nforces:\n")


def test_the_tables_of_the_page_are_made_of_the_table():
    page = (ROOT / "docs" / "mechanism-file.md").read_text(encoding="utf-8")
    _, below = page.split(reference.BEGIN + "\n\n")
    assert below == reference.tables(), "python -m sigmafmu.mechanism_file.reference docs/mechanism-file.md"
