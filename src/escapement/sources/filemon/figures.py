"""Filemon's figures 3 to 12 and 15: transmission, torque, and when the pin changes sides.

External wheels; angles in degrees from dead centre. Families of curves have their
number of slots written on them, as in the paper.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator, StrMethodFormatter

from escapement.constant_speed import drive_torque, geneva, reversal_study
from escapement.mechanisms import Geneva
from escapement.mechanisms.slotted import Transmission
from escapement.model import FloatArray
from escapement.plots import style
from escapement.plots.style import label

SLOTS = tuple(range(3, 11))
"""Numbers of slots of the families of curves."""
ANGLE = label("driver angle β", "°")
RATIO, RATE, LOAD_RATIO = r"$i_\omega$", r"$i_\varepsilon$", r"$F$"
MARK: dict[str, Any] = {"ls": "", "marker": "o", "mfc": "white", "mec": style.BLACK, "mew": 0.9}
"""How a pin reversal is marked."""
Curve = Callable[[int], tuple[FloatArray, FloatArray]]
"""From a number of slots to the places and heights of a curve."""


def plot_transmission(slots: int = 4, ax: Axes | None = None) -> Axes:
    """Transmission function over an engagement (figure 3)."""
    ax, angle, table = _over_engagement(slots, RATIO, ax or style.new_axes())
    top = float(geneva.ratio_max(slots))
    ax.plot(angle, table.g, color=style.BLUE, lw=1.4)
    ax.plot(0.0, top, "v", color=style.BLACK, ms=5)
    name = rf"$i_{{\omega\,\mathrm{{max}}}}$ = {top:.3f}"
    style.annotate(ax, name, (0.0, top), (7.0, 0.0), "left")
    ax.set_ylim(0.0, 1.15 * top)
    ax.set_title(f"n = {slots}", fontsize=style.TICK_SIZE)
    return ax


def plot_transmission_family(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """Transmission functions up to dead centre, logarithmic (figure 4)."""
    ax = _engagements(slots, lambda table: table.g, ax, -2.0)
    ax.set(ylabel=RATIO, ylim=(0.01, 10.0))
    return ax


def plot_acceleration(slots: int = 4, ax: Axes | None = None) -> Axes:
    """Acceleration function over an engagement, with start and maximum (figure 5)."""
    ax, angle, table = _over_engagement(slots, RATE, ax or style.new_axes())
    ax.plot(angle, table.dg, color=style.BLUE, lw=1.4)
    start, top = (float(f(slots)) for f in (geneva.acceleration_start, geneva.acceleration_max))
    place = -np.degrees(float(geneva.acceleration_max_angle(slots)))
    ax.plot([angle[0], place], [start, top], "o", color=style.BLACK, ms=4, clip_on=False, zorder=4)
    ax.plot([place, place], [0.0, top], color=style.GREY, lw=0.7, ls=":")
    name = rf"$i_{{\varepsilon s}}$ = {start:.3f}"
    style.annotate(ax, name, (angle[0], start), (6.0, -22.0), "left")
    name = rf"$i_{{\varepsilon\,\mathrm{{max}}}}$ = {top:.3f}"
    style.annotate(ax, f"{name}\nat −{-place:.2f}°", (place, top), (14.0, -4.0), "left")
    ax.set_ylim(-1.2 * top, 1.2 * top)
    ax.set_title(f"n = {slots}", fontsize=style.TICK_SIZE)
    return ax


def plot_acceleration_family(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """Acceleration functions up to dead centre, logarithmic (figure 6)."""
    ax = _engagements(slots, lambda table: table.dg, ax, -90.0)
    tops = -np.degrees(geneva.acceleration_max_angle(slots))
    ax.plot(tops, geneva.acceleration_max(slots), label="maximum", ms=3.5, **MARK)
    ax.set(ylabel=RATE, ylim=(0.05, 50.0))
    ax.legend(loc="upper left", fontsize=style.SMALL_SIZE, frameon=False)
    return ax


def plot_torque_terms(slots: int = 4, ratio: float = 1.0, ax: Axes | None = None) -> Axes:
    """Torque as the sum of the load's and the inertia's share (figure 7)."""
    ax, angle, table = _over_engagement(slots, "Function", ax or style.new_axes(7.2, 3.8))
    product = ratio * table.g * table.dg
    name = r"$i_\omega i_\varepsilon$" if ratio == 1.0 else r"$F\, i_\omega i_\varepsilon$"
    terms = {RATIO: table.g, RATE: table.dg, name: product, r"$M_2 \eta / M_e$": table.g + product}
    # the sum has the first look and the widest line
    looks = (*style.LOOKS[1:4], style.LOOKS[0])
    for look, (text, values) in zip(looks, terms.items(), strict=True):
        width = 1.8 if look is style.LOOKS[0] else 1.1
        ax.plot(angle, values, color=look.color, ls=look.linestyle, lw=width, label=text)
    reversals = np.degrees(reversal_study(slots, ratio).reversals)
    ax.plot(reversals, np.zeros_like(reversals), label="pin reversal", ms=5, zorder=5, **MARK)
    style.legend_above(ax, 5, f"n = {slots}, F = {ratio:g}")
    return ax


def plot_zones(slots: int = 8, ratios: Sequence[float] = (1.0, 1.9, 4.0)) -> Figure:
    """Torque in zones 1, 2 and 3, the inertia ratio growing (figure 8)."""
    figure = style.new_figure(style.TWO_COLUMN, 2.7)
    panels = figure.subplots(1, len(ratios))
    for ax, ratio, letter in zip(panels, ratios, "abc", strict=False):
        result = drive_torque(Geneva(slots, pins=1), 1.0, 1.0, ratio)
        angle, torque = np.degrees(result.samples.theta), result.samples.torque
        style.dress(ax).axhline(0.0, color=style.BLACK, lw=0.6)
        ax.plot(angle, torque, color=style.BLUE, lw=1.4)
        # shaded is where the follower drives the pin
        ax.fill_between(angle, torque, 0.0, where=torque < 0.0, color=style.SKY, alpha=0.5, lw=0)
        found = np.degrees(result.reversals)
        ax.plot(found, np.zeros_like(found), ms=5, zorder=5, **MARK)
        ax.set_title(f"{letter}  zone {result.zone}, F = {ratio:g}", fontsize=style.TICK_SIZE)
        ax.set(xlabel="β (°)", xlim=(angle[0], angle[-1]))
    panels[0].set_ylabel(r"$M_2 \eta / M_e$")
    figure.suptitle(f"n = {slots}", fontsize=style.TICK_SIZE)
    return figure


def plot_reversal_curve(slots: int = 8, ax: Axes | None = None) -> Axes:
    """Inertia ratios whose torque is zero at an angle, and the three zones (figure 9)."""
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.8)
    angle, ratio = _reversal(slots)
    lower, upper = (float(limit) for limit in geneva.reversal_limits(slots))
    steepest = np.degrees(float(geneva.acceleration_max_angle(slots)))
    ax.axhspan(lower, upper, color=style.SKY, alpha=0.25, lw=0)
    ax.plot(angle, ratio, color=style.BLUE, lw=1.5)
    # F12 touches the curve at its lowest point, F23 is where it ends
    for limit, name, place in ((lower, "12", steepest), (upper, "23", angle[-1])):
        ax.axhline(limit, color=style.BLACK, lw=0.8, ls=(0, (5, 2)))
        ax.plot(place, limit, clip_on=False, ms=5, zorder=5, **MARK)
        style.annotate(ax, rf"$F_{{{name}}}$ = {limit:.4f}", (2.0, limit), (0.0, 7.0), "left")
    heights = (0.55 * lower, 0.5 * (lower + upper), 1.5 * upper)
    zones = ("1: no reversal", "2: two reversals", "3: one reversal")
    for height, text in zip(heights, zones, strict=True):
        style.annotate(ax, f"zone {text}", (0.55 * angle[-1], height))
    ax.set(xlabel=ANGLE, ylabel=LOAD_RATIO, xlim=(0.0, angle[-1]), ylim=(0.0, 2.0 * upper))
    ax.set_title(f"n = {slots}", fontsize=style.TICK_SIZE)
    return ax


def plot_reversal_curves(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """The same for a family of wheels, logarithmic (figure 10)."""
    ax = _family(slots, _reversal, "y", ax, offset=(0.0, -9.0))
    places = geneva.acceleration_max_angle(slots), geneva.engagement_half(slots)
    limits = geneva.reversal_limits(slots)
    for at, limit, name, marker in zip(places, limits, ("12", "23"), "os", strict=True):
        mark = MARK | {"ms": 3.5, "zorder": 5, "marker": marker, "label": rf"$F_{{{name}}}$"}
        ax.plot(np.degrees(at), limit, **mark)
    ax.set(xlabel=ANGLE, ylabel=LOAD_RATIO, xlim=(0.0, 75.0), ylim=(0.02, 20.0))
    style.add_legend(ax, 1, "Beside the curves: slots n", loc="lower right")
    return ax


def plot_reversal_limits(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """Limits of the zones against the number of slots (figure 11)."""
    lower, upper = geneva.reversal_limits(slots)
    ax = _over_slots(slots, {r"$F_{12}$": lower, r"$F_{23}$": upper}, ax)
    # between both limits, in zone 2, the pin changes sides twice
    ax.fill_between(slots, lower, upper, color=style.SKY, alpha=0.25, lw=0)
    # names stand where their zones are wide enough
    i = len(slots) // 2
    style.annotate(ax, "zone 1", (slots[i] + 1.0, 0.35 * float(lower[i])))
    style.annotate(ax, "2", (slots[i], 0.5 * float(lower[i] + upper[i])))
    style.annotate(ax, "zone 3", (slots[i] - 1.0, 1.45 * float(upper[i])))
    ax.set(ylabel=LOAD_RATIO, ylim=(0.0, None))
    return ax


def plot_mean_factors(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """Factors D and A of the mean torque against the number of slots (figure 12)."""
    ax = _over_slots(slots, dict(zip("DA", geneva.mean_factors(slots), strict=True)), ax)
    ax.set(ylabel="D and A", yscale="log", ylim=(0.1, 30.0))
    ax.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    return ax


def plot_maximum_angles(slots: Sequence[int] = SLOTS, ax: Axes | None = None) -> Axes:
    """Angle of the greatest torque against the inertia ratio (figure 15).

    Dotted: the limits for great inertia ratios, from the corrected (12).
    """
    ratio = np.geomspace(0.02, 20.0, 200)

    def place(n: int) -> tuple[FloatArray, FloatArray]:
        return ratio, -np.degrees(reversal_study(n, ratio).torque_max_angle)

    ax = _family(slots, place, "x", ax, offset=(-9.0, 0.0))
    for limit in -np.degrees(geneva.limit_angle(slots)):
        ax.axhline(limit, color=style.GREY, lw=0.7, ls=":")
    ax.axvline(8.0, color=style.BLACK, lw=0.7, ls=(0, (5, 2)))
    style.annotate(ax, "F = 8", (8.0, 1.2))
    ax.set(xlabel=LOAD_RATIO, ylabel="Greatest torque before\ndead centre, −β* (°)")
    ax.set(xlim=(0.02, 20.0), ylim=(0.0, 26.0))
    ax.set_title("n on the curves; dotted: limit for F → ∞", fontsize=style.SMALL_SIZE)
    return ax


FIGURES: dict[int, Callable[[], Axes | Figure]] = {
    3: plot_transmission,
    4: plot_transmission_family,
    5: plot_acceleration,
    6: plot_acceleration_family,
    7: plot_torque_terms,
    8: plot_zones,
    9: plot_reversal_curve,
    10: plot_reversal_curves,
    11: plot_reversal_limits,
    12: plot_mean_factors,
    15: plot_maximum_angles,
}
"""What draws each figure of the paper."""


def engagement(slots: int, share: float = 1.0) -> tuple[FloatArray, Transmission]:
    """Angles [degrees] from pin entry to `share` of the exit, and the transmission there."""
    wheel = Geneva(slots, pins=1)
    theta = np.linspace(wheel.breaks[0], share * wheel.breaks[-1], 500)
    return np.degrees(theta), wheel.transmission(theta)


def _over_engagement(slots: int, name: str, ax: Axes) -> tuple[Axes, FloatArray, Transmission]:
    """Axes of an engagement, with a line at zero, and what `engagement` gives for them."""
    angle, table = engagement(slots)
    ax.axhline(0.0, color=style.BLACK, lw=0.6)
    ax.set(xlabel=ANGLE, ylabel=name, xlim=(angle[0], angle[-1]))
    return ax, angle, table


def _reversal(slots: int) -> tuple[FloatArray, FloatArray]:
    """Angles [degrees] after dead centre, and the F that makes the torque zero there (7)."""
    # at dead centre no F does
    angle = np.linspace(0.0, float(geneva.engagement_half(slots)), 601)[1:]
    return np.degrees(angle), -1.0 / geneva.acceleration(slots, angle)


def _engagements(
    slots: Sequence[int],
    read: Callable[[Transmission], FloatArray],
    ax: Axes | None,
    place: float,
) -> Axes:
    """A family of curves from pin entry, dotted, to dead centre."""

    def curve(n: int) -> tuple[FloatArray, FloatArray]:
        angle, table = engagement(n, 0.0)
        # both functions vanish at one end of the half, where the logarithm does not exist
        inside = read(table) > 1e-9
        return angle[inside], read(table)[inside]

    ax = _family(slots, curve, "y", ax, place)
    starts = np.degrees(geneva.engagement_half(slots))
    for start in starts:
        ax.axvline(-start, color=style.GREY, lw=0.5, ls=":")
    ax.set(xlabel=ANGLE, xlim=(-75.0, 0.0))
    text = " ".join(f"{start:.4g}°" for start in starts)
    title = f"n on the curves; β₀ for n = {slots[0]} to {slots[-1]}: {text}"
    ax.set_title(title, fontsize=style.SMALL_SIZE)
    return ax


def _family(
    slots: Iterable[int],
    curve: Curve,
    logarithmic: str,
    ax: Axes | None,
    place: float = np.inf,
    offset: tuple[float, float] = (0.0, 0.0),
) -> Axes:
    """A curve a number of slots, which stands at a place of the abscissa, else at the end."""
    ax = ax or style.new_axes(style.TWO_COLUMN, 4.6)
    style.grid(ax)
    ax.set(**{f"{logarithmic}scale": "log"})
    getattr(ax, f"{logarithmic}axis").set_major_formatter(StrMethodFormatter("{x:g}"))
    for n in slots:
        x, y = curve(n)
        ax.plot(x, y, color=style.BLUE, lw=1.1)
        i = min(int(np.searchsorted(x, place)), x.size - 1)
        style.annotate(ax, str(n), (float(x[i]), float(y[i])), offset)
    return ax


def _over_slots(slots: Sequence[int], lines: dict[str, FloatArray], ax: Axes | None) -> Axes:
    """Named values against the number of slots, which is a whole number."""
    ax = ax or style.new_axes(style.ONE_COLUMN, 3.2)
    style.grid(ax)
    for look, (name, values) in zip(style.LOOKS, lines.items(), strict=False):
        drawn: dict[str, Any] = {"color": look.color, "ls": look.linestyle, "lw": 1.2, "ms": 4}
        ax.plot(slots, values, marker=look.marker, mfc="white", label=name, clip_on=False, **drawn)
    ax.set(xlabel="Number of slots n", xlim=(slots[0], slots[-1]))
    ax.xaxis.set_major_locator(MultipleLocator(1))
    style.legend_above(ax, 2)
    return ax
