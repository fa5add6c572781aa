"""YAML as a tree with lines: what scalars mean, and that nothing large, deep or foreign gets through."""

import json
import math

import pytest

from sigmafmu.mechanism_file.problems import MechanismFileError
from sigmafmu.mechanism_file.tree import DEEPEST, LARGEST_FILE, MOST_NODES, parse, read_text


def plain(node):
    """Values without lines."""
    if isinstance(node.value, dict):
        return {key: plain(child) for key, child in node.value.items()}
    return [plain(child) for child in node.value] if isinstance(node.value, list) else node.value


def refused(text):
    with pytest.raises(MechanismFileError) as error:
        parse(text, "f.yaml")
    return str(error.value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3),  # a text in YAML 1.1
        ("8e5", 8e5),
        ("-.5", -0.5),
        ("+3", 3),
        ("1.", 1.0),
        ("'1'", "1"),
        ('"1"', "1"),
        ("30 deg", "30 deg"),
        ("no", "no"),  # truth values in YAML 1.1
        ("on", "on"),
        ("y", "y"),
        ("true", True),
        ("1_000", "1_000"),
        ("12:30", "12:30"),
        ("0x10", "0x10"),
        ("~", None),
        ("", None),
        (".inf", math.inf),
        ("123456789012345678901234567890", 123456789012345678901234567890.0),
    ],
)
def test_scalars_mean_what_yaml_1_2_says(text, value):
    found = plain(parse(f"[{text}]" if text else "- ", "f.yaml"))
    assert found == [value]
    assert type(found[0]) is type(value)


def test_json_is_yaml():
    text = '{"a": [1, 2.5e-3, "x", null, true], "b": {"c": "30 deg"}}'
    assert plain(parse(text, "f")) == {"a": [1, 2.5e-3, "x", None, True], "b": {"c": "30 deg"}}


def test_what_json_escapes():
    content = {"a": '\U0001f600 \u2028 \u00e9 \n " \\ \\\\ud83d\\ude00 /'}
    assert plain(parse(json.dumps(content), "f")) == content


def test_every_node_knows_its_line():
    root = parse("a: 1\nb:\n  c: [1,\n    2]\n  'd': x\n", "f")
    b = root.value["b"].value
    assert root.key_lines == {"a": 1, "b": 2}
    assert [node.line for node in b["c"].value] == [3, 4]
    assert b["d"].line == 5


def test_aliases_are_what_they_stand_for():
    root = parse("a: &x [1, 2]\nb: *x\nc: {d: *x}\n", "f")
    assert plain(root) == {"a": [1, 2], "b": [1, 2], "c": {"d": [1, 2]}}


def test_a_bomb_of_aliases_is_refused_at_once():
    lines = ["a0: &a0 [0, 0, 0, 0, 0, 0, 0, 0, 0, 0]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 30)]
    assert f"more than {MOST_NODES} values" in refused("\n".join(lines))


@pytest.mark.parametrize(
    ("text", "line", "what"),
    [
        ("a: 1\na: 2", 2, 'the key "a" is there twice, first in line 1'),
        ("a: &x [*x]", 1, "*x refers to itself"),
        ("a: *x", 1, "has no anchor before it"),
        ("a: 1\n---\nb: 2", 2, "a second document"),
        ("a: !!python/object:os.system x", 1, "the tag"),
        ("? [1, 2]\n: 3", 1, "a list is a key"),
        ("a: [1, 2", 1, "is no YAML"),
        ("a: 1\n\tb: 2", 2, "is no YAML"),
        ("a: \x00", 1, "is no YAML"),
        ("[" * 60, 1, f"nested deeper than {DEEPEST}"),
        ("[" * 100_000, 1, f"nested deeper than {DEEPEST}"),
        ("\n".join(" " * i + "a:" for i in range(2000)), DEEPEST + 1, f"nested deeper than {DEEPEST}"),
    ],
)
def test_what_is_no_mechanism_file_is_refused_in_its_line(text, line, what):
    message = refused(text)
    assert message.startswith("f.yaml:")
    assert int(message.split(":")[1]) in (line, line + 1)  # the parser may look one line ahead
    assert what in message


def test_a_file_that_is_no_utf_8_has_the_line_of_the_byte(tmp_path):
    file = tmp_path / "latin.yaml"
    file.write_bytes("sigmafmu: 1\nname: Größe\n".encode("latin-1"))
    with pytest.raises(MechanismFileError, match=r"latin.yaml:2: byte 0xf6 is no UTF-8"):
        read_text(file)


def test_a_byte_order_mark_is_no_text(tmp_path):
    file = tmp_path / "bom.yaml"
    file.write_bytes(b"\xef\xbb\xbfa: 1\n")
    assert plain(parse(read_text(file), file)) == {"a": 1}


def test_a_large_file_is_refused_without_reading_it_all(tmp_path):
    file = tmp_path / "large.yaml"
    with file.open("wb") as content:
        content.truncate(10 * LARGEST_FILE)  # sparse: 100 MB
    with pytest.raises(MechanismFileError, match="is larger than 10 MB"):
        read_text(file)


@pytest.mark.parametrize(("name", "what"), [("absent.yaml", "No such file"), ("", "is no file")])
def test_what_is_no_file(tmp_path, name, what):
    with pytest.raises(MechanismFileError, match=what):
        read_text(tmp_path / name)
