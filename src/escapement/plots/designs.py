"""Figure of the designs that meet a requirement."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from escapement.base.text import words
from escapement.plots import style
from escapement.plots.style import finished, readable

if TYPE_CHECKING:
    from escapement.inverse_design.timer_search import Designs

_MARKERS = "osD^vP*X<>hd"


def plot_designs(found: "Designs") -> Figure:
    """The designs over two objectives, a marker for each kind of wheel.

    Parameters
    ----------
    found : Designs
        What `escapement.design` returns, with at least one design.

    Returns
    -------
    Figure
        The first objective along x, and the second, or else the mass, along y.
    """
    from escapement.inverse_design.requirement import BOUNDS

    names = [*found.requirement.objectives, "mass", "size"][:2]
    drawn = style.new_figure(style.ONE_COLUMN, 3.0)
    axes = style.new_panels(drawn, 1, 1)[0]
    columns, labels = [], []
    for name in names:
        values = np.array([one.values[name] for one in found.designs])
        scale, unit = readable(BOUNDS[name].unit, values)
        columns.append(scale * values)
        labels.append((words(name), unit))
    wheels = [one.timer.mechanism for one in found.designs]
    kinds = [(w.slots, w.internal) for w in wheels]  # type: ignore[attr-defined]
    for marker, kind in zip(_MARKERS, sorted(set(kinds)), strict=False):
        here = np.array([used == kind for used in kinds])
        slots, internal = kind
        label = f"{slots} slots" + ", internal" * internal
        axes.plot(columns[0][here], columns[1][here], marker, color=style.BLUE, mfc="none",
                  label=label)  # fmt: skip
    finished(axes, labels[0], labels[1], 2)
    return drawn
