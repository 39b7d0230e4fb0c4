"""Figure of a budget of tolerances."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from escapement.base.text import words
from escapement.base.units import factor
from escapement.dynamics.figure_table import FIGURES
from escapement.plots import style
from escapement.plots.style import finished, readable
from escapement.tolerance.intervals import per_cent
from escapement.tolerance.spread import grouped

if TYPE_CHECKING:
    from escapement.tolerance.tolerance_budget import Budget

NO_SHARES = "no shares, because the figure\nlacks a derivative"
MOST = 8
"""So many contributors have room; the others are added up."""


def plot_budget(found: "Budget", figure: str | None = None) -> Figure:
    """Contributors to the scatter of a figure in order, and its sample with the limits.

    Parameters
    ----------
    found : Budget
        What `escapement.budget` returns.
    figure : str, optional
        Name of the figure of merit. Default: the first one.

    Returns
    -------
    Figure
        On the left the share of each tolerance in the variance, to first order [%]; on the right
        the histogram of the sample, with the limits and the share of cases within them.
    """
    name = figure or next(iter(found.figures))
    scatter, kind = found.figures[name], FIGURES[name].kind
    drawn = style.new_figure(style.TWO_COLUMN, 3.0)
    left, right = style.new_panels(drawn, 1, 2)
    parts = scatter.contributions
    shares = [
        (f"{key}, {len(names)} equal" if len(names) > 1 else key, sum(parts[n] for n in names))
        for key, names in grouped(parts).items()
    ]
    shares.sort(key=lambda one: -one[1])
    bars = shares[:MOST]
    if shares[MOST:]:
        bars.append((f"{len(shares) - MOST} others", sum(share for _, share in shares[MOST:])))
    heights = np.arange(len(bars))[::-1]
    left.barh(heights, [100.0 * share for _, share in bars], color=style.BLUE)
    if not bars:
        middle = {"transform": left.transAxes, "ha": "center", "va": "center"}
        left.set_xlim(0.0, 100.0)
        left.text(0.5, 0.5, NO_SHARES, middle, fontsize=style.SMALL_SIZE)
    left.set_yticks(heights, [words(key) for key, _ in bars])
    finished(left, ("share of variance", "%"), ("", ""), 1, legend=False)
    system = found.study.configuration["units"]
    values = found.study.results[name] * factor(kind, system)
    kept = values[np.isfinite(values)]
    scale, unit = readable(kind, kept)
    right.hist(kept * scale, bins=60, color=style.GREY)
    right.axvline(scatter.nominal * scale, color=style.BLUE, label="nominal")
    if scatter.limits and scatter.inside:
        low, high = scatter.limits
        text = f"limits: {per_cent(scatter.inside)} % within (95 %)"
        right.axvline(low * scale, label=text, **style.BROKEN)
        right.axvline(high * scale, **style.BROKEN)
    finished(right, (words(name), unit), ("cases", ""), 1)
    return drawn
