"""Figure of several designs side by side."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from escapement.plots import style
from escapement.plots.style import finished

if TYPE_CHECKING:
    from escapement.tolerance.side_by_side import Compared

_SLOPES = {
    "period_by_torque": "torque", "period_by_friction": "friction",
    "period_by_driver_inertia": "driver inertia", "period_by_follower_inertia": "follower inertia",
    "period_by_centre_distance": "centre distance",
}  # fmt: skip
_SHARES = {"friction_share": "friction", "blow_share": "blows"}
_PEAKS = {
    "acceleration_max": "driver\nacceleration", "follower_acceleration_max":
    "follower\nacceleration", "contact_force_max": "contact\nforce",
}  # fmt: skip


def plot_comparison(found: "Sequence[Compared]", names: Sequence[str] | None = None) -> Figure:
    """Sensitivities of the period, losses, and greatest accelerations and forces.

    Parameters
    ----------
    found : sequence of Compared
        What `escapement.compare` returns.
    names : sequence of str, optional
        Names of the designs. Default: their own.

    Returns
    -------
    Figure
        Groups of bars, one bar for each design. Accelerations and forces are over those of the
        first design that has them; those in blows are thin lines above their bars.
    """
    shown = [*names] if names else [one.name for one in found]
    drawn = style.new_figure(style.TWO_COLUMN, 5.6)
    grid = drawn.add_gridspec(2, 2)
    above, left, right = (drawn.add_subplot(grid[at]) for at in ((0, slice(None)), (1, 0), (1, 1)))
    for ax, keys in ((above, _SLOPES), (left, _SHARES), (right, _PEAKS)):
        style.dress(ax)
        bases = {
            key: next((x.values[key] for x in found if x.values[key] > 0.0), 1.0) for key in keys
        }
        wide = 0.8 / len(found)
        for k, one in enumerate(found):
            at = np.arange(len(keys)) + (k + 0.5) * wide - 0.4
            scale = [bases[key] if ax is right else 1.0 for key in keys]
            heights = [one.values[key] / base for key, base in zip(keys, scale, strict=True)]
            ax.bar(
                at,
                heights,
                0.9 * wide,
                color=style.LOOKS[k % len(style.LOOKS)].color,
                label=shown[k],
            )
            if ax is right:
                blows = [one.values[f"{key}_in_blows"] / bases[key] for key in keys]
                ax.plot(at, blows, "_", color=style.BLACK, ms=10)
        ax.set_xticks(range(len(keys)), [*keys.values()], fontsize=style.SMALL_SIZE)
    above.axhline(0.0, **style.ZERO)
    right.set_yscale("log")
    finished(above, ("", ""), ("% of period per %", ""), 1)
    finished(left, ("", ""), ("share of the work", ""), 1, legend=False)
    finished(right, ("", ""), ("over the first design", ""), 1, legend=False)
    return drawn
