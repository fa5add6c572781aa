"""extra/org.fmi-standard.fmi-ls-ref: an experiment, its reference result, and how far an FMU may be from it.

The layered standard FMI-LS-REF (https://github.com/modelica/fmi-ls-ref) is for FMI 2.0 and 3.0: a manifest names
related files and their roles. The format of the experiment is MA-HS-Experiments
(https://github.com/modelica/ma-hs-experiments). Both are drafts; the second has no place for error bounds, so these are
in a table of their own, with the role `report`.

A bound is the stated error of the reference plus twice the FMU's own error at its default settings. The latter is an
estimate by halving the step (`estimate_errors.py` wrote it), that is, the leading term of the error alone: hence twice.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from .description import Description

STANDARD = "org.fmi-standard.fmi-ls-ref"
FOLDER = Path("extra") / STANDARD
NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
MANIFEST = {
    "fmi-ls-name": STANDARD,
    "fmi-ls-version": "1.0.0-alpha.1",
    "fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
}
SAFETY = 2.0
LEFT_OUT = ".quaternion["  # q and -q are the same orientation, which a comparison column by column does not know


@dataclass(frozen=True)
class Bound:
    """Errors of one variable, in its unit: those of the reference and of the FMU, and what a difference may be."""

    variable: str
    unit: str
    reference_error: float
    own_error: float

    @property
    def bound(self) -> float:
        """Largest difference allowed between the FMU's result and the reference."""
        return self.reference_error + SAFETY * self.own_error


@dataclass(frozen=True)
class Experiment:
    """What a reader should know about the reference result."""

    stop_time: str
    step_size: str
    header: dict[str, str]  # of the reference: how it was made, and its errors
    bounds: list[Bound]


def write(description: Description, references: Path, errors: Path, out: Path) -> Experiment | None:
    """Writes the reference of a model into the FMU's folder `out`, if it has one that needs no inputs.

    A model whose reference needs inputs has no table of errors.
    """
    model = description.model
    source = references / f"{model}.csv"
    if not source.exists() or not (errors / f"{model}.csv").exists():
        return None
    header, names, rows = _read_reference(source)
    used = [i for i, name in enumerate(names) if LEFT_OUT not in name]
    experiment = Experiment(
        stop_time=rows[-1][0],
        step_size=rows[1][0],
        header=header,
        bounds=_read_errors(errors / f"{model}.csv", [names[i] for i in used[1:]]),
    )

    folder = out / FOLDER
    folder.mkdir(parents=True)
    _write_table(folder / f"{model}_ref.csv", [[row[i] for i in used] for row in [names, *rows]])
    table = [
        [b.variable, b.unit, *(f"{x:.3g}" for x in (b.reference_error, b.own_error, b.bound))]
        for b in experiment.bounds
    ]
    _write_table(folder / f"{model}_bounds.csv", [["variable", "unit", "referenceError", "ownError", "bound"], *table])
    _write_xml(folder / f"{model}.exp", _experiments(model, experiment))
    _write_xml(folder / "fmi-ls-manifest.xml", _manifest(model))
    return experiment


def _read_reference(path: Path) -> tuple[dict[str, str], list[str], list[list[str]]]:
    """Header (`# key: value`), column names, rows; numbers stay as they are written."""
    lines = path.read_text(encoding="utf-8").splitlines()
    pairs = [line[1:].partition(":") for line in lines if line.startswith("#")]
    names, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    return {key.strip(): value.strip() for key, _, value in pairs}, names, rows


def _read_errors(path: Path, variables: list[str]) -> list[Bound]:
    with path.open(encoding="utf-8", newline="") as file:
        rows = {row["variable"]: row for row in csv.DictReader(file)}
    missing = [name for name in variables if name not in rows]
    if missing:
        raise LookupError(f"{path} has no error of {missing[0]}; run tools/estimate_errors.py")
    return [
        Bound(name, rows[name]["unit"], float(rows[name]["reference_error"]), float(rows[name]["own_error"]))
        for name in variables
    ]


def _experiments(model: str, experiment: Experiment) -> etree._Element:
    root = etree.Element("Experiments", name=model, description="Checks an FMU and its master against a reference")
    element = etree.SubElement(
        root,
        "Experiment",
        name="reference",
        description=f"Start values of the FMU; differences must be within {model}_bounds.csv at every time",
    )
    etree.SubElement(
        element, "TransientSimulation", startTime="0", stopTime=experiment.stop_time, stepSize=experiment.step_size
    )
    etree.SubElement(element, "References", source=f"{model}_ref.csv", type="text/csv")
    return root


def _manifest(model: str) -> etree._Element:
    root = etree.Element("fmiReferences", nsmap={"fmi-ls": NAMESPACE})
    for name, value in MANIFEST.items():
        root.set(f"{{{NAMESPACE}}}{name}", value)
    related = (
        (f"{model}.exp", "application/x-ma-hs-experiments", "experiment/validation", "Run and compare"),
        (f"{model}_ref.csv", "text/csv", "result", "Converged solution of another code"),
        (f"{model}_bounds.csv", "text/csv", "report", "Allowed difference of every variable from the reference"),
        ("../../documentation/fmi-ls-ref.html", "text/html", "document", "How reference and bounds were made"),
    )
    for source, mime, role, text in related:
        etree.SubElement(root, "Related", source=source, type=mime, role=role, description=text)
    return root


def _write_table(path: Path, rows: list[list[str]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def _write_xml(path: Path, root: etree._Element) -> None:
    etree.indent(root)
    etree.ElementTree(root).write(path, encoding="UTF-8", xml_declaration=True)
