"""Filemon's figures 9 to 12 and 15: when the pin changes sides, and the maximum's place."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator, StrMethodFormatter

from escapement.constant_speed import geneva, reversal_study
from escapement.model import FloatArray
from escapement.plots import style
from escapement.sources.filemon.figures import ANGLE, LOAD_RATIO, MARK, SLOTS

_POINTS = 600


def plot_reversal_curve(slots: int = 8, ax: Axes | None = None) -> Axes:
    """Inertia ratios whose torque is zero at an angle, and the three zones (figure 9)."""
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.8)
    angle, ratio = _curve(slots)
    limits = [float(limit) for limit in geneva.reversal_limits(slots)]
    steepest = np.degrees(float(geneva.acceleration_max_angle(slots)))
    top = 2.0 * limits[1]
    ax.axhspan(limits[0], limits[1], color=style.SKY, alpha=0.25, lw=0)
    ax.plot(angle, ratio, color=style.BLUE, lw=1.5)
    for limit, name, place in zip(limits, ("12", "23"), (steepest, angle[-1]), strict=True):
        ax.axhline(limit, color=style.BLACK, lw=0.8, ls=(0, (5, 2)))
        ax.plot(place, limit, clip_on=False, **MARK)
        style.annotate(ax, rf"$F_{{{name}}}$ = {limit:.4f}", (2.0, limit), (0.0, 7.0), "left")
    heights = (0.55 * limits[0], 0.5 * sum(limits), 0.5 * (limits[1] + top))
    texts = ("1: no reversal", "2: two reversals", "3: one reversal")
    for height, text in zip(heights, texts, strict=True):
        style.annotate(ax, f"zone {text}", (0.55 * angle[-1], height))
    ax.set(xlabel=ANGLE, ylabel=LOAD_RATIO, xlim=(0.0, angle[-1]), ylim=(0.0, top))
    ax.set_title(f"n = {slots}", fontsize=style.TICK_SIZE)
    return ax


def plot_reversal_curves(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """The same for a family of wheels, logarithmic (figure 10)."""
    ax = ax or style.new_axes(style.TWO_COLUMN, 4.6)
    style.grid(ax)
    ax.set_yscale("log")
    for n in slots:
        angle, ratio = _curve(n)
        ax.plot(angle, ratio, color=style.BLUE, lw=1.1)
        style.annotate(ax, str(n), (angle[-1], ratio[-1]), (0.0, -9.0))
    places = [np.degrees(float(geneva.acceleration_max_angle(n))) for n in slots]
    ends = [np.degrees(float(geneva.engagement_half(n))) for n in slots]
    limits = np.array([[float(limit) for limit in geneva.reversal_limits(n)] for n in slots]).T
    for at, limit, name, marker in zip((places, ends), limits, ("12", "23"), "os", strict=True):
        ax.plot(at, limit, label=rf"$F_{{{name}}}$", **(MARK | {"ms": 3.5, "marker": marker}))
    ax.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    ax.set(xlabel=ANGLE, ylabel=LOAD_RATIO, xlim=(0.0, 75.0), ylim=(0.02, 20.0))
    small = {"fontsize": style.SMALL_SIZE, "title_fontsize": style.SMALL_SIZE}
    ax.legend(loc="lower right", title="Beside the curves: slots n", frameon=False, **small)
    return ax


def plot_reversal_limits(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """Limits of the zones against the number of slots (figure 11)."""
    ax = ax or style.new_axes(style.ONE_COLUMN, 3.2)
    n = np.array(slots)
    lower, upper = geneva.reversal_limits(n)
    style.grid(ax)
    ax.fill_between(n, lower, upper, color=style.SKY, alpha=0.25, lw=0)
    for values, name, look in ((upper, "23", style.LOOKS[1]), (lower, "12", style.LOOKS[0])):
        ax.plot(
            n, values, color=look.color, ls=look.linestyle, marker=look.marker, ms=4, mfc="white",
            lw=1.2, label=rf"$F_{{{name}}}$", clip_on=False,
        )  # fmt: skip
    middle = n[n.size // 2]
    heights = 0.5 * (lower + upper)[n.size // 2], 0.35 * lower[n.size // 2]
    style.annotate(ax, "2", (float(middle), float(heights[0])))
    style.annotate(ax, "zone 1", (float(middle) + 1.0, float(heights[1])))
    style.annotate(ax, "zone 3", (float(middle) - 1.0, float(1.45 * upper[n.size // 2])))
    ax.set(xlabel="Number of slots n", ylabel=LOAD_RATIO, xlim=(n[0], n[-1]), ylim=(0.0, None))
    ax.xaxis.set_major_locator(MultipleLocator(1))
    style.legend_above(ax, 2)
    return ax


def plot_mean_factors(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """Factors D and A of the mean torque against the number of slots (figure 12)."""
    ax = ax or style.new_axes(style.ONE_COLUMN, 3.2)
    n = np.array(slots)
    style.grid(ax)
    for values, name, look in zip(geneva.mean_factors(n), "DA", style.LOOKS, strict=False):
        ax.plot(
            n, values, color=look.color, ls=look.linestyle, marker=look.marker, ms=4, mfc="white",
            lw=1.2, label=name, clip_on=False,
        )  # fmt: skip
    ax.set_yscale("log")
    ax.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    ax.set(xlabel="Number of slots n", ylabel="D and A", xlim=(n[0], n[-1]), ylim=(0.1, 30.0))
    ax.xaxis.set_major_locator(MultipleLocator(1))
    style.legend_above(ax, 2)
    return ax


def plot_maximum_angles(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """Angle of the greatest torque against the inertia ratio (figure 15).

    Dotted: the limits for great inertia ratios, from the corrected (12).
    """
    ax = ax or style.new_axes(style.TWO_COLUMN, 4.6)
    style.grid(ax)
    ratio = np.geomspace(0.02, 20.0, 200)
    for n in slots:
        place = -np.degrees(reversal_study(n, ratio).torque_max_angle)
        ax.plot(ratio, place, color=style.BLUE, lw=1.1)
        ax.axhline(-float(np.degrees(geneva.limit_angle(n))), color=style.GREY, lw=0.7, ls=":")
        style.annotate(ax, str(n), (ratio[-1], float(place[-1])), (-9.0, 0.0))
    ax.axvline(8.0, color=style.BLACK, lw=0.7, ls=(0, (5, 2)))
    style.annotate(ax, "F = 8", (8.0, 1.2))
    ax.set_xscale("log")
    ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    ax.set(xlabel=LOAD_RATIO, ylabel="Greatest torque before\ndead centre, −β* (°)")
    ax.set(xlim=(0.02, 20.0), ylim=(0.0, 26.0))
    ax.set_title("n on the curves; dotted: limit for F → ∞", fontsize=style.SMALL_SIZE)
    return ax


def _curve(slots: int) -> tuple[FloatArray, FloatArray]:
    """Angles [degrees] after dead centre, and the F that makes the torque zero there (7)."""
    end = float(geneva.engagement_half(slots))
    angle = np.linspace(0.0, end, _POINTS + 1)[1:]
    return np.degrees(angle), -1.0 / geneva.acceleration(slots, angle)
