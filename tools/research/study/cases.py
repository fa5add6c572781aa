"""The paper's benchmarks with its parameters, and the methods that are compared on them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from research.measure import FORMULATION_NAMES, INCREMENTAL, INDEX2, INDEX3, MULTIPLIERS, RESIDUAL, STABILIZED
from sigmafmu import _core


@dataclass(frozen=True)
class Case:
    """One mechanism; every step is half of the one before."""

    figures: str
    """Of the paper, for convergence."""
    stop_time: float  # s
    short_time: float  # s, where cost counts
    quick_time: float  # s
    largest_step: float  # s
    halvings: int
    quick_halvings: range
    rho_inf: Mapping[int, float]
    """By formulation."""
    errors: tuple[str, ...]
    """Of `runs.ERRORS`, what the paper shows."""
    relative_tolerance: float = 1e-8

    def steps(self, quick: bool) -> list[float]:
        """Step sizes in s."""
        chosen = self.quick_halvings if quick else range(self.halvings + 1)
        return [self.largest_step / 2**i for i in chosen]

    def time(self, quick: bool, short: bool = False) -> float:
        """Stop time in s."""
        return self.quick_time if quick else self.short_time if short else self.stop_time


CASES = {
    "HeavyTop": Case(
        figures="Figs. 3 and 4",
        stop_time=1.0,
        short_time=1.0,
        quick_time=0.5,
        largest_step=4e-3,
        halvings=7,
        quick_halvings=range(2, 5),
        rho_inf={INDEX3: 0.65, INDEX2: 0.65, STABILIZED: 1.0},
        errors=("position", "velocity", "multipliers"),
    ),
    "HighSpeedRotor": Case(
        figures="Fig. 7",
        stop_time=1.0,
        short_time=0.2,
        quick_time=0.04,
        largest_step=8e-5,
        halvings=5,
        quick_halvings=range(2, 5),
        rho_inf={INDEX3: 0.9, INDEX2: 0.9},
        errors=("final position", "final velocity"),
    ),
    "SliderCrank": Case(
        figures="Fig. 10",
        stop_time=2.0,
        short_time=2.0,
        quick_time=1.0,
        largest_step=2e-2,
        halvings=7,
        quick_halvings=range(2, 5),
        rho_inf={INDEX3: 0.875, INDEX2: 0.875, STABILIZED: 0.875},
        errors=("final position", "final velocity"),
        relative_tolerance=1e-9,
    ),
}

SIGMAS = ("geom1", "γ/(3β)", "1")
"""Labels of σ = 0, the paper's optimum, where the Lie term of (40) vanishes, and σ = 1."""
LARGEST_SIGMA = 3.0
"""Where the search for the best σ ends."""
CORRECTORS = {RESIDUAL: "residual", INCREMENTAL: "incremental"}
PEERS: dict[str, dict[str, Any]] = {
    "geom1": {"rotation": "lieGroup", "simplified_kinematics": True},
    "σ-modified": {"rotation": "lieGroup", "simplified_kinematics": False},
    "Euler parameters": {"rotation": "eulerParameters"},
    "Tait-Bryan": {"rotation": "taitBryan"},
}
"""Exudyn's ways to describe rotation."""
PEER_SCHEMES = {INDEX3: "index3", INDEX2: "index2"}


def sigma_of(label: str, rho_inf: float) -> float:
    """The number behind one of `SIGMAS`."""
    alpha = _core.AlphaParameters(rho_inf)
    return {"geom1": 0.0, "γ/(3β)": alpha.gamma / (3 * alpha.beta), "1": 1.0}[label]


def sigma_name(label: str, sigma: float = 0.0) -> str:
    """How figures and tables call it; `sigma` is the value of the best one."""
    if label == "best":
        return f"best σ ≥ {LARGEST_SIGMA:g}" if sigma > LARGEST_SIGMA - 0.05 else f"best σ = {sigma:.2f}"
    return "geom1 (σ = 0)" if label == "geom1" else f"σ = {label}"


def formulations(mechanism: str) -> dict[int, float]:
    """Formulations of ours and their ρ∞: without constraints they are one."""
    every = dict(CASES[mechanism].rho_inf)
    return every if MULTIPLIERS[mechanism] else {INDEX3: every[INDEX3]}


def settings(mechanism: str, formulation: int, **others: float) -> dict[str, float]:
    """Settings of ours with the paper's parameters."""
    case = CASES[mechanism]
    return {
        "formulation": formulation,
        "spectral_radius": case.rho_inf[formulation],
        "relative_tolerance": case.relative_tolerance,
        **others,
    }


def peer_settings(mechanism: str, formulation: int, label: str, **others: Any) -> dict[str, Any]:
    """Settings of Exudyn with the paper's parameters; `label` is one of `PEERS`."""
    case = CASES[mechanism]
    return {
        **PEERS[label],
        "scheme": PEER_SCHEMES[formulation],
        "rho_inf": case.rho_inf[formulation],
        "relative_tolerance": case.relative_tolerance,
        **others,
    }


def formulation_title(mechanism: str, formulation: int) -> str:
    """Name and ρ∞, for figures."""
    return f"{FORMULATION_NAMES[formulation]}, ρ∞ = {CASES[mechanism].rho_inf[formulation]:g}"
