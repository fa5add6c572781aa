"""What an FMU says about itself: documentation, licences, icon, terminals, types, and a reference with its bounds."""

import csv
import re
import struct
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import fmpy
import numpy as np
import pytest
from lxml import etree

from research.reference import group_of
from sigmafmu.compare import read_reference
from sigmafmu.contents import markdown, numbers_in_text
from sigmafmu.fmu import Fmu

ROOT = Path(__file__).resolve().parents[2]
FMI3_SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"
LS_REF = "extra/org.fmi-standard.fmi-ls-ref"
LS_REF_ATTRIBUTES = {
    "fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
    "fmi-ls-version": "1.0.0-alpha.1",
    "fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
}
VOID = {"meta", "img", "br", "hr", "link", "input"}
"""HTML elements without an end."""


@pytest.fixture
def tree(fmu, model) -> Path:
    """Folder with the unzipped FMU."""
    return fmu(model).directory


@pytest.fixture
def described(tree) -> etree._Element:
    return etree.parse(tree / "modelDescription.xml").getroot()


def variables(described: etree._Element) -> list[etree._Element]:
    return described.findall("ModelVariables/ScalarVariable")


# --- documentation ----------------------------------------------------------------------------------------------------


class Page(HTMLParser):
    """An HTML page; every element must be closed in its turn."""

    def __init__(self, path: Path):
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[tuple[str, str]] = []  # element, URL
        self.code: list[str] = []  # text of every <code>
        self.text = ""
        self.feed(path.read_text(encoding="utf-8"))
        self.close()
        assert self.open == [], f"{path.name} leaves {self.open} open"

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)
        if tag == "code":
            self.code.append("")
        for name, value in attrs:
            if name == "id":
                self.ids.append(value)
            elif name in {"href", "src"}:
                self.links.append((tag, value))

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data
        if "code" in self.open:
            self.code[-1] += data


def expanded(name: str) -> Iterator[str]:
    """`top.position[1…3]` stands for three variables."""
    if found := re.fullmatch(r"(.+)\[1…(\d+)\]", name):
        yield from (f"{found[1]}[{i}]" for i in range(1, int(found[2]) + 1))
    else:
        yield name


def pages(tree: Path) -> dict[Path, Page]:
    found = {path: Page(path) for path in sorted((tree / "documentation").glob("*.html"))}
    assert tree / "documentation" / "index.html" in found, "the FMU has no documentation/index.html"
    return found


def test_documentation_has_every_variable(tree, described):
    page = pages(tree)[tree / "documentation" / "index.html"]
    told = [name for text in page.code for name in expanded(text)]
    assert [v.get("name") for v in variables(described) if v.get("name") not in told] == []


def test_documentation_links_resolve(tree):
    found = pages(tree)
    for path, page in found.items():
        assert len(page.ids) == len(set(page.ids))
        for tag, url in page.links:
            if url.startswith("https://"):
                assert tag == "a", f"{path.name} loads {url}"
                continue
            name, _, anchor = url.partition("#")
            target = (path.parent / name).resolve() if name else path
            assert target.is_file(), f"{path.name} links to {url}"
            assert target.is_relative_to(tree.resolve())
            if anchor:
                assert anchor in found[target].ids, f"{path.name} links to {url}"


def test_documentation_quotes_the_description_of_the_mechanism(tree, model):
    """Each mechanism with a section in docs/mechanisms.md has its words in the FMU."""
    section = re.search(rf"^## {model}\n\n(.*?)\n\n", (ROOT / "docs" / "mechanisms.md").read_text() + "\n", re.M | re.S)
    if section:
        words = re.findall(r"\w+", section[1])
        told = re.findall(r"\w+", pages(tree)[tree / "documentation" / "index.html"].text)
        assert " ".join(words) in " ".join(told)


def test_documentation_says_what_is_true_of_this_mechanism(tree, described):
    names = [v.get("name") for v in variables(described)]
    flexible = sorted({name.partition(".")[0] for name in names if name.endswith(".modal[1]")})
    joints = any(name.endswith(".reactionForce[1]") for name in names)
    text = " ".join(pages(tree)[tree / "documentation" / "index.html"].text.split())
    assert ("Bodies are rigid." in text) == (not flexible)
    assert ("modal coordinates of a flexible body" in text) == bool(flexible)
    for body in flexible:
        assert f"{body} bends a little: linear modes" in text
    assert ("There are no joints." in text) == (not joints)
    assert ("joints hold in positions" in text) == joints
    assert "With integrator.method = rkmk54" in text
    assert "the internal step adapts to the error." in text
    assert ("integrator.stepControl = error" in text) == ("integrator.stepControl" in names)


class Loose(HTMLParser):
    """Text that a browser may break: outside listings, code and what is kept together."""

    def __init__(self, html: str):
        super().__init__(convert_charrefs=True)
        self.kept: list[bool] = []
        self.text = ""
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.kept.append(tag in {"pre", "code", "style", "title"} or ("class", "nb") in attrs)

    def handle_endtag(self, tag):
        self.kept.pop()

    def handle_data(self, data):
        if not any(self.kept):
            self.text += data


def test_no_number_of_the_documentation_breaks(tree):
    for path in (tree / "documentation").glob("*.html"):
        text = Loose(path.read_text(encoding="utf-8")).text
        pattern = r"\d (?:m|mm|s|kg|N|J|Hz|rad|rpm|rad/s|m/s|kg m²)\b|\de[-−]\d|\d \d{3}\b"
        assert re.findall(pattern, text) == [], path.name
    assert "overflow-wrap: anywhere" not in (tree / "documentation" / "index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("turns at 200 000 rpm", ["200 000 rpm"]),
        ("J = 0.23 kg m² and 1e-4 s", ["0.23 kg m²", "1e-4 s"]),
        ("2000 kg/m³ at −0.11", ["2000 kg/m³", "−0.11"]),
        ("2 bodies, FMI 2.0", []),
        ("<pre>h = 1e-4 s</pre>", []),
        ('<a href="#1 s">x2 s</a>', []),
    ],
)
def test_numbers_keep_their_units(text, kept):
    html = numbers_in_text.keep_together(text)
    assert re.findall('<span class="nb">(.*?)</span>', html) == kept
    assert re.sub('<span class="nb">(.*?)</span>', r"\1", html) == text


def header(image: Path) -> tuple[int, int, int]:
    """Width, height and colour type of a PNG."""
    signature, _length, kind, width, height, _depth, color = struct.unpack(">8sI4sIIBB", image.read_bytes()[:26])
    assert (signature, kind) == (b"\x89PNG\r\n\x1a\n", b"IHDR")
    return width, height, color


def test_icon_is_a_small_transparent_square(tree):
    assert header(tree / "model.png") == (256, 256, 6), "6 has transparency"


def test_figure_is_in_the_documentation(tree, model):
    width, height, _ = header(tree / "documentation" / f"{model}.png")
    assert 300 < width < 1000
    assert 150 < height < 1000
    assert f'<img src="{model}.png"' in (tree / "documentation" / "index.html").read_text(encoding="utf-8")


def test_pictures_have_neither_date_nor_version(tree, model):
    for image in (tree / "model.png", tree / "documentation" / f"{model}.png"):
        assert not {b"tIME", b"tEXt", b"iTXt"} & set(re.findall(rb"tIME|.TXt|tEXt", image.read_bytes()))


def test_benchmark_mechanisms_have_everything(models):
    """The mechanisms with a reference also have a section that describes them."""
    sections = (ROOT / "docs" / "mechanisms.md").read_text(encoding="utf-8")
    references = list((ROOT / "tests" / "references").glob("*.csv"))
    if not any(reference.stem in models for reference in references):
        pytest.skip("no benchmark is among the FMUs under test")
    for reference in references:
        assert reference.stem in models
        assert f"## {reference.stem}\n" in sections


def test_links_to_other_files_of_docs_become_text():
    html = markdown.html("[a](https://b.c/d) [*e* f](e.md) `g`")
    assert html == '<p><a href="https://b.c/d">a</a> <em>e</em> f <code>g</code></p>\n'


def test_headings_fit_below_those_of_the_page():
    assert markdown.html("## A `b`") == "<h3>A <code>b</code></h3>\n"


def test_markup_is_not_taken_for_html():
    assert markdown.html("a < b <b>c</b>") == "<p>a &lt; b &lt;b&gt;c&lt;/b&gt;</p>\n"


# --- licences ---------------------------------------------------------------------------------------------------------

LICENSES = {
    "sigmafmu-BSD-3-Clause.txt": ("BSD 3-Clause License", "POSSIBILITY OF SUCH DAMAGE."),
    "nlohmann-json-MIT.txt": ("MIT License", "OTHER DEALINGS IN THE SOFTWARE."),
    "MPL-2.0.txt": ("Mozilla Public License Version 2.0", "Mozilla Public License, v. 2.0."),
    "Apache-2.0.txt": ("Apache License", "limitations under the License."),
    "FMI-BSD-2-Clause.txt": ("Copyright (C) 2008-2011 MODELISAR consortium", "POSSIBILITY OF SUCH DAMAGE."),
}
"""File → what its first line and its end contain; the middle of a licence is not lost by itself."""


def test_licences_are_complete(tree):
    folder = tree / "documentation" / "licenses"
    entry = (folder / "license.txt").read_text(encoding="utf-8")
    assert {path.name for path in folder.iterdir()} == {"license.txt", *LICENSES}
    for name, (first, last) in LICENSES.items():
        lines = (folder / name).read_text(encoding="utf-8").strip().splitlines()
        assert name in entry
        assert first in lines[0]
        assert last in " ".join(lines[-3:])
    assert (folder / "sigmafmu-BSD-3-Clause.txt").read_bytes() == (ROOT / "LICENSE").read_bytes()


def test_licence_of_the_fmi_headers_is_theirs(tree):
    header = (Path(fmpy.__file__).parent / "c-code" / "fmi2Functions.h").read_text(encoding="utf-8")
    text = (tree / "documentation" / "licenses" / "FMI-BSD-2-Clause.txt").read_text(encoding="utf-8")
    assert " ".join(text.split()) in " ".join(header.split())


def test_packed_sources_have_the_licences_that_are_told(tree):
    """Eigen's headers: MPL, or one of the exceptions of license.txt; GPL nowhere."""
    exceptions = re.compile(r"BFloat16|_LAPACKE|lapacke|_BLAS|_MKL|MKL_")
    for path in (p for p in (tree / "sources").rglob("*") if p.is_file()):
        text = path.read_text(encoding="utf-8", errors="replace")
        assert not re.search(r"\bL?GPL\b|GNU (Lesser )?General Public", text), path
        if "Eigen" in path.parts and re.search(r"copyright", text, re.IGNORECASE):
            assert "Mozilla" in text or exceptions.search(path.name), path


# --- terminals --------------------------------------------------------------------------------------------------------


def test_terminals_follow_the_schema(tree):
    """That of FMI 3.0, which FMI 2.0.4 took over and which knows its own version alone."""
    schema = etree.XMLSchema(etree.parse(FMI3_SCHEMAS / "fmi3TerminalsAndIcons.xsd"))
    schema.assertValid(etree.parse(tree / "terminalsAndIcons" / "terminalsAndIcons.xml"))


def test_terminals_group_existing_variables(tree, described):
    """Members are variables named after their terminal, and every input is in exactly one terminal."""
    causality = {v.get("name"): v.get("causality") for v in variables(described)}
    terminals = etree.parse(tree / "terminalsAndIcons" / "terminalsAndIcons.xml").findall("Terminals/Terminal")
    names = [t.get("name") for t in terminals]
    assert len(names) == len(set(names))
    members = [(t.get("name"), m.get("memberName"), m.get("variableName")) for t in terminals for m in t]
    for terminal, member, variable in members:
        assert causality[variable] in {"input", "output"}
        assert variable == f"{terminal}.{member}"
    inputs = sorted(name for name, c in causality.items() if c == "input")
    assert sorted(variable for *_, variable in members if causality[variable] == "input") == inputs


# --- types ------------------------------------------------------------------------------------------------------------


def test_every_real_has_a_type_of_its_unit(described):
    types = {t.get("name"): t[0] for t in described.iterfind("TypeDefinitions/SimpleType")}
    units = {u.get("name"): {d.get("name") for d in u.findall("DisplayUnit")} for u in described.iter("Unit")}
    for scalar in variables(described):
        if (real := scalar.find("Real")) is not None:
            declared = types[real.get("declaredType")]
            assert declared.tag == "Real"
            assert declared.get("unit") == real.get("unit"), scalar.get("name")
            assert declared.get("displayUnit") == real.get("displayUnit"), scalar.get("name")
    assert set(types) == {v[0].get("declaredType") for v in variables(described)} - {None}, "types that nothing uses"
    for name, real in ((n, t) for n, t in types.items() if t.tag == "Real"):
        assert real.get("quantity"), name
        assert real.get("displayUnit") in {None, *units[real.get("unit")]}, name
        assert float(real.get("nominal", "1")) > 0, name


def test_start_values_are_in_range(described):
    """Attributes of a type hold for its variables unless they have their own; no validator looks at this."""
    types = {t.get("name"): t[0] for t in described.iterfind("TypeDefinitions/SimpleType")}
    started = 0
    for scalar in variables(described):
        value = scalar[0]
        if (start := value.get("start")) is None:
            continue
        declared = types.get(value.get("declaredType"), value)
        low, high = (
            value.get(name, declared.get(name, default)) for name, default in (("min", "-inf"), ("max", "inf"))
        )
        if declared.tag == "Enumeration":
            assert start in {item.get("value") for item in declared}, scalar.get("name")
        assert float(low) <= float(start) <= float(high), scalar.get("name")
        started += 1
    assert started > 10


# --- reference result -------------------------------------------------------------------------------------------------


def table(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def related(tree: Path, role: str) -> Path:
    """The one file of a role in the manifest of the layered standard."""
    folder = tree / LS_REF
    found = [r for r in etree.parse(folder / "fmi-ls-manifest.xml").findall("Related") if r.get("role") == role]
    assert len(found) == 1, f"{len(found)} files of role {role}"
    return folder / found[0].get("source")


@pytest.fixture(params=sorted(path.stem for path in (ROOT / "models" / "errors").glob("*.csv")))
def packed(request, fmu) -> Fmu:
    """The FMU of every mechanism that has a reference; one that needs inputs does not count."""
    return fmu(request.param)


def test_manifest_of_the_layered_standard(packed):
    path = packed.directory / LS_REF / "fmi-ls-manifest.xml"
    root = etree.parse(path).getroot()
    assert root.tag == "fmiReferences"
    prefix = "{http://fmi-standard.org/fmi-ls-manifest}"
    assert {name.removeprefix(prefix): value for name, value in root.attrib.items()} == LS_REF_ATTRIBUTES
    for item in root:
        assert item.tag == "Related"
        assert set(item.attrib) == {"source", "type", "role", "description"}
        assert (path.parent / item.get("source")).is_file()
    listed = {(path.parent / item.get("source")).resolve() for item in root}
    assert {p.resolve() for p in path.parent.iterdir() if p != path} <= listed


def test_models_without_reference_claim_none(tree, model):
    assert (tree / LS_REF).exists() == (ROOT / "models" / "errors" / f"{model}.csv").exists()


def test_experiment_meets_its_bounds(packed):
    """As another master would: run the experiment that is in the FMU, compare with the result and bounds beside it.

    The FMU's own error, which was estimated without the reference, must also be about what the reference shows, else
    the bounds would say nothing.
    """
    path = related(packed.directory, "experiment/validation")
    experiment = etree.parse(path).getroot().find("Experiment")
    settings = {name: float(value) for name, value in experiment.find("TransientSimulation").attrib.items()}
    reference = table(path.parent / experiment.find("References").get("source"))
    bounds = {row["variable"]: row for row in table(related(packed.directory, "report"))}
    names = [name for name in reference[0] if name != "time"]
    assert sorted(bounds) == sorted(names)

    result = fmpy.simulate_fmu(
        str(packed.path),
        start_time=settings["startTime"],
        stop_time=settings["stopTime"],
        output_interval=settings["stepSize"],
        output=names,
    )
    times = np.array([float(row["time"]) for row in reference])
    assert np.allclose(result["time"], times, rtol=0, atol=1e-9 * settings["stopTime"])
    for name in names:
        values = np.array([float(row[name]) for row in reference])
        difference = np.max(np.abs(result[name] - values))
        allowed, stated, own = (float(bounds[name][key]) for key in ("bound", "referenceError", "ownError"))
        assert difference <= allowed, f"{name}: {difference:g} instead of {allowed:g} {bounds[name]['unit']}"
        if own > max(10 * stated, 1e-16):  # else rounding
            assert own / 1.5 < difference < 1.5 * own, f"{name}: {difference:g}, estimated {own:g}"


def test_bounds_state_the_errors_of_the_reference(packed):
    """The result in the FMU is tests/references, number by number; so are its errors."""
    header, history = read_reference(ROOT / "tests" / "references" / f"{packed.name}.csv")
    rows = table(related(packed.directory, "result"))
    assert set(history) - set(rows[0]) == {name for name in history if ".quaternion[" in name}
    for name in rows[0]:
        assert [float(row[name]) for row in rows] == history[name].tolist()
    for row in table(related(packed.directory, "report")):
        stated, unit = header[f"stated error, {group_of(row['variable'])}"].split()
        assert (float(row["referenceError"]), row["unit"]) == (float(stated), unit)
