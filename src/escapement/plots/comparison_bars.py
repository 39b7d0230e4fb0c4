"""Figure of several designs side by side."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from escapement.base.text import words
from escapement.plots import style
from escapement.plots.style import finished

if TYPE_CHECKING:
    from escapement.tolerance.side_by_side import Compared

_SLOPES = {
    "period_by_torque": "torque", "period_by_friction": "friction",
    "period_by_driver_inertia": "driver inertia", "period_by_follower_inertia": "follower inertia",
    "period_by_centre_distance": "centre distance",
}  # fmt: skip
_SHARES = {
    "friction_share": "work lost\nin friction", "blow_share": "work lost\nin blows",
    "period_with_rebound": "change of period\nwith restitution",
}  # fmt: skip
_OVER = {
    "period": "period", "rise_time": "rise", "turn_deg": "turn in\na period",
    "acceleration_max": "driver\nacceleration", "follower_acceleration_max":
    "follower\nacceleration", "contact_force_max": "contact\nforce",
}  # fmt: skip


def plot_comparison(found: "Sequence[Compared]", names: Sequence[str] | None = None) -> Figure:
    """Sensitivities of the period, shares of work and yields, and what scales with a design.

    Parameters
    ----------
    found : sequence of Compared
        What `escapement.compare` returns.
    names : sequence of str, optional
        Names of the designs. Default: their own.

    Returns
    -------
    Figure
        Groups of bars, one bar for each design. The last panel has values over those of the first
        design that has them; those in blows are thin lines above their bars.
    """
    shown = [*names] if names else [one.name for one in found]
    yields = {key: words(key) for one in found for key in one.values if key.startswith("yield_")}
    shares = _SHARES | yields
    panels = (_SLOPES, "% of period per %"), (shares, "share"), (_OVER, "over the first design")
    drawn = style.new_figure(style.TWO_COLUMN, 7.6)
    for ax, (keys, label) in zip(drawn.subplots(3, 1), panels, strict=True):
        style.dress(ax)
        relative = keys is _OVER
        above = ((x for one in found if (x := one.values.get(key, 0.0)) > 0.0) for key in keys)
        bases = [next(values, 1.0) if relative else 1.0 for values in above]
        wide = 0.8 / len(found)
        for k, one in enumerate(found):
            at = np.arange(len(keys)) + (k + 0.5) * wide - 0.4
            heights = [one.values.get(key, np.nan) / x for key, x in zip(keys, bases, strict=True)]
            look = {"color": style.LOOKS[k % len(style.LOOKS)].color, "label": shown[k]}
            ax.bar(at, heights, 0.9 * wide, **look)
            if relative:
                blows = [one.values.get(f"{key}_in_blows", np.nan) for key in keys]
                ax.plot(at, np.divide(blows, bases), "_", color=style.BLACK, ms=10)
        ax.set_xticks(range(len(keys)), [*keys.values()], fontsize=style.SMALL_SIZE)
        if relative:
            ax.set_yscale("log")
        ax.axhline(float(relative), **style.ZERO)
        finished(ax, ("", ""), (label, ""), len(found), legend=keys is _SLOPES)
    return drawn
