"""Whatever a description holds, it is converted or refused with one sentence, and what is written can be read."""

import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sigmafmu.importers.convert import convert
from sigmafmu.importers.robot import DescriptionError
from sigmafmu.mechanism_file.load import load_text
from sigmafmu.mechanism_file.problems import FileError

from .test_sdf import BARS, sdf
from .test_urdf import ARM

TEXTS = {"urdf": ARM, "sdf": sdf(*BARS)}
WORDS = ["0", "-1", "1e300", "1e-300", "nan", "1 2", "0 0 0", "a", "b", "world", "fixed", "planar", "mimic", "é", ""]
VALUE = re.compile(r'(?<=")[^"<>=]*(?=")|(?<=>)[^<>\s][^<>]*(?=<)')
"""An attribute's value, or what is between tags."""

same = settings(
    max_examples=80, derandomize=True, deadline=None, database=None, suppress_health_check=list(HealthCheck)
)
every_kind = pytest.mark.parametrize("kind", TEXTS)


def convert_or_refuse(folder, text: str) -> None:
    path = folder / "fuzz.xml"
    path.write_text(text, encoding="utf-8")
    refused, unread = "", ""
    try:
        written, _ = convert(path, folder)
    except DescriptionError as error:
        refused = str(error)
    else:
        try:
            load_text(written, folder / "fuzz.yaml")
        except FileError as error:  # of what only the whole shows
            unread = str(error)
    assert not refused or refused.startswith((f"{path}:", "fuzz.xml: "))
    assert "\n" not in refused
    assert "is no YAML" not in unread
    assert "unknown" not in unread


@every_kind
@same
@given(changes=st.lists(st.tuples(st.floats(0, 1), st.integers(0, 12), st.sampled_from([*WORDS, "<", "/>", '"']))))
def test_a_good_file_with_its_text_changed(tmp_path_factory, kind, changes):
    text = TEXTS[kind]
    for at, cut, piece in changes[:3]:
        i = int(at * len(text))
        text = text[:i] + piece + text[i + cut :]
    convert_or_refuse(tmp_path_factory.getbasetemp(), text)


@every_kind
@same
@given(changes=st.lists(st.tuples(st.floats(0, 0.999), st.sampled_from(WORDS)), min_size=1, max_size=3))
def test_a_good_file_with_other_values(tmp_path_factory, kind, changes):
    text = TEXTS[kind]
    for at, word in changes:
        found = list(VALUE.finditer(text))
        match = found[int(at * len(found))]
        text = text[: match.start()] + word + text[match.end() :]
    convert_or_refuse(tmp_path_factory.getbasetemp(), text)
