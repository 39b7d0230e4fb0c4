"""Figures of a sample: which results scatter, by how much, and because of which parameter.

In some computed cases a time is missing, because it is longer than an engine follows the motion:
quantiles count such a time as longer than any other.
"""

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from escapement.base.status import Status
from escapement.dynamics.figure_table import TRANSIENT
from escapement.mechanisms.protocol import FloatArray
from escapement.plots import style
from escapement.plots.study_panels import dress_axis
from escapement.plots.study_table import (
    check_number,
    chosen,
    parameter,
    printed_name,
    refusal,
    single_case,
)
from escapement.study.result import Study

_RESULTS = ("period", "velocity_max", "rise_time")
_MOST_PANELS = 3  # number of parameters that fit beside one another
_FEW, _MANY = 30, 300  # points are large up to the first number, small beyond the second
_MOST_POINTS = 1500
_BINS = (8, 40)
_LINE = 20  # characters of a label that fit beside a panel
_MEDIAN: dict[str, Any] = {"color": style.BLACK, "lw": 0.8}
_END: dict[str, Any] = {**_MEDIAN, "ls": (0, (4, 2))}
_POINT: dict[str, Any] = {"ls": "", "marker": ".", "color": style.BLUE, "ms": 5, "mew": 0}
_LOST: dict[str, Any] = {"ls": "", "marker": "x", "color": style.VERMILLION, "ms": 3.5, "mew": 0.8}
_LONGER: dict[str, Any] = {"ls": "", "marker": "^", "color": style.PURPLE, "ms": 3.5, "mew": 0.0}
QUANTILES = {0.5: (_MEDIAN, "center"), 0.05: (_END, "top"), 0.95: (_END, "bottom")}
"""Shares of the cases, the most important first: line styles and alignment of numbers."""
_ENDLESS = 1e300
_APART = 0.06  # numbers closer than this share of a panel's height would overlap


def plot_sample(study: Study, results: Sequence[str] | None = None) -> Figure:
    """Results against each sampled parameter, and their distribution.

    Parameters
    ----------
    study : Study
        A sweep's result over a sample.
    results : sequence of str, optional
        Names of results, a row for each; those without a number are left out. Default: period,
        maximum velocity and rise time, or all results if the study names its own.

    Returns
    -------
    Figure
        With more than three parameters, those with the strongest rank correlation with the first
        result. Lines across a row are its 5 %, 50 % and 95 % quantiles over all computed cases;
        the points are at most 1500 of them, drawn at random. A rise or settling time that is
        missing in a computed case counts as longer than any other: such cases are marked at the
        top of the panels, and a quantile that falls on one is not drawn.

    Raises
    ------
    InvalidValue
        When the study is not a sample, has no such result, or no case has one.
    """
    results = chosen(study, results, _RESULTS)
    varied = [name for name, values in study.axes.items() if values.size > 1]
    if not study.sampled or len(varied) > 1:
        rule, got = "be a sample at one point of its grid for this figure", ", ".join(varied)
        raise refusal(rule, got or "a single case", "use plot_study")
    columns = {name: counted(study, name).ravel() for name in results}
    check_number(results, [*columns.values()])
    columns = {name: values for name, values in columns.items() if np.isfinite(values).any()}
    foremost, failed = next(iter(columns)), ~ran(study).ravel()
    names = _foremost(study, columns[foremost])
    if not names:
        raise single_case()
    figure = style.new_figure(style.TWO_COLUMN, 0.9 + 1.75 * len(columns))
    # the last column is narrower: it holds the histogram
    widths = [1.0] * len(names) + [0.75]
    made = style.new_panels(figure, len(columns), len(widths), width_ratios=widths, sharey="row")
    panels: Any = np.reshape(made, (len(columns), len(widths)))  # type: ignore[arg-type]
    # every n-th case would cut through the pattern of a sample
    shown = np.sort(np.random.default_rng(0).permutation(failed.size)[:_MOST_POINTS])
    for line, (name, values) in zip(panels, columns.items(), strict=True):
        factor, unit = style.scaled(study.units.get(name, ""), values)
        for ax, along in zip(line, names, strict=False):
            x, y = study.sampled[along][shown], values[shown] * factor
            _scatter(ax, x, y, failed[shown])
        line[0].set_ylabel(style.label(printed_name(study, name), unit, _LINE))
        _distribution(line[-1], values[np.isfinite(values)] * factor)
        _quantile_lines(line, values * factor)
        if lack := missing(study, name):
            note = f"{lack}: counted as longest"
            line[-1].set_title(note, loc="right", fontsize=style.SMALL_SIZE)
    for ax in panels.ravel():
        ax.label_outer()
    for ax, along in zip(panels[-1], names, strict=False):
        dress_axis(ax, "x", parameter(study, along, study.sampled[along]), _LINE)
    panels[-1][-1].set_xlabel("Cases")
    looks = {
        f"case ({shown.size} of {failed.size})" if shown.size < failed.size else "case": _POINT,
        "median": _MEDIAN,
        "5 % and 95 %": _END,
        f"no result ({failed.sum()} of {failed.size})": _LOST if failed.any() else None,
        "no time": _LONGER if any(np.isinf(values).any() for values in columns.values()) else None,
    }
    handles = [Line2D([], [], label=name, **look) for name, look in looks.items() if look]
    drawn, count = len(names), len(study.sampled)
    effect = f"those with most effect on {foremost.replace('_', ' ')}"
    title = f"{drawn} of {count} parameters, {effect}" if drawn < count else ""
    where: dict[str, Any] = {"loc": "outside upper center", "columnspacing": 1.4}
    style.add_legend(figure, len(handles), title, handles=handles, **where)
    return figure


def _foremost(study: Study, result: FloatArray) -> list[str]:
    """At most three parameters that vary: those with most effect on the result."""
    varied = [name for name, values in study.sampled.items() if np.ptp(values) > 0.0]
    effect = {name: abs(rank_correlation(study.sampled[name], result)) for name in varied}
    most = sorted(varied, key=effect.__getitem__, reverse=True)[:_MOST_PANELS]
    return [name for name in varied if name in most]


def rank_correlation(x: FloatArray, y: FloatArray) -> float:
    """Spearman's coefficient of two columns, over the rows where neither is NaN [-].

    0 where one of them does not vary. Infinity ranks above any number.
    """
    from scipy.stats import spearmanr

    both = ~(np.isnan(x) | np.isnan(y))
    with warnings.catch_warnings(action="ignore"):  # SciPy warns where one does not vary
        return float(np.nan_to_num(spearmanr(x[both], y[both]).statistic))


def _scatter(ax: Axes, x: FloatArray, y: FloatArray, failed: np.ndarray) -> None:
    """Points; crosses at the bottom for failed cases, triangles at the top for infinity."""
    few, many = x.size <= _FEW, x.size > _MANY
    look: dict[str, Any] = {"alpha": 0.5 if many else 0.8, "zorder": 3.0 if few else 2.0}
    look["ms"] = 2.5 if many else 8.0 if few else 4.0
    ax.plot(x, y, ".", color=style.BLUE, mew=0.0, **look)
    across = ax.get_xaxis_transform()
    for marked, height, mark in ((failed, 0.03, _LOST), (np.isinf(y), 0.97, _LONGER)):
        ax.plot(x[marked], np.full(marked.sum(), height), transform=across, **mark)


def _distribution(ax: Axes, values: FloatArray) -> None:
    """A horizontal histogram."""
    # Rice's rule: twice the cube root of the number of cases
    bins = int(np.clip(2.0 * values.size ** (1.0 / 3.0), *_BINS))
    look: dict[str, Any] = {"color": style.SKY, "edgecolor": "white", "lw": 0.3}
    ax.hist(values, bins=bins, orientation="horizontal", **look)
    ax.locator_params(axis="x", nbins=2, integer=True)


def _quantile_lines(row: Sequence[Axes], values: FloatArray) -> None:
    """The quantiles across a row of panels, their numbers beside the last."""
    low, high = row[-1].get_ylim()
    placed: list[float] = []
    for share, (look, end) in QUANTILES.items():
        value = float(quantile(values, share))
        if not np.isfinite(value):
            continue
        for ax in row:
            ax.axhline(value, **look)
        if all(abs(value - other) > _APART * (high - low) for other in placed):
            placed.append(value)
            beside: Any = {"transform": row[-1].get_yaxis_transform(), "fontsize": style.SMALL_SIZE}
            row[-1].text(1.05, value, style.number_text(value), va=end, **beside)


def ran(study: Study) -> np.ndarray:
    """Which cases were computed, in the shape of the results."""
    return np.asarray(study.results["status"] == Status.OK)


def counted(study: Study, result: str) -> FloatArray:
    """A result as used for quantiles and ranks, in the shape of the results.

    It is NaN where a case failed. In a computed case a rise or settling time is missing only if
    it is longer than an engine follows: it then counts as infinity. If such cases were left out,
    the longest times would be missing, and every quantile would be too short.
    """
    values = study.results[result]
    if result not in TRANSIENT:
        return np.where(ran(study), values, np.nan)
    return np.where(ran(study), np.where(np.isfinite(values), values, np.inf), np.nan)


def quantile(values: FloatArray, share: float | Sequence[float]) -> FloatArray:
    """Quantile along the last axis, NaN if it falls on infinity or no case counts.

    values : shape (..., n), NaN where a case does not count.
    share : of one or more quantiles, which become the first axis.
    """
    # infinity minus infinity is not a number, so a huge number replaces it
    finite = np.where(np.isinf(values), _ENDLESS, values)
    with warnings.catch_warnings(action="ignore"):  # NumPy warns where nothing counts
        found = np.nanquantile(finite, share, axis=-1)
    return np.where(found < 1e-100 * _ENDLESS, found, np.nan)


def missing(study: Study, result: str) -> str:
    """How many of the computed cases lack a result: "no rise time in 3 of 20 cases"."""
    lost, name = int(np.isinf(counted(study, result)).sum()), result.replace("_", " ")
    return f"no {name} in {lost} of {int(ran(study).sum())} cases" if lost else ""
