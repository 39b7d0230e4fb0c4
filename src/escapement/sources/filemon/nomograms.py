"""Filemon's figures 13 and 16: mean and greatest torque read off a sheet of paper.

From the inertia ratio F up to the number of slots n, across to the load M_e/eta,
down to the torque. Load and torque may both be taken times the same power of
ten; F may not. The scan of the paper does not contain its charts, so these are new ones.
"""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.constant_speed import reversal_study
from escapement.mechanisms.protocol import FloatArray
from escapement.plots import style
from escapement.sources.filemon.filemon_figures import LOAD_RATIO

LOADS = np.array([1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0])
SHEET = (11.2, 7.7)
"""Size of a sheet [in]: A4 across."""
_SCALE_SIZE = 7.0
# rulings of a decade: steps of 0.1 up to 2, of 0.2 up to 5, of 0.5 up to 10
_FINE = np.r_[10:20, 20:50:2, 50:100:5] / 10.0
_TORQUES = {
    13: (
        "torque_mean", "Mean torque of the first half, $M_{2av}$",
        r"$M_{2av}\,\eta/M_e = D\,(1 + FA)$",
    ),
    16: (
        "torque_max", r"Greatest torque, $M_{2\,\mathrm{max}}$",
        r"$M_{2\,\mathrm{max}}\,\eta/M_e$ = max $i_\omega (1 + F i_\varepsilon)$",
    ),
}  # fmt: skip
_WHEELS: dict[str, Any] = {
    "a": ((3, 4, 5), (0.01, 4.0), (0.6, 4, 3.0)),
    "b": ((6, 7, 8, 9, 10), (0.1, 20.0), (3.0, 8, 4.0)),
}


class Nomogram(NamedTuple):
    """One nomogram: its result, its wheels, and the range of F.

    column : of a `reversal_study`, for a load torque of 1.
    example : its F, number of slots and load.
    """

    number: str
    column: str
    name: str
    factor: str
    slots: tuple[int, ...]
    ratios: tuple[float, float]
    example: tuple[float, int, float]


NOMOGRAMS = {
    f"{figure}{part}": Nomogram(f"{figure}/{part}", *torque, *wheels)
    for figure, torque in _TORQUES.items()
    for part, wheels in _WHEELS.items()
}
"""The four sheets: 13 for the mean, 16 for the greatest torque."""


def plot_nomogram(sheet: Nomogram) -> Figure:
    """One of `NOMOGRAMS`, to be printed on a separate page.

    Returns
    -------
    Figure
        Left: from F to torque per load, a line for each number of slots. Right: multiplied by the
        load. The coloured path is an example.
    """
    figure = style.new_figure(*SHEET)
    left, right = map(style.dress, figure.subplots(1, 2, sharey=True, width_ratios=(1.0, 1.15)))
    ratio = np.geomspace(*sheet.ratios, 200)
    lines = np.array([getattr(reversal_study(n, ratio), sheet.column) for n in sheet.slots])
    # limits are rulings, so that the outermost can be read too
    rulings = _ticks(0.05 * lines.min(), 20.0 * lines.max(), _FINE)
    low = rulings[rulings <= 0.97 * lines.min()].max()
    high = rulings[rulings >= 1.03 * lines.max()].min()
    for n, line in zip(sheet.slots, lines, strict=True):
        left.plot(ratio, line, color=style.BLUE, lw=1.2)
        style.annotate(left, f"n = {n}", (float(ratio[12]), float(line[12])))
    # on logarithmic scales the product with a load is a straight line
    right.plot(np.outer([low, high], LOADS), [low, high], color=style.BLUE, lw=1.2)
    for load in LOADS:
        style.annotate(right, f"{load:g}", (load * high, high), (0.0, 7.0))
    right.text(
        10.0**0.5 * high, 1.0, r"$M_e/\eta$" + "\n", ha="center", va="bottom",
        transform=right.get_xaxis_transform(), fontsize=style.TICK_SIZE,
    )  # fmt: skip
    for ax, across in ((left, sheet.ratios), (right, (low, 10.0 * high))):
        _scale(ax, "x", *across)
        _scale(ax, "y", low, high)
    right.tick_params(axis="y", which="major", labelright=True, labelsize=_SCALE_SIZE)
    left.set(xlabel=LOAD_RATIO, ylabel=sheet.factor)
    right.set_xlabel(sheet.name)
    example, n, load = sheet.example
    figure.suptitle(
        f"{sheet.number}  {sheet.name}. Example: F = {example:g}, n = {n}, "
        rf"$M_e/\eta$ = {load:g} gives {_draw_example(left, right, sheet):.3g}. "
        "Load and torque may both be taken times a power of ten.",
        fontsize=style.TICK_SIZE,
    )
    return figure


def _draw_example(left: Axes, right: Axes, sheet: Nomogram) -> float:
    """The path of one reading; returns its result."""
    ratio, n, load = sheet.example
    factor = float(getattr(reversal_study(n, ratio), sheet.column))
    end, bottom = load * factor, left.get_ylim()[0]
    # a dot where the path turns
    look: dict[str, Any] = {"color": style.VERMILLION, "zorder": 5, "lw": 1.4, "markevery": [1]}
    left.plot([ratio, ratio, left.get_xlim()[1]], [bottom, factor, factor], "-o", ms=4, **look)
    right.plot([right.get_xlim()[0], end, end], [factor, factor, bottom], "-o", ms=4, **look)
    right.plot(end, bottom, "v", ms=6, color=style.VERMILLION, zorder=5, clip_on=False)
    return end


def _scale(ax: Axes, which: str, low: float, high: float) -> None:
    """A logarithmic scale ruled like engineers' paper."""
    axis = getattr(ax, f"{which}axis")
    ax.set(**{f"{which}scale": "log", f"{which}lim": (low, high)})
    numbers = _ticks(low, high, LOADS[:-1])
    axis.set_ticks(numbers, [f"{number:.6g}" for number in numbers])
    axis.set_tick_params(labelsize=_SCALE_SIZE, rotation=90.0 if which == "x" else 0.0)
    # hundreds of minor ticks would take longer to lay out than all the rest
    axis.set_ticks([], minor=True)
    ax.grid(color=style.GREY, lw=0.45)
    draw = ax.vlines if which == "x" else ax.hlines
    draw(
        _ticks(low, high, _FINE), 0.0, 1.0, transform=getattr(ax, f"get_{which}axis_transform")(),
        gid=f"rulings-{which}", color=style.LIGHT_GREY, lw=0.3, zorder=0.4,
    )  # fmt: skip
    ax.set_axisbelow(True)


def _ticks(low: float, high: float, decade: FloatArray) -> FloatArray:
    """The numbers of every decade that lie between limits, which may themselves be ticks."""
    powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1.0)
    ticks: FloatArray = np.outer(powers, decade).ravel()
    return ticks[(ticks >= low * (1.0 - 1e-9)) & (ticks <= high * (1.0 + 1e-9))]
