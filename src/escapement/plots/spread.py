"""Figure of a sample over a grid: how far its results scatter at each point."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from escapement.plots import _style
from escapement.plots._labels import scaled
from escapement.plots._panels import draw_lines, legend, spread, whole
from escapement.plots._table import Study, available, tabulate
from escapement.plots.sample import QUANTILES


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
        a second one.

    Raises
    ------
    InvalidValue
        When the study is no sample, or varies no axis beside it.
    """
    low, middle, high = (_at_quantile(study, share) for share in QUANTILES)
    names = available(middle, ("rise_time", "velocity_mean"))
    figure = _style.new_figure(_style.ONE_COLUMN, 0.9 + 2.2 * len(names))
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False).ravel()
    for ax, name in zip(panels, names, strict=True):
        table = tabulate(middle, name)
        lines = draw_lines(_style.dress(ax), middle, name, table)
        factor, _ = scaled(study.units.get(name, ""), table.values)
        ends = [tabulate(side, name).values * factor for side in (low, high)]
        for line, column in zip(lines, spread(table.values.shape[1]), strict=True):
            below, above = (end[:, column] for end in ends)
            look: dict[str, Any] = {"color": line.get_color(), "alpha": 0.2, "lw": 0.0}
            if whole(study, table.x):
                ax.vlines(table.x_values, below, above, **(look | {"lw": 4.0}))
            else:
                ax.fill_between(table.x_values, below, above, **look)
        ax.label_outer()
    results = np.asarray(study.results["velocity_mean"])
    note = f"Median and 5 % to 95 % of {results.shape[-1]} cases"
    if lost := int((~np.isfinite(results)).sum()):
        note += f"\nbut for {lost} of {results.size} in all, without result"
    legend(panels[0], study, table, lines, note)
    if table.lines is None:
        panels[0].set_title(note, fontsize=_style.SMALL_SIZE)
    if table.note:
        figure.suptitle(table.note, fontsize=_style.SMALL_SIZE)
    return figure


@dataclass(frozen=True)
class _Grid:
    """A sample's quantile over its grid, as a study of its own."""

    axes: dict[str, np.ndarray]
    results: dict[str, np.ndarray]
    units: Mapping[str, str]
    long_names: Mapping[str, str]
    sampled: dict[str, np.ndarray] = field(default_factory=dict)


def _at_quantile(study: Study, share: float) -> _Grid:
    """A quantile of every result over the cases that have one."""
    axes = {name: values for name, values in study.axes.items() if name != [*study.axes][-1]}
    results = {}
    for name, values in study.results.items():
        if name == "status":
            continue
        numbers = np.where(np.isfinite(values), values, np.nan)
        some = np.isfinite(numbers).any(axis=-1)
        results[name] = np.full(some.shape, np.nan)
        results[name][some] = np.nanquantile(numbers[some], share, axis=-1)
    return _Grid(axes, results, study.units, study.long_names)
