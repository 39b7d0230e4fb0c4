"""The effect of errors of parts on the period: table and figures of the page on them.

`python -m pages.imperfect`, called in docs, prints the table.
"""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import escapement as esc
from escapement import plots
from escapement.base.units import INCH_POUND
from escapement.plots import style
from escapement.sources import meyer
from pages import drawn
from pages.effects import CRANK, TORQUES

FRICTION = 0.25
SMALL = 1e-4
KINDS = {"overlap": "o", "pick-up": "^", "strike": "s"}
WHEELS = (3, 4, 6)


def first(size: float, count: int) -> tuple[float, ...]:
    """Errors of `count` parts, of which only the second has one."""
    return tuple(size if k == 1 else 0.0 for k in range(count))


def wheel(slots: int, kind: str, size: float) -> esc.Geneva:
    """A wheel with one error; lengths are shares of the centre distance or of the crank radius."""
    plain = esc.Geneva(slots, crank_radius=CRANK)
    errors: dict[str, Any] = {
        "axes too far apart": ("centre_distance_error", size * CRANK * plain.centre_distance),
        "one pin late": ("pin_angle_errors", first(size, plain.pins)),
        "one slot ahead": ("slot_angle_errors", first(size, slots)),
        "one pin's crank too long": ("crank_radius_errors", first(size * CRANK, plain.pins)),
        "one slot's line ahead of the axis": ("slot_offsets", first(size * CRANK, slots)),
    }
    name, value = errors[kind]
    return replace(plain, **{name: value})


ERRORS = (
    *("axes too far apart", "one pin late", "one slot ahead"),
    *("one pin's crank too long", "one slot's line ahead of the axis"),
)


def cycle(slots: int, kind: str, size: float) -> esc.Figures:
    """Terminal cycle of Meyer's mechanism with one error."""
    inertia = esc.Inertia(*(value * INCH_POUND for value in meyer.INERTIAS[slots]))
    torque = TORQUES[slots] * INCH_POUND
    return esc.terminal(esc.Escapement(wheel(slots, kind, size), inertia, torque, FRICTION))


def change(slots: int, kind: str, size: float) -> float:
    """Relative change of the mean period."""
    return cycle(slots, kind, size).period / cycle(slots, kind, 0.0).period - 1.0


def table() -> str:
    """Change of the period for an error of a thousandth, and for the opposite error."""
    heads = [f"n = {slots}, {sign}" for slots in WHEELS for sign in ("+", "-")]
    lines = [["change of the period (%)", *heads], ["---"] * (1 + len(heads))]
    for kind in ERRORS:
        found = [100.0 * change(n, kind, way * 1e-3) for n in WHEELS for way in (1.0, -1.0)]
        lines.append([kind, *(f"{value:+.3f}" for value in found)])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


@drawn
def imperfect_response() -> Figure:
    """Period against each of three errors, with the kinds of handoff."""
    figure = style.new_figure(style.TWO_COLUMN, 3.3)
    sizes = 1e-3 * np.linspace(-1.0, 1.0, 21)
    for ax, kind in zip(style.new_panels(figure, 1, 3), ERRORS, strict=False):
        found = [cycle(4, kind, size) for size in sizes]
        periods = np.array([one.period for one in found])
        ax.plot(1e3 * sizes, 100.0 * (periods / periods[10] - 1.0), color=style.GREY, lw=1.0)
        for (name, marker), look in zip(KINDS.items(), style.LOOKS, strict=False):
            # the marker shows the worst of the four handoffs
            worst = [max(one.motion.handoffs.kind.tolist(), key=[*KINDS].index) for one in found]
            own = [k for k in range(sizes.size) if worst[k] == name and k != 10]
            ax.plot(
                1e3 * sizes[own], 100.0 * (periods[own] / periods[10] - 1.0), marker, ms=4.5,
                color=look.color, mfc="white" if name == "pick-up" else look.color, label=name,
            )  # fmt: skip
        ax.axhline(0.0, **style.ZERO)
        ax.axvline(0.0, **style.ZERO)
        unit = "‰ of their distance" if kind == ERRORS[0] else "mrad"
        ax.set_xlabel(style.label(kind, unit, line=24))
        # the panels of angles have a tenth of the first one's scale
        ax.set(xlim=(-1.08, 1.08), ylim=(-0.4, 1.05) if kind == ERRORS[0] else (-0.04, 0.105))
    figure.axes[0].set_ylabel("Change of the mean period (%)")
    handles = {}
    for ax in figure.axes:
        found, names = ax.get_legend_handles_labels()
        handles |= dict(zip(names, found, strict=True))
    figure.legend(
        [handles[name] for name in KINDS], [f"{name}s" for name in KINDS], ncols=3,
        loc="outside upper center", frameon=False, fontsize=style.SMALL_SIZE,
        title="worst of the four handoffs", title_fontsize=style.SMALL_SIZE,
    )  # fmt: skip
    return figure


PINS = (0.9e-3, -1.3e-3, 0.4e-3)
SLOTS = (-1.6e-3, -0.8e-3, 0.4e-3, 0.7e-3, 1.3e-3)


def measured() -> tuple[np.ndarray, esc.Escapement]:
    """Beats of a wheel with these errors, computed and made noisy, and its design."""
    inertia = esc.Inertia(3.39e-7, 5.65e-6)
    design = esc.Escapement(esc.Geneva(5, pins=3), inertia, torque=0.0113, friction=0.3)
    bad = replace(design.mechanism, pin_angle_errors=PINS, slot_angle_errors=SLOTS)
    beats = np.tile(esc.terminal(replace(design, mechanism=bad)).beats, 10)
    return beats + 5e-6 * np.random.default_rng(2026).normal(size=beats.size), design


@drawn
def beats() -> Figure:
    """Synthetic beats, the fitted parts, and the spectrum."""
    taken, design = measured()
    figure = style.new_figure(style.TWO_COLUMN, 5.0)
    upper, lower = (style.dress(ax) for ax in figure.subplots(2, 1))
    plots.plot_beats(esc.fit_beats(taken, design), upper)
    plots.plot_beat_spectrum(esc.beat_spectrum(taken, design.mechanism), lower)
    return figure


@drawn
def timing() -> Figure:
    """A computed recording of a clock that is out of beat, with its beats."""
    rng = np.random.default_rng(8)
    period = 0.2 * (1.0 + 2.0 / 86400.0)
    ticks = 0.3 + period * np.arange(600) + np.cumsum(5e-6 * rng.normal(size=600))
    ticks[1::2] += 5e-4
    with TemporaryDirectory() as folder:
        path = Path(folder) / "clock.wav"
        esc.write_recording(path, esc.synthetic_recording(ticks, signal_to_noise=20.0, room=0.1))
        beats, sound = esc.read_beats(path), esc.read_recording(path)
    return plots.plot_timing(beats, esc.timekeeping(beats, nominal=18000), sound)


def sensitivities() -> str:
    """Relative change of the mean period per unit, n = 4, as one-sided slopes at 1e-4 and 1e-6."""
    rows = [("axes too far apart", 1.0), ("axes too far apart", -1.0), ("one pin late", 1.0)]
    rows += [("one pin late", -1.0), ("one slot ahead", 1.0), ("one slot ahead", -1.0)]
    return "\n".join(
        f"{kind}, {way:+.0f}: "
        + ", ".join(f"{change(4, kind, way * size) / size:+.4f}" for size in (SMALL, 1e-6))
        for kind, way in rows
    )


if __name__ == "__main__":
    print(table())
    print(sensitivities())
