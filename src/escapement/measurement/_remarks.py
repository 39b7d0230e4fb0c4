"""What a reader of the figures must know before trusting them."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from escapement.measurement.readings import TURN, wraps

if TYPE_CHECKING:
    from escapement.measurement.comparison import Measurement

_SURE = 1e-3
"""p-values below it are remarked upon."""
_ALIKE = 0.05  # less correlation spoils no p-value
_CLOSE_TO_HALF_A_TURN = 0.8 * math.pi


def remarks(result: "Measurement") -> Iterator[str]:
    """Remarks, the gravest first."""
    if result.readings.synthetic:
        yield "synthetic data, computed and not measured"
    if result.readings.remark:
        yield result.readings.remark
    yield from _of_the_fit(result)
    yield from _of_independence(result)
    yield from _of_shafts(result)


def _of_the_fit(result: "Measurement") -> Iterator[str]:
    rms = math.hypot(result.mean, result.standard_deviation)
    if rms > 0.25 * abs(result.mechanism.follower_step):
        yield (
            f"errors of {math.degrees(rms):.3g} degrees are large against a step of "
            f"{math.degrees(abs(result.mechanism.follower_step)):.3g}: check the mechanism, "
            "which column is the input, and the unit of the angles"
        )
    if not math.isfinite(result.published_test.statistic):
        far = int(np.argmax(np.abs(result.errors - result.mean)))
        away = abs(result.errors[far] - result.mean) / result.standard_deviation
        yield (
            f"an error of {math.degrees(result.errors[far]):.3g} degrees is {away:.0f} standard "
            "deviations out, where a normal law expects nothing: chi_squared_published is infinite"
        )
    if math.isnan(result.fit.phase_error):
        yield "the output turns evenly over these samples, so the phase cannot be told"
    readings = result.readings
    known = np.flatnonzero(np.isfinite(readings.input))
    if wraps(readings.input[known]):
        steps = np.abs(np.diff(readings.counted_input[known]))
        far = int(np.argmax(steps))
        if steps[far] > _CLOSE_TO_HALF_A_TURN:
            line = readings.line[known[far + 1]]  # type: ignore[index]
            yield (
                f"the input goes on by {math.degrees(steps[far]):.0f} degrees at line {line}: "
                "its turns may be miscounted, measure closer"
            )


def _of_independence(result: "Measurement") -> Iterator[str]:
    n, correlation = result.errors.size, result.autocorrelation
    if correlation > max(3.3 / math.sqrt(n), _ALIKE):
        yield (
            f"neighbouring errors are alike (correlation {correlation:.2f}), while tests of "
            "normality and intervals of the mean take them for independent: do not trust their "
            "p-values"
        )


def _of_shafts(result: "Measurement") -> Iterator[str]:
    for error in result.shaft_errors:
        if error.p_value < _SURE:
            where = "cell" if error.shaft == "cell" else f"turn of the {error.shaft}"
            yield (
                f"an error of {math.degrees(error.amplitude):.3g} degrees comes back "
                f"{'once' if error.order == 1 else 'twice'} a {where}"
            )
    unknown = dict.fromkeys(it.shaft for it in result.shaft_errors if math.isnan(it.p_value))
    if unknown:
        yield (
            f"errors that come back with {' and '.join(unknown)} are not judged: not measured all "
            "round, or not to be told from others"
        )
    if result.periodogram.turns < (1.0 - 1e-9) * np.ptp(result.input) / TURN:
        yield f"the periodogram covers the first {result.periodogram.turns:.0f} turns"
