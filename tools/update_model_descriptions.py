"""Copy modelDescription.xml of every built FMU to modelDescription/<Model>.xml, the committed contract.

    .venv/bin/python tools/update_model_descriptions.py [FOLDER_OF_FMUS]

Run it after a wanted change of the interface and look at the difference before committing it.
"""

import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CONTRACTS = ROOT / "modelDescription"


def update(fmus: Path) -> list[str]:
    """Make the contracts those of the FMUs in `fmus`; returns what was done, a line per changed file."""
    built = {path.stem: path for path in sorted(fmus.glob("*.fmu"))}
    if not built:
        raise SystemExit(f"no FMUs in {fmus}; run `make build` first")
    done = []
    for model, path in built.items():
        with zipfile.ZipFile(path) as archive:
            xml = archive.read("modelDescription.xml")
        contract = CONTRACTS / f"{model}.xml"
        if not contract.exists() or contract.read_bytes() != xml:
            contract.write_bytes(xml)
            done.append(f"wrote {contract.name}")
    for contract in CONTRACTS.glob("*.xml"):
        if contract.stem not in built:
            contract.unlink()
            done.append(f"removed {contract.name}: there is no such FMU")
    return done


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "release" / "fmus"
    sys.stdout.write("\n".join(update(folder) or ["the contracts are up to date"]) + "\n")
