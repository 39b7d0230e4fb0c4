"""Quantiles of a sample in which some cases have no time: it is longer than any."""

import numpy as np

from escapement.model import FloatArray
from escapement.plots._table import Study

QUANTILES = (0.05, 0.5, 0.95)


def ran(study: Study) -> np.ndarray:
    """Which cases have an answer, shape of the results."""
    return np.isfinite(np.asarray(study.results["velocity_mean"], dtype=float))


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

    Values are joined by straight lines, as `numpy.quantile` does, which makes NaN of the
    last number before infinity too.

    values : shape (..., n), NaN where a case does not count.
    """
    ordered = np.sort(values, axis=-1)  # NaN last
    last = np.count_nonzero(~np.isnan(values), axis=-1, keepdims=True) - 1
    place = share * np.maximum(last, 0)
    below, above = (
        np.take_along_axis(ordered, end(place).astype(int), axis=-1) for end in (np.floor, np.ceil)
    )
    with np.errstate(invalid="ignore"):  # of two infinities
        between = below + (above - below) * (place - np.floor(place))
    return np.where(np.isfinite(above), between, np.nan)[..., 0]


def missing(study: Study, result: str) -> str:
    """How many of the cases with an answer lack a result: "no rise time in 3 of 20 cases"."""
    lost, name = int(np.isinf(counted(study, result)).sum()), result.replace("_", " ")
    return f"no {name} in {lost} of {int(ran(study).sum())} cases" if lost else ""
