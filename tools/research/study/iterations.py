"""Newton iterations and Jacobians: ours, the paper's and Exudyn's, for full, simplified and modified Newton."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from research.measure import FORMULATION_NAMES, INDEX2, INDEX3, STABILIZED
from research.study import cases, runs
from research.study.cases import CASES, PEER_SCHEMES, PEERS, SIGMAS
from research.study.chapter import Cell, Results
from research.study.output import write_csv
from sigmafmu.markdown import markdown_table

VARIANTS: dict[str, dict[str, int]] = {
    "full": {},
    "simplified": {"jacobian": runs.TANGENT_FREE},
    "modified": {"newton": runs.MODIFIED},
}
"""Newton's method of ours: with ∂v/∂q, without it, and with a matrix that is kept."""
PEER_VARIANTS: dict[str, dict[str, bool]] = {"full": {}, "modified": {"modified_newton": True}}

LIE = ("geom1", "γ/(3β)", "1")
SIGMA = ("γ/(3β)", "1")
Figures = dict[tuple[int, str], dict[str, float]]


def _paper(*entries: tuple[Sequence[int], Sequence[str], Mapping[str, float]]) -> Figures:
    result: Figures = {}
    for formulations, labels, figures in entries:
        for formulation in formulations:
            for label in labels:
                result.setdefault((formulation, label), {}).update(figures)
    return result


PAPER: dict[str, Figures] = {
    "HeavyTop": _paper(
        ((INDEX3, INDEX2, STABILIZED), LIE, {"full": 2.0}),
        ((INDEX3, INDEX2), ("geom1", "1"), {"modified": 7.9}),
        ((INDEX3,), ("geom1",), {"simplified": 3.1}),
        ((STABILIZED,), ("geom1",), {"simplified": 2.9}),
        ((INDEX3,), ("γ/(3β)",), {"simplified": 2.5}),
        ((STABILIZED,), ("γ/(3β)",), {"simplified": 3.4}),
        ((INDEX3,), ("Euler parameters",), {"full": 3.8, "modified": 8.4}),
        ((INDEX3,), ("Tait-Bryan",), {"full": 2.1, "modified": 7.3}),
    ),
    "HighSpeedRotor": _paper(
        ((INDEX2,), SIGMA, {"full": 1.3, "simplified": 1.3}),
        ((INDEX2,), ("geom1",), {"full": 1.8, "simplified": 1.8}),
        ((INDEX3, INDEX2), ("1",), {"modified": 2.1, "jacobians": 1}),
        ((INDEX3, INDEX2), ("geom1",), {"modified": 2.3, "jacobians": 1}),
        ((INDEX3,), ("Euler parameters",), {"full": 2.56, "modified": 8.3, "jacobians": 119823}),
        ((INDEX3,), ("Tait-Bryan",), {"full": 2.56, "modified": 3.3}),
    ),
    "SliderCrank": _paper(
        ((INDEX3,), LIE, {"full": 2.0, "simplified": 2.0}),
        ((INDEX2,), LIE, {"full": 2.5, "simplified": 2.5}),
        ((INDEX3, INDEX2), ("geom1", "1"), {"modified": 7.2, "jacobians": 170}),
        ((INDEX3,), ("Euler parameters",), {"full": 3.0, "modified": 7.8, "jacobians": 1000}),
        ((INDEX3,), ("Tait-Bryan",), {"full": 2.0, "modified": 7.3}),
    ),
}
"""Mean iterations per step, and Jacobians per run with modified Newton, from the text of sections 7.1-7.3."""


def iterate(mechanism: str, steps: Sequence[float], stop_time: float, settings: dict[str, float]) -> dict[str, Any]:
    """Runs of ours with all `steps`."""
    return {"runs": [runs.ours(mechanism, h, stop_time, **settings) for h in steps]}


class Iterations:
    """The table behind the text of section 7."""

    name = "iterations"
    title = "Newton iterations"
    mechanisms = tuple(CASES)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each formulation, scheme and variant."""
        case = CASES[mechanism]
        common = (mechanism, case.steps(quick), case.time(quick, short=True))
        result = []
        for formulation, rho in cases.formulations(mechanism).items():
            for label in SIGMAS:
                for variant, chosen in VARIANTS.items():
                    key = f"{FORMULATION_NAMES[formulation]}/sigmafmu/{variant}/{label}"
                    sigma = cases.sigma_of(label, rho)
                    settings = cases.settings(mechanism, formulation, sigma=sigma, **chosen)
                    result.append(Cell(key, iterate, (*common, settings)))
        for formulation in PEER_SCHEMES:
            for label in PEERS:
                for variant, chosen in PEER_VARIANTS.items():
                    key = f"{FORMULATION_NAMES[formulation]}/Exudyn/{variant}/{label}"
                    settings = cases.peer_settings(mechanism, formulation, label, **chosen)
                    result.append(Cell(key, runs.exudyn_steps, (*common, settings)))
        return result

    def report(self, results: Results, folder: Path) -> str:
        """A table for each mechanism."""
        parts = [
            "Mean Newton iterations per step, over all step sizes with which the method runs (\\*: it fails with "
            "some); in brackets the Jacobians of a whole run with modified Newton. *Full* has the exact derivative of "
            "v with respect to the motion (3×3 for each body), *simplified* leaves it out, *modified* keeps the matrix "
            "until the contractivity exceeds 0.5. The paper's figures are means over step sizes that it does not name; "
            "its *full* has T and P⁻¹. Convergence is tested differently: ours on scaled velocity increments, Exudyn's "
            "on the residual. Time, not this count, settles which one is the default: see work and precision.\n"
        ]
        for mechanism, found in results.items():
            rows = _csv_rows(mechanism, found)
            write_csv(folder / f"iterations_{mechanism}.csv", rows, HEADER)
            parts.append(f"### {mechanism}\n\n{markdown_table(COLUMNS, _table(mechanism, found))}")
        return "\n".join(parts)


HEADER = ("code", "formulation", "variant", "scheme", "h", "steps", "iterations", "jacobians", "failed")
COLUMNS = (
    *("formulation", "scheme", "ours: full", "simplified", "modified"),
    *("paper: full", "simplified", "modified", "Exudyn: full", "modified"),
)


def _csv_rows(mechanism: str, found: Mapping[str, dict[str, Any]]) -> list[dict[str, Any]]:
    rows = []
    for key, cell in found.items():
        formulation, code, variant, scheme = key.split("/", 3)
        own = {"code": code, "formulation": formulation, "variant": variant, "scheme": scheme}
        rows += [own | run for run in cell["runs"]]
    return rows


def _table(mechanism: str, found: Mapping[str, dict[str, Any]]) -> list[list[str]]:
    rows = []
    for formulation, name in FORMULATION_NAMES.items():
        if formulation not in CASES[mechanism].rho_inf:
            continue
        own = name if formulation in cases.formulations(mechanism) else FORMULATION_NAMES[INDEX3]
        for label in (*SIGMAS, *(peer for peer in PEERS if peer not in ("geom1", "σ-modified"))):
            paper = PAPER[mechanism].get((formulation, label), {})
            peer = {"1": "σ-modified"}.get(label, label)
            row = [name, cases.sigma_name(label) if label in SIGMAS else label]
            row += [_figure(found.get(f"{own}/sigmafmu/{variant}/{label}"), variant) for variant in VARIANTS]
            row += [f"{paper[variant]:g}" if variant in paper else "" for variant in VARIANTS]
            row[-1] += f" ({paper['jacobians']})" if "jacobians" in paper else ""
            row += [_figure(found.get(f"{name}/Exudyn/{variant}/{peer}"), variant) for variant in PEER_VARIANTS]
            if any(row[2:]):
                rows.append(row)
    return rows


def _figure(cell: dict[str, Any] | None, variant: str) -> str:
    """Mean over the steps that ran; with modified Newton the Jacobians of a run in brackets."""
    if cell is None:
        return ""
    ran = [run for run in cell["runs"] if "failed" not in run]
    if not ran:
        return "fails"
    text = f"{np.mean([run['iterations'] for run in ran]):.2f}"
    if len(ran) < len(cell["runs"]):
        text += "*"
    return text + (
        f" ({np.mean([run['jacobians'] * run['steps'] for run in ran]):.0f})" if variant == "modified" else ""
    )


CHAPTER = Iterations()
