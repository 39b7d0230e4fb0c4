"""Figures of accuracy, drawn from the tables in benchmarks/results.

Each function draws one figure; `docs/make_figures.py` puts them into the documentation.
"""

import csv
import json
from itertools import groupby
from pathlib import Path

import numpy as np

import escapement as esc
from escapement.base.units import INCH_POUND
from escapement.benchmark.work_precision import Point, work_precision_figure
from escapement.plots import style

RESULTS = Path(__file__).resolve().parent / "results"
ZERO, LEAST = 1.7e-17, 4e-17
"""Where an error of exactly zero stands on a logarithmic axis, and the top of that strip."""


def table(name):
    """Rows of a result as dictionaries, numbers as floats."""

    def cell(text):
        try:
            return float(text)
        except ValueError:
            return text

    with open(RESULTS / f"{name}.csv", newline="", encoding="utf-8") as stream:
        return [{key: cell(text) for key, text in row.items()} for row in csv.DictReader(stream)]


def columns(rows, *names):
    return [np.array([row[name] for row in rows]) for name in names]


def grouped(rows, *names):
    """Pairs (values of `names`, rows) of neighbouring rows that have equal values."""
    return groupby(rows, key=lambda row: tuple(row[name] for name in names))


def plot_errors(axes, x, errors, **look):
    """Draw a curve of errors. Errors of exactly zero are points in a strip at the foot."""
    zero = errors == 0.0
    axes.loglog(x, np.where(zero, np.nan, errors), **look)
    axes.plot(x[zero], np.full(zero.sum(), ZERO), **{**look, "ls": "", "label": "_"})


def zero_strip(axes):
    """The strip of exact zeros below the decades from 1e-16 to 1e-13."""
    foot, powers = ZERO**2 / LEAST, range(-16, -12)
    axes.axhspan(foot, LEAST, color=style.LIGHT_GREY, alpha=0.35, lw=0)
    axes.set_ylim(bottom=foot)
    names = ["0", *(f"$10^{{{power}}}$" for power in powers)]
    axes.set_yticks([ZERO, *(10.0**power for power in powers)], names)
    axes.set_yticks([], minor=True)


def above(figure, axes, columns):
    """One legend for all panels, over them."""
    handles, _ = axes.get_legend_handles_labels()
    where = {"loc": "outside upper center", "handlelength": 2.6}
    style.add_legend(figure, columns, handles=handles, **where)


def work_precision():
    """Error against run time of all solvers, as `standings.py` measured them."""
    points = [Point(**row) for row in table("work_precision")]
    machine = json.loads((RESULTS / "machine.json").read_text(encoding="utf-8"))
    return work_precision_figure(points, machine)


def tolerance():
    """Measured error against the tolerance asked for, both engines."""
    figure = style.new_figure(style.TWO_COLUMN, 3.1)
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    for axes, ((engine,), rows) in zip(panels, grouped(table("tolerance"), "engine"), strict=True):
        style.dress(axes)
        rtol, median, most, worst, cases = columns(
            list(rows), "rtol", "median", "q95", "worst", "cases"
        )
        names = ("median", "95 % are below", "largest")
        for curve, look, name in zip((median, most, worst), style.LOOKS, names, strict=False):
            axes.loglog(
                rtol, curve, look.marker, ls=look.linestyle, color=look.color, label=name, ms=4
            )
        axes.loglog(rtol, rtol, color=style.BLACK, lw=0.8, label="error = tolerance")
        axes.loglog(
            rtol, 10 * rtol, color=style.BLACK, ls=":", lw=1.0, label="ten times the tolerance"
        )
        axes.set_xlabel("Tolerance rtol")
        axes.set_title(f"{engine}, {cases[0]:.0f} random cases", fontsize=style.LABEL_SIZE)
    panels[0].set_ylabel("Measured relative error")
    above(figure, panels[0], 5)
    return figure


def painleve():
    """Error and run time against the distance to the Painleve limit."""
    figure = style.new_figure(style.TWO_COLUMN, 3.1)
    left, right = (style.dress(axes) for axes in figure.subplots(1, 2))
    # two rows of three in the legend, which fills columns
    ordered = sorted(table("painleve"), key=lambda row: (row["slots"], row["engine"]))
    for (engine, slots), rows in grouped(ordered, "engine", "slots"):
        gap, error, spent = columns(list(rows), "1 - mu/mu_c", "error", "ms")
        look = {
            "marker": {3: "^", 4: "o", 6: "s"}[int(slots)],
            "color": style.BLUE if engine == "energy" else style.VERMILLION,
            "ls": "-" if engine == "energy" else (0, (5, 1.6)),
            "mfc": None if engine == "energy" else "white",
            "ms": 4,
        }
        plot_errors(left, gap, error, label=f"{engine}, {int(slots)} slots", **look)
        right.loglog(gap, spent, **look)
    for axes in (left, right):
        axes.set_xlabel("Distance to the limit, $1 - \\mu/\\mu_c$")
        axes.invert_xaxis()
    zero_strip(left)
    left.set_ylabel("Relative error")
    right.set_ylabel("Run time (ms)")
    above(figure, left, 3)
    return figure


def long_run():
    """Relative drift of time and of energy over a million engagements."""
    figure = style.new_figure(style.TWO_COLUMN, 2.9)
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    for axes, name in zip(panels, ("time", "energy"), strict=True):
        style.dress(axes)
        drifts = grouped(table("long_run"), "friction")
        for ((friction,), rows), look, size in zip(drifts, style.LOOKS, (4, 7), strict=False):
            count, drift = columns(list(rows), "engagements", f"{name} drift")
            plot_errors(
                axes, count, drift, marker=look.marker, ls="", color=look.color, ms=size,
                mfc=look.color if friction == 0.0 else "none",
                label=f"friction {style.number_text(friction)}" if friction else "no friction",
            )  # fmt: skip
        walk = 2.0**-53 * np.sqrt(count)
        axes.loglog(count, walk, color=style.GREY, lw=0.9, label="random rounding errors")
        axes.set_xlabel("Engagements")
        axes.set_title(name.capitalize(), fontsize=style.LABEL_SIZE)
    for axes in panels:
        zero_strip(axes)
    panels[0].set_ylabel("Relative drift")
    above(figure, panels[0], 3)
    return figure


FIGURES = (
    *("velocity_max", "velocity_min", "velocity_mean", "period", "rise_time_63", "rise_time_98"),
    *("acceleration_max", "follower_acceleration_max", "contact_moment_max", "critical_friction"),
)
PARAMETERS = ("torque", "friction", "driver_inertia", "follower_inertia", "load_torque")
DESIGNS = {"three pins": (6, 0.08, 0.20, 3, 40), "four pins": (4, 0.10, 0.35, 3, 50)}
DESIGNS["six pins"] = (3, 0.03, 0.20, 6, 10)
"""Slots, torque [in-lbf], friction, and inertias of driver and follower [1e-6 in-lbf-s^2]."""


def conditioning():
    """Change of each figure of merit in per cent, for one per cent of each parameter."""
    figure = style.new_figure(style.TWO_COLUMN, 3.4)
    panels = zip(figure.subplots(1, 3, sharey=True), DESIGNS.items(), strict=True)
    for axes, (name, (slots, torque, friction, *inertias)) in panels:
        inertia = esc.Inertia(*(1e-6 * INCH_POUND * each for each in inertias))
        torques = {"torque": torque * INCH_POUND, "load_torque": 0.1 * torque * INCH_POUND}
        timer = esc.Escapement(esc.Geneva(slots), inertia, friction=friction, **torques)
        found = esc.sensitivities(timer).relative
        values = np.array([[found[row].get(one, 0.0) for one in PARAMETERS] for row in FIGURES])
        axes.imshow(values, cmap="RdBu_r", vmin=-2.2, vmax=2.2, aspect="auto")
        for (i, j), value in np.ndenumerate(values):
            ink = "white" if abs(value) > 1.3 else "black"
            text = f"{value:.2f}" if abs(value) > 5e-3 else "0"
            axes.text(j, i, text, ha="center", va="center", fontsize=7, color=ink)
        axes.set_xticks(range(len(PARAMETERS)), [p.replace("_", "\n") for p in PARAMETERS])
        axes.set_yticks(range(len(FIGURES)), [row.replace("_", " ") for row in FIGURES])
        axes.tick_params(labelsize=7, length=0)
        axes.tick_params(axis="y", labelsize=style.SMALL_SIZE)
        axes.set_title(name, fontsize=9)
    return figure
