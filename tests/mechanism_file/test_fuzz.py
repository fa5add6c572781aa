"""Whatever a file holds, the loader returns a mechanism or raises its own error."""

import json
from copy import deepcopy
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from sigmafmu.mechanism_file.load import load, load_text
from sigmafmu.mechanism_file.problems import MechanismFileError
from sigmafmu.mechanism_file.structures import ByType, Struct
from sigmafmu.mechanism_file.table.forces import FORCE_TYPES
from sigmafmu.mechanism_file.table.joints import JOINT_TYPES
from sigmafmu.mechanism_file.table.mechanism import MECHANISM

from .helpers import LIBRARY

TEXTS = {name: (LIBRARY / f"{name}.yaml").read_text(encoding="utf-8") for name in ("SliderCrank", "HighSpeedRotor")}

CONTENTS = {name: yaml.safe_load(text) for name, text in TEXTS.items()}


def fuzz(examples, **strategies):
    """The same examples in every run."""

    def decorate(test):
        return settings(max_examples=examples, derandomize=True, deadline=None, database=None)(
            given(**strategies)(test)
        )

    return decorate


def load_or_refuse(text: str) -> None:
    try:
        load_text(text, LIBRARY / "fuzz.yaml")
    except MechanismFileError as error:
        for line in str(error).splitlines():
            place, number, rest = line.removeprefix(str(LIBRARY)).split(":", 2)
            assert place == "/fuzz.yaml"
            assert int(number) >= 1
            assert rest.strip()


def words() -> list[str]:
    """Every key and word that means something."""
    found, seen = (
        set(JOINT_TYPES) | set(FORCE_TYPES) | {"ground", "auto", "rate", "a", "b"},
        [MECHANISM],
    )
    while seen:
        kind = seen.pop()
        for part in ("of", "plain", "mapping"):
            if hasattr(kind, part):
                seen.append(getattr(kind, part))
        if isinstance(kind, ByType):
            seen += kind.types.values()
        if isinstance(kind, Struct):
            found |= {key.name for key in kind.keys}
            seen += [key.kind for key in kind.keys]
    return sorted(found)


WORDS = words()
scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.sampled_from(WORDS),
    st.sampled_from(["30 deg", "1 m", "2 kg", "5 Hz", "1e3 kN/m", "nan m", "-1 mm", "../x.json", "#123456"]),
    st.text(max_size=8),
)
values = st.recursive(
    scalars,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.sampled_from(WORDS) | st.text(max_size=4), inner, max_size=4)
    ),
    max_leaves=20,
)
paths = st.lists(st.integers(0, 50), min_size=1, max_size=6)


def changed(content, path, value):
    """The content with something on the path replaced; the path says which entry in every level."""
    place = content
    for step in path:
        keys = list(place) if isinstance(place, dict) else range(len(place))
        if not keys:
            break
        key = list(keys)[step % len(keys)]
        inner = place[key]
        if not isinstance(inner, dict | list) or step == path[-1]:
            place[key] = value
            return content
        place = inner
    return content


@fuzz(300, text=st.text(max_size=80))
def test_any_text(text):
    load_or_refuse(text)


@fuzz(300, content=st.dictionaries(st.sampled_from([key.name for key in MECHANISM.keys]), values))
def test_any_values_of_its_keys(content):
    load_or_refuse(json.dumps(content))


@fuzz(400, model=st.sampled_from(sorted(TEXTS)), path=paths, value=values)
def test_a_good_file_with_something_else_in_it(model, path, value):
    load_or_refuse(yaml.safe_dump(changed(deepcopy(CONTENTS[model]), path, value), allow_unicode=True))


@fuzz(300, model=st.sampled_from(sorted(TEXTS)), at=st.floats(0, 1), cut=st.integers(0, 30), piece=st.text(max_size=6))
def test_a_good_file_with_its_text_changed(model, at, cut, piece):
    text = TEXTS[model]
    i = int(at * len(text))
    load_or_refuse(text[:i] + piece + text[i + cut :])


@fuzz(100, content=st.binary(max_size=60))
def test_any_bytes(content):
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bytes.yaml"
        path.write_bytes(content)
        with pytest.raises(MechanismFileError):
            load(path)
