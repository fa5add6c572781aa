"""The JSON Schema of mechanism files, for editors: made of the loader's table.

    python -m sigmafmu.mechanism_file.schema > tools/sigmafmu/mechanism_file/schema.json

A schema cannot tell everything that the loader checks: units, names and what a body can be are beyond it.
"""

import json
from typing import Any

from sigmafmu.mechanism_file.table.mechanism import MECHANISM, SHARED, VERSION
from sigmafmu.mechanism_file.units import DIMENSIONS, si_unit

WITH_UNIT = r"^\s*[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?[^0-9].*$"


def schema() -> dict[str, Any]:
    """The schema, draft 2020-12."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"sigmafmu mechanism file, version {VERSION}",
        **MECHANISM.object_schema(),
        "$defs": {
            **{name.replace(" ", "_"): _quantity(name) for name in DIMENSIONS},
            **{struct.name: struct.object_schema() for struct in SHARED},
        },
    }


def _quantity(dimension: str) -> dict[str, Any]:
    if dimension == "number":
        return {"type": "number"}
    return {
        "title": f"{dimension} in {si_unit(dimension)}, or with a unit",
        "type": ["number", "string"],
        "pattern": WITH_UNIT,
    }


def text() -> str:
    """The schema as it is published."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    print(text(), end="")
