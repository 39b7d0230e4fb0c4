"""Measured positions against a mechanism's position function."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike

import numpy as np

from escapement import validate
from escapement.errors import InvalidValue
from escapement.measurement import encoder as sensors
from escapement.measurement import normality
from escapement.measurement.encoder import Encoder, SensorShare
from escapement.measurement.fit import Fit, fit, position
from escapement.measurement.normality import Histogram, NormalityTest
from escapement.measurement.readings import TURN, Readings, read_readings, wraps, write_table
from escapement.measurement.shafts import ShaftError, shaft_errors
from escapement.measurement.spectrum import Periodogram, periodogram
from escapement.model import FloatArray, Mechanism

_SURE = 1e-3
"""A p-value below it is told to the reader."""
_ALIKE = 0.05  # a smaller correlation spoils no p-value
_TELLING = 3.0  # an amplitude of fewer standard errors is all but hidden
_LEAST = 5e-324  # it stands for a p-value that is too small for a double
_CLOSE_TO_HALF_A_TURN = 0.8 * math.pi
_EXPECTED = 5  # the chi-squared law needs so many errors in a class on average


@dataclass(frozen=True, eq=False)
class Measurement:
    """Errors of measured positions, and what they tell.

    Attributes
    ----------
    mechanism, readings, encoder, confidence :
        As given to `measure`.
    input, output : ndarray, shape (n,)
        Complete samples, the input counting on [rad].
    fit : Fit
        Zeros of the encoders, theory, errors and transmission at each sample.
    bins : int
        Number of classes.
    """

    mechanism: Mechanism
    readings: Readings
    encoder: Encoder | None
    confidence: float
    bins: int
    input: FloatArray = field(repr=False)
    output: FloatArray = field(repr=False)
    fit: Fit = field(repr=False)

    @property
    def errors(self) -> FloatArray:
        """Measured less theoretical position of the output, shape (n,) [rad]."""
        return self.fit.errors

    @cached_property
    def mean(self) -> float:
        """Mean error [rad]; zero but for rounding where the offset was fitted."""
        return float(self.errors.mean())

    @cached_property
    def standard_deviation(self) -> float:
        """Standard deviation of the errors about their mean, n - 1 [rad]."""
        return float(self.errors.std(ddof=1))

    @cached_property
    def histogram(self) -> Histogram:
        """Errors in classes of equal width, and what a normal law expects."""
        return normality.histogram(self.errors, self.bins)

    @cached_property
    def published_test(self) -> NormalityTest:
        """Normality as the paper tests it; see `published_chi_squared`."""
        return normality.published_chi_squared(self.histogram)

    @cached_property
    def chi_squared_test(self) -> NormalityTest:
        """Normality by a chi-squared test that keeps its level; see `chi_squared`.

        With the same number of classes, or as many as leave five errors in each.
        """
        bins = min(self.bins, self.errors.size // _EXPECTED)
        return normality.chi_squared(self.errors, bins)

    @cached_property
    def anderson_darling_test(self) -> NormalityTest:
        """Normality by the Anderson-Darling test."""
        return normality.anderson_darling(self.errors)

    @property
    def interval(self) -> tuple[float, float]:
        """Where a normal law with this mean and deviation has its errors [rad].

        mean -+ m sd with Phi(m) - Phi(-m) = confidence, the paper's eq. 19 and
        there called the confidence interval of the mean, which it is not.
        """
        from scipy.special import ndtri

        return self._about_mean(float(ndtri(0.5 + 0.5 * self.confidence)))

    @property
    def mean_interval(self) -> tuple[float, float]:
        """Confidence interval of the mean error, by Student's law [rad]."""
        from scipy.special import stdtrit

        n = self.errors.size
        return self._about_mean(float(stdtrit(n - 1, 0.5 + 0.5 * self.confidence)) / math.sqrt(n))

    def _about_mean(self, deviations: float) -> tuple[float, float]:
        half = deviations * self.standard_deviation
        return self.mean - half, self.mean + half

    @cached_property
    def autocorrelation(self) -> float:
        """Correlation of each error with the next one, -1 to 1 [-]."""
        rest = self.errors - self.mean
        return float(rest[1:] @ rest[:-1] / (rest @ rest))

    @property
    def shaft_errors(self) -> tuple[ShaftError, ...]:
        """Sinusoidal errors of each shaft; see `escapement.measurement.ShaftError`."""
        return self._shaft_errors[0]

    @property
    def rest_autocorrelation(self) -> float:
        """`autocorrelation` of what phase, offset and significant shaft errors leave [-]."""
        return self._shaft_errors[1]

    @cached_property
    def _shaft_errors(self) -> tuple[tuple[ShaftError, ...], float]:
        driver = self.input + self.fit.phase
        follower = position(self.mechanism, driver)
        cell = self.mechanism.cell_angle
        return shaft_errors(driver, follower, self.fit.slope, cell, self.errors)

    @cached_property
    def periodogram(self) -> Periodogram:
        """Periodogram of the errors over the input angle."""
        return periodogram(self.input, self.errors)

    @cached_property
    def sensor_share(self) -> SensorShare | None:
        """Errors that the encoders alone explain; None without an encoder."""
        return sensors.sensor_share(self.encoder, self.fit.slope) if self.encoder else None

    @cached_property
    def message(self) -> str:
        """What a reader of these figures must know, "" where there is nothing."""
        return "; ".join(_cautions(self))


def measure(
    readings: Readings | str | PathLike[str],
    mechanism: Mechanism,
    *,
    bins: int | str = "sturges",
    confidence: float = 0.99,
    encoder: Encoder | None = None,
    zeros: tuple[float, float] | None = None,
) -> Measurement:
    """Compare readings of encoders with a mechanism's position function.

    Parameters
    ----------
    readings : Readings or path
        Angles of input and output, or a CSV file of them in degrees unless its
        header says otherwise (`read_readings` knows more).
    mechanism : Mechanism
        Geometry, for example `Geneva(slots=4)`.
    bins : int or str
        Number of classes, >= 4, or a rule: "sturges", "scott",
        "freedman-diaconis" or "square-root".
    confidence : float
        Of the intervals, in (0, 1).
    encoder : Encoder, optional
        Data sheet of the encoders, both alike: adds what they explain.
    zeros : (float, float), optional
        Phase and offset where they are known [rad]: driver angle from dead centre
        at which the input reads zero, and reading of the output at follower angle
        zero. Default: fitted, which makes the mean error zero.

    Returns
    -------
    Measurement
        The fit at once; statistics when they are asked for.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, or the errors are all the same.
    MissingInput, InputFileError
        When the file is not there, or cannot be understood.

    Source: Prikhodko (2020), section 3.
    """
    sensors.check_drive(mechanism, encoder)
    share = validate.number("confidence", confidence, remedy := "give a share, as 0.99")
    if not 0.0 < share < 1.0:
        raise validate.fail("confidence", "between 0 and 1", confidence, remedy)
    known = None if zeros is None else sensors.checked_zeros(zeros)
    if not isinstance(readings, Readings | str | PathLike):
        raise validate.fail(
            "readings", "Readings or a path", readings, "give Readings(input, output) in rad"
        )
    taken = readings if isinstance(readings, Readings) else read_readings(readings)
    # the input of samples without an output helps to count turns, so they are left out last
    angle, output = taken.counted_input[taken.complete], taken.output[taken.complete]
    found = fit(mechanism, angle, output, wraps(output), known)
    first = np.flatnonzero(np.isfinite(taken.input))[0]
    turns = round(float(taken.input[first] - taken.counted_input[first]) / TURN)
    if known is not None and turns != 0:
        # a first reading of nearly a turn may be one a little below zero; the better fit decides
        other = angle + turns * TURN
        standing = fit(mechanism, other, output, wraps(output), known)
        if standing.errors @ standing.errors < found.errors @ found.errors:
            angle, found = other, standing
    # errors that rounding alone makes are no measurement
    if not np.ptp(found.errors) > 1e-13 * max(1.0, float(np.abs(output).max())):
        raise InvalidValue(
            "readings must differ from theory in some way, got theory itself; give measured ones"
        )
    count = normality.class_count(found.errors, bins)
    return Measurement(mechanism, taken, encoder, share, count, angle, output, found)


def write_errors(result: Measurement, path: str | PathLike[str], *, force: bool = False) -> None:
    """Write input, output, theory and error of each complete sample.

    Parameters
    ----------
    result : Measurement
        What `escapement.measure` returns.
    path, force :
        As for `write_readings`.
    """
    columns = {"input_deg": result.input, "output_deg": result.output}
    columns |= {"theory_deg": result.fit.theory, "error_deg": result.errors}
    write_table(path, columns, result.readings.synthetic, "", force)


def _cautions(result: Measurement) -> Iterator[str]:
    """Sentences for the reader, the gravest first."""
    if result.readings.synthetic:
        yield "synthetic data, computed and not measured"
    if result.readings.remark:
        yield result.readings.remark
    yield from _on_the_fit(result)
    yield from _on_independence(result)
    yield from _on_shafts(result)


def _on_the_fit(result: Measurement) -> Iterator[str]:
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


def _on_independence(result: Measurement) -> Iterator[str]:
    # independent errors have a correlation beyond 3.3/sqrt(n) once in a thousand times
    least = max(3.3 / math.sqrt(result.errors.size), _ALIKE)
    alike = max(result.autocorrelation, result.rest_autocorrelation)
    spoilt = "tests of normality, errors of phase and offset and intervals of the mean"
    # a wave that is found makes neighbours alike, but spoils no test for waves
    if result.rest_autocorrelation > least:
        spoilt = "all tests, false alarms, standard errors and intervals of the mean"
    if alike > least:
        yield (
            f"neighbouring errors are alike (correlation {alike:.2f}), while {spoilt} "
            "take them for independent: do not trust those"
        )


def _on_shafts(result: Measurement) -> Iterator[str]:
    for error in result.shaft_errors:
        if error.p_value < _SURE:
            yield _on_shaft(error, result.rest_autocorrelation)
    unknown = dict.fromkeys(it.shaft for it in result.shaft_errors if math.isnan(it.p_value))
    if unknown:
        yield (
            f"errors that come back with {' and '.join(unknown)} are not judged: not measured all "
            "round, or not to be told from others"
        )
    if result.periodogram.samples < result.errors.size:
        yield f"the periodogram covers the first {result.periodogram.turns:.0f} turns"


def _on_shaft(error: ShaftError, correlation: float) -> str:
    """What comes back, with reserve where correlated noise may look the same."""
    # To a slow wave n errors of correlation r are worth n (1 - r)/(1 + r) independent ones.
    # In an F test with two degrees of freedom p is then raised to that share.
    worth = (1.0 - correlation) / (1.0 + correlation) if correlation > 0.0 else 1.0
    sure = max(error.p_value, _LEAST) ** worth < _SURE
    where = "cell" if error.shaft == "cell" else f"turn of the {error.shaft}"
    when = f"{'comes' if sure else 'may come'} back {'once' if error.order == 1 else 'twice'}"
    amplitude, doubt = math.degrees(error.amplitude), math.degrees(error.standard_error)
    size = f"{amplitude:.3g} +- {doubt:.2g} degrees"
    if _TELLING * doubt < amplitude:
        text = f"an error of {size} {when} a {where}"
    else:
        hidden = "its size all but hidden by phase, offset and others"
        text = f"an error {when} a {where}, {hidden} ({size})"
    return text if sure else f"{text}, or is noise whose neighbours are alike"
