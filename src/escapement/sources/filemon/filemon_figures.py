"""Filemon's figures 3 to 12 and 15: transmission, torque, and when the pin changes sides.

The wheels are external, with angles in degrees from dead centre. The number of slots is written
on each curve of a family, as in the paper.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.constant_speed import geneva, index, reversal_study
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.slotted import Transmission
from escapement.plots import style
from escapement.plots.style import label

SLOTS = np.arange(3, 11)
"""Numbers of slots of the families of curves."""
ANGLE = label("driver angle β", "°")
RATIO, RATE = r"$i_\omega$", r"$i_\varepsilon$"
LOAD_RATIO = r"Inertia ratio $F = I_f\,\omega^2/M_e$"
LIMITS = (r"$F_{12}$", r"$F_{23}$")
MARK: dict[str, Any] = {"ls": "", "marker": "o", "mfc": "white", "mec": style.BLACK, "mew": 0.9}
"""How a pin reversal is marked."""
Curve = tuple[FloatArray, FloatArray]
"""Abscissas and ordinates."""


def plot_transmission(slots: int = 4, ax: Axes | None = None) -> Axes:
    """Transmission function over an engagement (figure 3)."""
    ax, angle, table = _over_engagement(slots, f"Transmission {RATIO}", ax or style.new_axes())
    top = float(geneva.ratio_max(slots))
    ax.plot(angle, table.g, color=style.BLUE, lw=1.4)
    ax.plot(0.0, top, "v", color=style.BLACK, ms=5)
    name = rf"$i_{{\omega\,\mathrm{{max}}}}$ = {top:.3f}"
    style.annotate(ax, name, (0.0, top), (7.0, 0.0), "left")
    ax.set_ylim(0.0, 1.15 * top)
    return ax


def plot_transmission_family() -> Axes:
    """Transmission functions up to dead centre, logarithmic (figure 4)."""
    return _engagements("g", -2.0, ylabel=f"Transmission {RATIO}", ylim=(0.01, 10.0))


def plot_acceleration(slots: int = 4, ax: Axes | None = None) -> Axes:
    """Acceleration function over an engagement, with start and maximum (figure 5)."""
    ax, angle, table = _over_engagement(
        slots, f"Acceleration function {RATE}", ax or style.new_axes()
    )
    ax.plot(angle, table.dg, color=style.BLUE, lw=1.4)
    start, top = (float(f(slots)) for f in (geneva.acceleration_start, geneva.acceleration_max))
    marked = -np.degrees(float(geneva.acceleration_max_angle(slots)))
    ax.plot([angle[0], marked], [start, top], "o", color=style.BLACK, ms=4, clip_on=False, zorder=4)
    ax.vlines(marked, 0.0, top, color=style.GREY, lw=0.7, ls=":")
    name = rf"$i_{{\varepsilon s}}$ = {start:.3f}"
    style.annotate(ax, name, (angle[0], start), (6.0, -22.0), "left")
    name = rf"$i_{{\varepsilon\,\mathrm{{max}}}}$ = {top:.3f}"
    style.annotate(ax, f"{name}\nat −{-marked:.2f}°", (marked, top), (14.0, -4.0), "left")
    ax.set_ylim(-1.2 * top, 1.2 * top)
    return ax


def plot_acceleration_family() -> Axes:
    """Acceleration functions up to dead centre, logarithmic (figure 6)."""
    ax = _engagements("dg", -90.0, ylabel=f"Acceleration function {RATE}", ylim=(0.05, 50.0))
    tops = -np.degrees(geneva.acceleration_max_angle(SLOTS))
    ax.plot(tops, geneva.acceleration_max(SLOTS), label="maximum", ms=3.5, **MARK)
    style.add_legend(ax, 1, loc="upper left")
    return ax


def plot_torque_terms(slots: int = 4, ratio: float = 1.0) -> Axes:
    """Torque as the sum of the load's and the inertia's share (figure 7)."""
    ax, angle, table = _over_engagement(slots, "Function", style.new_axes(7.2, 3.8))
    product = ratio * table.g * table.dg
    name = r"$i_\omega i_\varepsilon$" if ratio == 1.0 else r"$F\, i_\omega i_\varepsilon$"
    terms = {RATIO: table.g, RATE: table.dg, name: product, r"$M_2 \eta / M_e$": table.g + product}
    # the sum has the first style and the widest line
    looks = (*style.LOOKS[1:4], style.LOOKS[0])
    for look, width, (text, values) in zip(looks, (1.1, 1.1, 1.1, 1.8), terms.items(), strict=True):
        ax.plot(angle, values, color=look.color, ls=look.linestyle, lw=width, label=text)
    found = np.degrees(reversal_study(slots, ratio).reversals)
    ax.plot(found, 0.0 * found, label="pin reversal", ms=5, zorder=5, **MARK)
    ax.set_title("")
    style.legend_above(ax, 5, f"n = {slots}, F = {ratio:g}")
    return ax


def plot_zones(slots: int = 8) -> Figure:
    """Torque in zones 1, 2 and 3, the inertia ratio growing (figure 8)."""
    figure = style.new_figure(style.TWO_COLUMN, 2.7)
    panels = style.new_panels(figure, 1, 3)
    for ax, ratio, letter in zip(panels, (1.0, 1.9, 4.0), "abc", strict=True):
        wheel = Geneva(slots, pins=1)
        result = index(wheel, 1.0, 1.0, follower_inertia=ratio)
        theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 721)
        angle, torque = np.degrees(theta), result.at(theta).torque
        ax.axhline(0.0, color=style.BLACK, lw=0.6)
        ax.plot(angle, torque, color=style.BLUE, lw=1.4)
        # shaded is where the follower drives the pin
        ax.fill_between(angle, torque, 0.0, where=torque < 0.0, color=style.SKY, alpha=0.5, lw=0)
        ax.plot(np.degrees(result.reversals), 0.0 * result.reversals, ms=5, zorder=5, **MARK)
        ax.set_title(f"{letter}  zone {result.zone}, F = {ratio:g}", fontsize=style.TICK_SIZE)
        ax.set(xlabel="β (°)", xlim=(angle[0], angle[-1]))
    panels[0].set_ylabel(r"Drive torque $M_2 \eta / M_e$")
    figure.suptitle(f"n = {slots}", fontsize=style.TICK_SIZE)
    return figure


def plot_reversal_curve(slots: int = 8) -> Axes:
    """Inertia ratios whose torque is zero at an angle, and the three zones (figure 9)."""
    ax = style.new_axes(style.TWO_COLUMN, 3.8)
    angle, ratio = _reversal(slots)
    lower, upper = (float(limit) for limit in geneva.reversal_limits(slots))
    steepest = np.degrees(float(geneva.acceleration_max_angle(slots)))
    ax.axhspan(lower, upper, color=style.SKY, alpha=0.25, lw=0)
    ax.plot(angle, ratio, color=style.BLUE, lw=1.5)
    # F12 touches the curve at its lowest point, F23 is where it ends
    for name, limit, marked in zip(LIMITS, (lower, upper), (steepest, angle[-1]), strict=True):
        ax.axhline(limit, color=style.BLACK, lw=0.8, ls=(0, (5, 2)))
        ax.plot(marked, limit, clip_on=False, ms=5, zorder=5, **MARK)
        style.annotate(ax, f"{name} = {limit:.4f}", (2.0, limit), (0.0, 7.0), "left")
    heights = {"1: no reversal": 0.55 * lower, "2: two reversals": 0.5 * (lower + upper)}
    for zone, height in (heights | {"3: one reversal": 1.5 * upper}).items():
        style.annotate(ax, f"zone {zone}", (0.55 * angle[-1], height))
    ax.set(xlabel=ANGLE, ylabel=LOAD_RATIO, xlim=(0.0, angle[-1]), ylim=(0.0, 2.0 * upper))
    ax.set_title(f"n = {slots}", fontsize=style.TICK_SIZE)
    return ax


def plot_reversal_curves() -> Axes:
    """The same for a family of wheels, logarithmic (figure 10)."""
    ax = _family(_reversal, "y", offset=(0.0, -9.0))
    ax.set(xlabel=ANGLE, ylabel=LOAD_RATIO, xlim=(0.0, 75.0), ylim=(0.02, 20.0))
    angles = geneva.acceleration_max_angle(SLOTS), geneva.engagement_half(SLOTS)
    limits = geneva.reversal_limits(SLOTS)
    meanings = ("no reversal below", "one reversal from here on")
    for at, limit, name, meaning, marker in zip(
        angles, limits, LIMITS, meanings, "os", strict=True
    ):
        mark = MARK | {"marker": marker}
        ax.plot(np.degrees(at), limit, label=f"{name}: {meaning}", ms=3.5, zorder=5, **mark)
    style.add_legend(ax, 1, "Beside the curves: slots n", loc="lower right")
    return ax


def plot_reversal_limits(ax: Axes | None = None) -> Axes:
    """Limits of the zones against the number of slots (figure 11)."""
    lower, upper = geneva.reversal_limits(SLOTS)
    ax = _over_slots(dict(zip(LIMITS, (lower, upper), strict=True)), ax)
    # between both limits, in zone 2, the pin changes sides twice
    ax.fill_between(SLOTS, lower, upper, color=style.SKY, alpha=0.25, lw=0)
    # names stand where their zones are wide enough, about 7 slots
    low, high = float(lower[4]), float(upper[4])
    heights = {"zone 3": 1.45 * high, "2": 0.5 * (low + high), "zone 1": 0.35 * low}
    for row, (name, height) in enumerate(heights.items(), 6):
        style.annotate(ax, name, (row, height))
    ax.set(ylabel=LOAD_RATIO, ylim=(0.0, None))
    return ax


def plot_mean_factors(ax: Axes | None = None) -> Axes:
    """Factors D and A of the mean torque against the number of slots (figure 12)."""
    ax = _over_slots(dict(zip("DA", geneva.mean_factors(SLOTS), strict=True)), ax)
    ax.set(ylabel="Factors D and A", yscale="log", ylim=(0.1, 30.0))
    ax.yaxis.set_major_formatter("{x:g}")
    return ax


def plot_maximum_angles() -> Axes:
    """Angle of the greatest torque against the inertia ratio (figure 15).

    Dotted: the limits for great inertia ratios, from the corrected (12).
    """
    ratio = np.geomspace(0.02, 20.0, 200)

    def curve(n: int) -> Curve:
        return ratio, -np.degrees(reversal_study(n, ratio).torque_max_angle)

    ax = _family(curve, "x", offset=(-9.0, 0.0))
    ax.set(xlabel=LOAD_RATIO, ylabel="Greatest torque before\ndead centre, −β* (°)")
    ax.set(xlim=(0.02, 20.0), ylim=(0.0, 26.0))
    for limit in -np.degrees(geneva.limit_angle(SLOTS)):
        ax.axhline(limit, color=style.GREY, lw=0.7, ls=":")
    ax.axvline(8.0, color=style.BLACK, lw=0.7, ls=(0, (5, 2)))
    style.annotate(ax, "F = 8", (8.0, 1.2))
    ax.set_title("n on the curves; dotted: limit for F → ∞", fontsize=style.SMALL_SIZE)
    return ax


FIGURES: dict[int, Callable[[], Axes | Figure]] = {
    3: plot_transmission, 4: plot_transmission_family, 5: plot_acceleration,
    6: plot_acceleration_family, 7: plot_torque_terms, 8: plot_zones, 9: plot_reversal_curve,
    10: plot_reversal_curves, 11: plot_reversal_limits, 12: plot_mean_factors,
    15: plot_maximum_angles,
}  # fmt: skip
"""The function that draws each figure of the paper."""


def _engagement(slots: int, share: float = 1.0) -> tuple[FloatArray, Transmission]:
    """Angles [degrees] from pin entry to `share` of the exit, and the transmission there."""
    wheel = Geneva(slots, pins=1)
    theta = np.linspace(wheel.breaks[0], share * wheel.breaks[-1], 500)
    return np.degrees(theta), wheel.transmission(theta)


def _over_engagement(slots: int, name: str, ax: Axes) -> tuple[Axes, FloatArray, Transmission]:
    """Axes of an engagement, with a line at zero, and what `_engagement` gives for them."""
    angle, table = _engagement(slots)
    ax.axhline(0.0, color=style.BLACK, lw=0.6)
    ax.set(xlabel=ANGLE, ylabel=name, xlim=(angle[0], angle[-1]))
    ax.set_title(f"n = {slots}", fontsize=style.TICK_SIZE)
    return ax, angle, table


def _reversal(slots: int) -> Curve:
    """Angles [degrees] after dead centre, and the F that makes the torque zero there (7)."""
    # at dead centre no F does
    angle = np.linspace(0.0, float(geneva.engagement_half(slots)), 601)[1:]
    return np.degrees(angle), -1.0 / geneva.acceleration(slots, angle)


def _engagements(name: str, marked: float, **labels: Any) -> Axes:
    """A family of curves from pin entry, dotted, to dead centre."""

    def curve(n: int) -> Curve:
        angle, table = _engagement(n, 0.0)
        values = getattr(table, name)
        # both functions vanish at one end of the half, where the logarithm does not exist
        return angle[values > 1e-9], values[values > 1e-9]

    ax = _family(curve, "y", marked)
    starts = np.degrees(geneva.engagement_half(SLOTS))
    for start in starts:
        ax.axvline(-start, color=style.GREY, lw=0.5, ls=":")
    ax.set(xlabel=ANGLE, xlim=(-75.0, 0.0), **labels)
    text = " ".join(f"{start:.4g}°" for start in starts)
    title = f"n on the curves; β₀ for n = {SLOTS[0]} to {SLOTS[-1]}: {text}"
    ax.set_title(title, fontsize=style.SMALL_SIZE)
    return ax


def _family(
    curve: Callable[[int], Curve],
    logarithmic: str,
    marked: float = np.inf,
    offset: tuple[float, float] = (0.0, 0.0),
) -> Axes:
    """A curve for each number of slots, which is written at a given abscissa or at the end."""
    ax = style.new_axes(style.TWO_COLUMN, 4.6)
    style.grid(ax)
    ax.set(**{f"{logarithmic}scale": "log"})
    getattr(ax, f"{logarithmic}axis").set_major_formatter("{x:g}")
    for n in SLOTS.tolist():
        x, y = curve(n)
        ax.plot(x, y, color=style.BLUE, lw=1.1)
        i = min(int(np.searchsorted(x, marked)), x.size - 1)
        style.annotate(ax, str(n), (float(x[i]), float(y[i])), offset)
    return ax


def _over_slots(lines: dict[str, FloatArray], ax: Axes | None) -> Axes:
    """Named values against the number of slots, which is a whole number."""
    ax = ax or style.new_axes(style.ONE_COLUMN, 3.2)
    style.grid(ax)
    for look, (name, values) in zip(style.LOOKS, lines.items(), strict=False):
        drawn: dict[str, Any] = {**look._asdict(), "lw": 1.2, "ms": 4, "mfc": "white"}
        ax.plot(SLOTS, values, label=name, clip_on=False, **drawn)
    ax.set(xlabel="Number of slots n", xlim=(SLOTS[0], SLOTS[-1]), xticks=SLOTS)
    style.legend_above(ax, 2)
    return ax
