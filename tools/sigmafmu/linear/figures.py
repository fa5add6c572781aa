"""Bode and pole plots of linear models."""

import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sigmafmu import SigmafmuError
from sigmafmu.linear.model import LinearModel
from sigmafmu.plots import COLORS, STYLE, save

MAX_INPUTS, MAX_OUTPUTS = 4, 6
DECADES = 1.0
"""How far a Bode plot goes beyond the slowest and the fastest pole."""
POINTS = 2000
FAR_APART = 100.0
"""Ratio of pole sizes from which a pole plot has logarithmic axes."""
ZERO = 1e-6
"""Poles below this part of the largest one, or of 1 rad/s, count as zero."""
NOTHING = 1e-13
"""Responses below this part of an input's largest one are rounding and not drawn."""


def bode(model: LinearModel, path: Path | str | None = None) -> Figure:
    """Magnitude and phase of outputs (curves) over the frequency of inputs (columns)."""
    inputs, outputs = len(model.inputs), len(model.outputs)
    if not 0 < inputs <= MAX_INPUTS or not 0 < outputs <= MAX_OUTPUTS:
        raise SigmafmuError(
            f"a Bode plot shows 1 to {MAX_INPUTS} inputs and 1 to {MAX_OUTPUTS} outputs, not {inputs} and {outputs}; "
            "choose them with --input and --output"
        )
    omega = _frequencies(model)
    response = model.frequency_response(omega)
    size = np.abs(response)
    drawn = size.max(axis=0) > NOTHING * size.max(axis=(0, 1))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3.0 + 4.2 * inputs, 6.0), layout="constrained")
        FigureCanvasAgg(figure)
        figure.suptitle(model.title, x=0.01, ha="left", fontsize=11)
        axes = figure.subplots(2, inputs, squeeze=False, sharex=True)
        for j, (name, unit) in enumerate(zip(model.inputs, model.input_units, strict=True)):
            magnitude, phase = axes[:, j]
            for i in np.flatnonzero(drawn[:, j]):
                label = f"{model.outputs[i]} in {_per(model.output_units[i], unit)}"
                magnitude.loglog(omega, size[:, i, j], color=COLORS[i], label=label)
                degrees = np.degrees(np.unwrap(np.angle(response[:, i, j])))
                turns = 360 * np.round((degrees[0] + 90) / 360)  # begin within (−270°, 90°]
                phase.semilogx(omega, degrees - turns, color=COLORS[i])
            magnitude.set_title(f"from {name}")
            magnitude.legend()
            phase.set(xlabel="ω in rad/s", ylabel="phase in degrees")
            phase.yaxis.set_major_locator(mpl.ticker.MultipleLocator(90))
            magnitude.set_ylabel("magnitude")
    if path is not None:
        save(figure, path)
    return figure


def pole_map(model: LinearModel, path: Path | str | None = None) -> Figure:
    """Poles in the complex plane, with the border of stability."""
    poles = model.poles()
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.0, 5.2), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        axes.set_title(model.title)
        if model.sample_time:
            circle = np.exp(1j * np.linspace(0, 2 * np.pi, 400))
            axes.plot(circle.real, circle.imag, color=COLORS[5], linewidth=0.8)
            axes.set_aspect("equal")
            axes.set(xlabel="real part", ylabel="imaginary part")
        else:
            axes.axvline(0, color=COLORS[5], linewidth=0.8)
            axes.set(xlabel="real part in 1/s", ylabel="imaginary part in rad/s")
            _scale(axes, poles)
        stable = ~_unstable(poles, model.sample_time)
        for chosen, color, label in ((stable, COLORS[0], "stable or on the border"), (~stable, COLORS[1], "unstable")):
            if chosen.any():
                axes.plot(poles[chosen].real, poles[chosen].imag, "x", color=color, markersize=8, label=label)
        axes.legend()
    if path is not None:
        save(figure, path)
    return figure


def _scale(axes: Axes, poles: np.ndarray) -> None:
    """Both axes from the slowest to the fastest pole: logarithmic in both directions if these are far apart."""
    sizes = _sizes(poles)
    fastest, slowest = (sizes.max(), sizes.min()) if sizes.size else (1.0, 1.0)
    logarithmic = fastest > FAR_APART * slowest
    linear = 10.0 ** np.floor(np.log10(slowest))
    for axis, parts in (("x", poles.real), ("y", poles.imag)):
        reach = 3.0 if logarithmic else 1.15
        margin = linear if logarithmic else 0.15 * max(np.abs(parts).max(initial=0.0), 0.1 * fastest)
        low, high = reach * parts.min(initial=0.0), reach * parts.max(initial=0.0)
        getattr(axes, f"set_{axis}lim")(min(low, -margin), max(high, margin))
        if logarithmic:
            getattr(axes, f"set_{axis}scale")("symlog", linthresh=linear)


def _unstable(poles: np.ndarray, sample_time: float) -> np.ndarray:
    """Which of the poles leave the stable half plane or circle by more than rounding; double zeros are split by it."""
    rates = np.log(poles) / sample_time if sample_time else poles
    sizes = np.abs(rates)
    return (rates.real > 1e-9 * sizes) & (sizes > ZERO * sizes.max(initial=1.0))


def _sizes(poles: np.ndarray) -> np.ndarray:
    """Of the poles that are not zero."""
    sizes = np.abs(poles)
    return sizes[sizes > ZERO * sizes.max(initial=1.0)]


def _frequencies(model: LinearModel) -> np.ndarray:
    poles = model.poles()
    if model.sample_time:
        poles = np.log(poles) / model.sample_time
    sizes = _sizes(poles)
    low, high = (sizes.min(), sizes.max()) if sizes.size else (1.0, 1.0)
    start, stop = np.log10(low) - DECADES, np.log10(high) + DECADES
    if model.sample_time:
        stop = np.log10(np.pi / model.sample_time)
    return np.logspace(min(start, stop - DECADES), stop, POINTS)


def _per(output: str, unit: str) -> str:
    """Unit of an output over that of an input."""
    over, under = (f"({text})" if re.search(r"[./]", text) else text or "1" for text in (output, unit))
    return over if under == "1" else f"{over}/{under}"
