"""Figures of a sample: what scatters, by how much, and which parameter it comes from.

Some cases of a sample have an answer but no time, because it is longer than an engine
follows: quantiles count such a time as longer than any.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from escapement import validate
from escapement.errors import InvalidValue
from escapement.model import FloatArray
from escapement.plots import style
from escapement.plots.study_panels import (
    draw_lines,
    dress_axis,
    head,
    is_whole,
    legend,
    lines_drawn,
)
from escapement.plots.study_table import (
    NoResult,
    StudyTable,
    available,
    printed_name,
    result_scale,
    single_case,
    tabulate_study,
)
from escapement.plots.style import number_text
from escapement.study.result import Study
from escapement.study.varied import CASE

QUANTILES = (0.05, 0.5, 0.95)
_SPREAD = ("rise_time", "velocity_mean")
_RESULTS = ("period", "velocity_max", "rise_time")
_MOST_PANELS = 3  # so many parameters have room beside one another
_FEW, _MANY = 30, 300  # up to the one points are drawn large, beyond the other small
_MOST_POINTS = 1500
_BINS = (8, 40)
_LINE = 20  # so many characters of a label fit beside a panel
_BESIDE = dict(zip(QUANTILES, ("top", "center", "bottom"), strict=True))
_LOST: dict[str, Any] = {"marker": "x", "color": style.VERMILLION, "ms": 3.5, "mew": 0.8}
_LONGER: dict[str, Any] = {"marker": "^", "color": style.PURPLE, "ms": 3.5, "mew": 0.0}
_ENDLESS = 1e300
_APART = 0.06  # numbers closer than this share of a panel's height would overlap


def plot_sample(study: Study, results: Sequence[str] = _RESULTS) -> Figure:
    """Results against each sampled parameter, and how they are distributed.

    Parameters
    ----------
    study : Study
        A sweep's result over a sample.
    results : sequence of str
        Which results, by name, a row each; those without a number are left out.

    Returns
    -------
    Figure
        Of more than three parameters, those whose ranks go most with the first
        result. Lines across a row are its 5 %, 50 % and 95 % quantiles, of all cases
        that have an answer; the points are at most 1500 of them, drawn at random. A
        rise or settling time that a case lacks although it has an answer counts as
        longer than any: such cases are marked at the top of the panels, and a quantile
        that falls on one is not drawn.

    Raises
    ------
    InvalidValue
        When the study is no sample, has no such result, or no case has one.
    """
    if isinstance(results, str):
        raise validate.fail("results", "a list of names", results, f"give [{results!r}]")
    for name in results:
        validate.choice("results", name, tuple(study.results))
    flat = _flat(study)
    rows = [name for name in results if np.isfinite(flat.results[name]).any()]
    if not rows:
        raise NoResult(
            f"study must hold a number for {' or '.join(results)} to be plotted, got none; its "
            "status says what went wrong in each case"
        )
    names = _foremost(flat, rows[0])
    if not names:
        raise single_case()
    figure = style.new_figure(style.TWO_COLUMN, 0.9 + 1.75 * len(rows))
    # the last column is narrower: it holds the histogram
    widths = [1.0] * len(names) + [0.75]
    panels = figure.subplots(
        len(rows), len(widths), sharex="col", sharey="row", squeeze=False, width_ratios=widths
    )
    shown = _chosen(len(flat.failed))
    for line, name in zip(panels, rows, strict=True):
        factor, text = result_scale(study, name, flat.results[name], _LINE)
        values = flat.results[name] * factor
        for ax, parameter in zip(line, names, strict=False):
            _scatter(style.dress(ax), flat.parameters[parameter], values, flat.failed, shown)
        line[0].set_ylabel(text)
        _distribution(style.dress(line[-1]), values[np.isfinite(values)])
        _quantile_lines(line, [float(quantile(values, share)) for share in QUANTILES])
        if lack := missing(study, name):
            note = f"{lack}: counted as longest"
            line[-1].set_title(note, loc="right", fontsize=style.SMALL_SIZE)
    for ax in panels.ravel():
        ax.label_outer()
    for ax, parameter in zip(panels[-1], names, strict=False):
        dress_axis(ax, "x", study, parameter, _LINE)
        _power_in_label(ax, study, parameter, flat.parameters[parameter])
    panels[-1][-1].set_xlabel("Cases")
    _explain(figure, flat, names, rows)
    return figure


def _power_in_label(ax: Axes, study: Study, name: str, values: FloatArray) -> None:
    """Write the power of ten of a narrow axis into its label, which it would overlap."""
    greatest = float(np.abs(values).max())
    power = 3 * int(np.floor(np.log10(greatest) / 3.0)) if greatest > 0.0 else 0
    if abs(power) > 3:
        ax.xaxis.set_major_formatter(lambda value, _: f"{value / 10.0**power:g}")
        unit = f"10{style.superscript(power)} {style.print_unit(study.units.get(name, ''))}"
        ax.set_xlabel(style.label(printed_name(study, name), unit.strip(), _LINE))


@dataclass(frozen=True)
class _FlatSample:
    """A sample as columns of shape (n,).

    results : infinite where a case that has an answer lacks one, NaN where it has none.
    failed : cases without an answer.
    """

    parameters: dict[str, FloatArray]
    results: dict[str, FloatArray]
    failed: np.ndarray


def _flat(study: Study) -> _FlatSample:
    varied = [name for name, values in study.axes.items() if np.size(values) > 1]
    if not study.sampled or len(varied) > 1:
        raise InvalidValue(
            "study must be a sample at one point of its grid for this figure, got "
            f"{', '.join(varied) or 'a single case'}; use plot_study"
        )
    results = {name: np.ravel(counted(study, name)) for name in study.results}
    failed = ~np.ravel(ran(study))
    parameters = {name: np.asarray(v, dtype=float) for name, v in study.sampled.items()}
    return _FlatSample(parameters, results, failed)


def _foremost(flat: _FlatSample, result: str) -> list[str]:
    """At most three parameters that vary: those with most effect on the result."""
    varied = [name for name, values in flat.parameters.items() if np.ptp(values) > 0.0]
    if len(varied) > _MOST_PANELS:
        effect = {name: rank_correlation(flat.parameters[name], flat.results[result])
                  for name in varied}  # fmt: skip
        most = sorted(varied, key=lambda name: -abs(effect[name]))[:_MOST_PANELS]
        varied = [name for name in varied if name in most]
    return varied


def rank_correlation(x: FloatArray, y: FloatArray) -> float:
    """Spearman's coefficient of two columns, over the rows where neither is NaN [-].

    0 where one of them does not vary. Infinity ranks above any number.
    """
    from scipy.stats import spearmanr

    both = ~(np.isnan(x) | np.isnan(y))
    if np.unique(x[both]).size < 2 or np.unique(y[both]).size < 2:
        return 0.0
    return float(spearmanr(x[both], y[both]).statistic)


def _chosen(size: int) -> np.ndarray:
    """Rows that are drawn; every n-th would cut through the pattern of a sample."""
    if size <= _MOST_POINTS:
        return np.arange(size)
    return np.random.default_rng(0).choice(size, _MOST_POINTS, replace=False)


def _scatter(ax: Axes, x: FloatArray, y: FloatArray, failed: np.ndarray, rows: np.ndarray) -> None:
    """Points of the chosen rows; crosses below for no answer, triangles above for infinity."""
    few, many = rows.size <= _FEW, rows.size > _MANY
    ax.plot(x[rows], y[rows], ".", color=style.BLUE, ms=2.5 if many else 8.0 if few else 4.0,
            mew=0.0, alpha=0.5 if many else 0.8, zorder=3.0 if few else 2.0)  # fmt: skip
    lost = rows[failed[rows]]
    above = rows[np.isinf(y[rows])]
    for place, height, look in ((lost, 0.03, _LOST), (above, 0.97, _LONGER)):
        ax.plot(x[place], np.full(place.size, height), ls="", transform=ax.get_xaxis_transform(),
                **look)  # fmt: skip


def _distribution(ax: Axes, values: FloatArray) -> None:
    """A histogram on its side."""
    # Rice's rule: twice the cube root of the number of cases
    bins = int(np.clip(2.0 * values.size ** (1.0 / 3.0), *_BINS))
    look: dict[str, Any] = {"color": style.SKY, "edgecolor": "white", "lw": 0.3}
    ax.hist(values, bins=bins, orientation="horizontal", **look)
    ax.xaxis.set_major_locator(MaxNLocator(2, integer=True))


def _quantile_lines(row: Sequence[Axes], values: Sequence[float]) -> None:
    """The quantiles across a row of panels, their numbers beside the last."""
    low, high = row[-1].get_ylim()
    placed: list[float] = []
    for share, value in sorted(zip(QUANTILES, values, strict=True), key=lambda q: q[0] == 0.5):
        if not np.isfinite(value):
            continue
        for ax in row:
            ax.axhline(value, color=style.BLACK, lw=0.8, ls="-" if share == 0.5 else (0, (4, 2)))
        if all(abs(value - other) > _APART * (high - low) for other in placed):
            placed.append(value)
            row[-1].annotate(
                number_text(value), (1.0, value), xycoords=("axes fraction", "data"), xytext=(4, 0),
                textcoords="offset points", va=_BESIDE[share], fontsize=style.SMALL_SIZE,
            )  # fmt: skip


def _explain(figure: Figure, flat: _FlatSample, names: Sequence[str], rows: Sequence[str]) -> None:
    """What points, lines, crosses and triangles are, over the figure."""
    size, lost = flat.failed.size, int(flat.failed.sum())
    points = f"case ({min(size, _MOST_POINTS)} of {size})" if size > _MOST_POINTS else "case"
    handles: list[Any] = [
        Line2D([], [], ls="", marker=".", color=style.BLUE, ms=5, mew=0, label=points),
        Line2D([], [], color=style.BLACK, lw=0.8, label="median"),
        Line2D([], [], color=style.BLACK, lw=0.8, ls=(0, (4, 2)), label="5 % and 95 %"),
    ]
    if lost:
        text = f"no result ({lost} of {size})"
        handles.append(Line2D([], [], ls="", label=text, **_LOST))
    if any(np.isinf(flat.results[name]).any() for name in rows):
        handles.append(Line2D([], [], ls="", label="no time", **_LONGER))
    count = len(flat.parameters)
    effect = f"with most effect on {rows[0].replace('_', ' ')}"
    title = f"{len(names)} of {count} parameters, those {effect}"
    figure.legend(
        handles=handles, loc="outside upper center", ncols=len(handles), frameon=False,
        fontsize=style.SMALL_SIZE, title_fontsize=style.SMALL_SIZE,
        title=title if len(names) < count else None, columnspacing=1.4,
    )  # fmt: skip


def ran(study: Study) -> np.ndarray:
    """Which cases have an answer, shape of the results."""
    answered: np.ndarray = np.isfinite(np.asarray(study.results["velocity_mean"], dtype=float))
    return answered


def counted(study: Study, result: str) -> FloatArray:
    """A result as quantiles and ranks count it, of the shape of the results.

    NaN where a case has no answer. A case that has one lacks a rise or settling time
    only where that is beyond what an engine follows: infinity. Left out, the longest
    would be missing, and every quantile too short.
    """
    values = np.asarray(study.results[result], dtype=float)
    return np.where(ran(study), np.where(np.isfinite(values), values, np.inf), np.nan)


def quantile(values: FloatArray, share: float) -> FloatArray:
    """Quantile along the last axis, NaN where it falls on infinity or nothing counts.

    values : shape (..., n), NaN where a case does not count.
    """
    # infinity less infinity is no number, so a huge number stands for it
    finite = np.where(np.isinf(values), _ENDLESS, values)
    with warnings.catch_warnings(action="ignore"):  # NumPy warns where nothing counts
        found = np.nanquantile(finite, share, axis=-1)
    return np.where(found < 1e-100 * _ENDLESS, found, np.nan)


def missing(study: Study, result: str) -> str:
    """How many of the cases with an answer lack a result: "no rise time in 3 of 20 cases"."""
    lost, name = int(np.isinf(counted(study, result)).sum()), result.replace("_", " ")
    return f"no {name} in {lost} of {int(ran(study).sum())} cases" if lost else ""


def plot_spread(study: Study) -> Figure:
    """How far a sample scatters at each point of a grid.

    Parameters
    ----------
    study : Study
        A sweep's result over a sample at each point of a grid.

    Returns
    -------
    Figure
        Rise time and mean velocity against a swept parameter: the median over the
        sample, in a band from its 5 % to its 95 % quantile; a line for each value of
        a second one. A rise time that a case lacks although it has an answer is longer
        than any: the median is not drawn where half of the cases lack it, nor is the
        band where one in twenty does.

    Raises
    ------
    InvalidValue
        When the study is no sample, or varies no axis beside it.
    """
    low, middle, high = (_at_quantile(study, share) for share in QUANTILES)
    names = available(middle, _SPREAD)
    figure = style.new_figure(style.ONE_COLUMN, 0.9 + 2.2 * len(names))
    panels = style.new_panels(figure, len(names))
    for ax, name in zip(panels, names, strict=True):
        table = tabulate_study(middle, name)
        lines = draw_lines(ax, middle, name, table)
        factor, _ = result_scale(study, name, table.values)
        ends = [_values(side, name, table) * factor for side in (low, high)]
        for line, column in zip(lines, lines_drawn(table.values.shape[1]), strict=True):
            below, above = (end[:, column] for end in ends)
            look: dict[str, Any] = {"color": line.get_color(), "alpha": 0.2, "lw": 0.0}
            if is_whole(study, table.x):
                ax.vlines(table.x_values, below, above, **(look | {"lw": 4.0}))
            else:
                ax.fill_between(table.x_values, below, above, **look)
        ax.label_outer()
    legend(panels[0], study, table, lines, _note(study, names))
    head(figure, table)
    return figure


def _present(study: Study) -> list[str]:
    return [name for name in _SPREAD if name in study.results]


def _values(side: Study, name: str, middle: StudyTable) -> FloatArray:
    """A quantile beside the median, NaN all over where it falls on no number anywhere."""
    try:
        return tabulate_study(side, name).values
    except NoResult:
        return np.full_like(middle.values, np.nan)


def _note(study: Study, drawn: list[str]) -> str:
    """Which cases the quantiles are of, and which of them have no number."""
    answered = ran(study)
    lines = [f"Median and 5 % to 95 % of {answered.shape[-1]} cases"]
    if lost := int((~answered).sum()):
        lines.append(f"but for {lost} of {answered.size} in all, without result")
    for name in _present(study):
        if lack := missing(study, name):
            lines.append(f"{lack}: {'counted as longest' if name in drawn else 'too many to draw'}")
    return "\n".join(lines)


def _at_quantile(study: Study, share: float) -> Study:
    """A quantile of the results drawn, over the cases that have an answer, as a study."""
    axes = {name: values for name, values in study.axes.items() if name != CASE}
    results = {name: quantile(counted(study, name), share) for name in _present(study)}
    return replace(study, axes=axes, results=results, sampled={})
