"""Filemon's figures 13 and 16: mean and greatest torque read off a sheet of paper.

From the inertia ratio F up to the number of slots n, across to the load M_e/eta,
down to the torque. Load and torque may both be taken times the same power of
ten; F may not. The paper's own charts do not survive in the text it is known from,
so these are laid out anew.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from escapement.constant_speed import reversal_study
from escapement.model import FloatArray
from escapement.plots import style

FEW_SLOTS, MANY_SLOTS = (3, 4, 5), (6, 7, 8, 9, 10)
"""Numbers of slots of the sheets a and b."""
LOADS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
SHEET = (11.2, 7.7)
"""Size of a sheet [in]: A4 across."""

_EXAMPLE_COLOR = style.VERMILLION
_LABELLED = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
_POINTS = 200
_SCALE_SIZE = 7.0


@dataclass(frozen=True)
class Nomogram:
    """One nomogram: what it gives, for which wheels, and the range of F."""

    number: str
    name: str
    factor: str
    read: Callable[[int, FloatArray], FloatArray]
    slots: tuple[int, ...]
    ratios: tuple[float, float]
    example: tuple[float, int, float]  # its F, n and load


def _mean(slots: int, ratio: FloatArray) -> FloatArray:
    return reversal_study(slots, ratio).torque_mean


def _greatest(slots: int, ratio: FloatArray) -> FloatArray:
    return reversal_study(slots, ratio).torque_max


_MEAN = ("mean torque of the first half, $M_{2av}$", r"$M_{2av}\,\eta/M_e = D\,(1 + FA)$", _mean)
_MAX = (
    r"greatest torque, $M_{2\,\mathrm{max}}$",
    r"$M_{2\,\mathrm{max}}\,\eta/M_e$ = max $i_\omega (1 + F i_\varepsilon)$",
    _greatest,
)
NOMOGRAMS = {
    "13a": Nomogram("13/a", *_MEAN, FEW_SLOTS, (0.01, 4.0), (0.6, 4, 3.0)),
    "13b": Nomogram("13/b", *_MEAN, MANY_SLOTS, (0.1, 20.0), (3.0, 8, 4.0)),
    "16a": Nomogram("16/a", *_MAX, FEW_SLOTS, (0.01, 4.0), (0.6, 4, 3.0)),
    "16b": Nomogram("16/b", *_MAX, MANY_SLOTS, (0.1, 20.0), (3.0, 8, 4.0)),
}
"""The four sheets: 13 for the mean, 16 for the greatest torque."""


def plot_nomogram(sheet: Nomogram) -> Figure:
    """One of `NOMOGRAMS`, to be printed on a page of its own.

    Returns
    -------
    Figure
        Left: F to torque per load, a line a number of slots. Right: times the
        load. The coloured path is an example.
    """
    figure = style.new_figure(*SHEET)
    left, right = (
        style.dress(ax) for ax in figure.subplots(1, 2, sharey=True, width_ratios=(1.0, 1.15))
    )
    ratio = np.geomspace(*sheet.ratios, _POINTS)
    lines = [sheet.read(n, ratio) for n in sheet.slots]
    low, high = _rounded(min(line.min() for line in lines), max(line.max() for line in lines))
    for n, line in zip(sheet.slots, lines, strict=True):
        left.plot(ratio, line, color=style.BLUE, lw=1.2)
        i = int(0.06 * _POINTS)
        style.annotate(left, f"n = {n}", (float(ratio[i]), float(line[i])))
    _draw_loads(right, low, high)
    _scale(left, "x", *sheet.ratios)
    _scale(left, "y", low, high)
    _scale(right, "y", low, high)
    _scale(right, "x", low, 10.0 * high)
    right.tick_params(axis="y", which="major", labelright=True, labelsize=_SCALE_SIZE)
    left.set_xlabel("Inertia ratio $F = I_f\\,\\omega^2/M_e$", fontsize=style.LABEL_SIZE)
    left.set_ylabel(sheet.factor, fontsize=style.LABEL_SIZE)
    right.set_xlabel(_upper(sheet.name), fontsize=style.LABEL_SIZE)
    result = _draw_example(left, right, sheet)
    ratio_text, n, load = sheet.example
    figure.suptitle(
        f"{sheet.number}  {_upper(sheet.name)}. Example: F = {ratio_text:g}, n = {n}, "
        rf"$M_e/\eta$ = {load:g} gives {result:.3g}. "
        "Load and torque may both be taken times a power of ten.",
        fontsize=style.TICK_SIZE,
    )
    return figure


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]


def _draw_loads(ax: Axes, low: float, high: float) -> None:
    """A line a load: torque over torque per load."""
    factor = np.array([low, high])
    for load in LOADS:
        ax.plot(load * factor, factor, color=style.BLUE, lw=1.2)
        style.annotate(ax, f"{load:g}", (load * high, high), (0.0, 7.0))
    ax.text(
        10.0**0.5 * high, 1.0, r"$M_e/\eta$" + "\n", ha="center", va="bottom",
        transform=ax.get_xaxis_transform(), fontsize=style.TICK_SIZE,
    )  # fmt: skip


def _draw_example(left: Axes, right: Axes, sheet: Nomogram) -> float:
    """The path of one reading; returns what it leads to."""
    ratio, n, load = sheet.example
    factor = float(sheet.read(n, np.array([ratio]))[0])
    look: dict[str, Any] = {"color": _EXAMPLE_COLOR, "lw": 1.4, "zorder": 5}
    bottom = left.get_ylim()[0]
    left.plot([ratio, ratio, left.get_xlim()[1]], [bottom, factor, factor], **look)
    end = load * factor
    right.plot([right.get_xlim()[0], end, end], [factor, factor, bottom], **look)
    left.plot(ratio, factor, "o", ms=4, color=_EXAMPLE_COLOR, zorder=6)
    right.plot(end, factor, "o", ms=4, color=_EXAMPLE_COLOR, zorder=6)
    right.plot(end, bottom, "v", ms=6, color=_EXAMPLE_COLOR, zorder=6, clip_on=False)
    return end


def _scale(ax: Axes, which: str, low: float, high: float) -> None:
    """A logarithmic scale ruled like engineers' paper."""
    axis: Axis = getattr(ax, f"{which}axis")
    ax.set(**{f"{which}scale": "log", f"{which}lim": (low, high)})
    axis.set_major_locator(FixedLocator(list(_ticks(low, high, _LABELLED))))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}"))
    turn = 90.0 if which == "x" else 0.0
    axis.set_tick_params(which="major", labelsize=_SCALE_SIZE, rotation=turn)
    ax.grid(which="major", axis="both", color=style.GREY, lw=0.45)
    # hundreds of minor ticks would take longer to lay out than all the rest
    fine = list(_ticks(low, high, _fine()))
    look: dict[str, Any] = {"color": style.LIGHT_GREY, "lw": 0.3, "zorder": 0.4}
    if which == "x":
        ax.vlines(fine, 0.0, 1.0, transform=ax.get_xaxis_transform(), gid="rulings-x", **look)
    else:
        ax.hlines(fine, 0.0, 1.0, transform=ax.get_yaxis_transform(), gid="rulings-y", **look)
    ax.set_axisbelow(True)


def _fine() -> list[float]:
    """Rulings of a decade: steps of 0.1 up to 2, of 0.2 up to 5, of 0.5 up to 10."""
    steps = ((1.0, 2.0, 0.1), (2.0, 5.0, 0.2), (5.0, 10.0, 0.5))
    return [round(start + i * step, 2) for start, stop, step in steps
            for i in range(round((stop - start) / step))]  # fmt: skip


def _ticks(low: float, high: float, decade: Sequence[float]) -> Iterator[float]:
    for power in range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1):
        for value in decade:
            tick = value * 10.0**power
            if low * (1.0 - 1e-9) <= tick <= high * (1.0 + 1e-9):
                yield tick


def _rounded(low: float, high: float) -> tuple[float, float]:
    """Limits widened to rulings."""
    ticks = list(_ticks(0.05 * low, 20.0 * high, _fine()))
    return max(t for t in ticks if t <= 0.97 * low), min(t for t in ticks if t >= 1.03 * high)
