"""modelDescription/<Model>.xml, the committed contract, is what the build puts into each FMU."""

import difflib
import zipfile
from pathlib import Path

CONTRACTS = Path(__file__).resolve().parents[2] / "modelDescription"
HINT = "if that is wanted: .venv/bin/python tools/update_model_descriptions.py"


def test_fmu_holds_the_committed_description(fmu, model):
    contract = CONTRACTS / f"{model}.xml"
    assert contract.is_file(), f"{contract.name} is missing; {HINT}"
    with zipfile.ZipFile(fmu(model).path) as archive:
        built = archive.read("modelDescription.xml")
    committed = contract.read_bytes()
    if built != committed:
        lines = [text.decode().splitlines() for text in (committed, built)]
        difference = list(difflib.unified_diff(*lines, "committed", "built", lineterm="", n=0))
        shown = "\n".join(difference[:40])
        raise AssertionError(f"the interface of {model} differs from its contract; {HINT}\n{shown}")


def test_every_committed_description_has_its_fmu(models):
    assert sorted(path.stem for path in CONTRACTS.glob("*.xml")) == models, HINT
