"""Figure of the designs that meet a requirement."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from escapement.base.text import words
from escapement.plots import style
from escapement.plots.style import finished, readable

if TYPE_CHECKING:
    from escapement.inverse_design.drive_search import DriveDesigns
    from escapement.inverse_design.timer_search import Designs

_MARKERS = "osD^vP*X<>hd"


def plot_designs(found: "Designs | DriveDesigns") -> Figure:
    """The designs over two objectives, a marker for each kind of wheel.

    Parameters
    ----------
    found : Designs or DriveDesigns
        What `escapement.design` or `escapement.design_drive` returns, with at least one design.

    Returns
    -------
    Figure
        The first objective along x, and the second, or else another figure, along y.
    """
    from escapement.inverse_design.requirement import BOUNDS
    from escapement.study.plan import unit_kind

    usual = ("mass", "size") if "mass" in found.designs[0].values else found.designs[0].values
    names = [*dict.fromkeys((*found.requirement.objectives, *usual))][:2]
    # a single figure stands over itself
    names = [*names, names[0]][:2]
    drawn = style.new_figure(style.ONE_COLUMN, 3.0)
    axes = style.new_panels(drawn, 1, 1)[0]
    columns, labels = [], []
    for name in names:
        values = np.array([one.values[name] for one in found.designs])
        kind = BOUNDS[name].unit if name in BOUNDS else unit_kind(name)
        scale, unit = readable(kind, values)
        columns.append(scale * values)
        labels.append((words(name), unit))
    wheels: list[Any] = [one.mechanism for one in found.designs]
    kinds = [(w.slots or 0, bool(getattr(w, "internal", False)), w.kind) for w in wheels]
    for marker, one in zip(_MARKERS, sorted(set(kinds)), strict=False):
        here = np.array([used == one for used in kinds])
        slots, internal, name = one
        label = f"{slots} slots" + ", internal" * internal if slots else name
        axes.plot(columns[0][here], columns[1][here], marker, color=style.BLUE, mfc="none",
                  label=label)  # fmt: skip
    finished(axes, labels[0], labels[1], 2)
    return drawn
