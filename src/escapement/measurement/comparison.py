"""The comparison of readings with theory: errors, their statistics and their causes."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.measurement import encoder as sensors
from escapement.measurement import normality, periodic
from escapement.measurement.encoder import Encoders, SensorShare
from escapement.measurement.estimate import Verdict, checked_confidence, correlation, reach_of
from escapement.measurement.finding import find_errors
from escapement.measurement.findings import Found
from escapement.measurement.positions import Positions, fit_zeros
from escapement.measurement.readings import (
    TURN,
    Readings,
    check_samples,
    read_readings,
    write_table,
)
from escapement.measurement.verdict import remarks_on, verdict_on
from escapement.mechanisms.protocol import FloatArray, Mechanism


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Measurement(Found):
    """Errors of measured positions, their statistics and their causes.

    Attributes
    ----------
    mechanism, readings, encoder, confidence :
        As given to `measure`.
    input, output : ndarray, shape (n,)
        The samples in which both were read; the input grows over the turns [rad].
    fit : Fit
        Zeros of the encoders, theory, errors and transmission at each sample.
    bins : int
        Number of classes.
    steps : (float, float)
        Steps of the encoders of input and output, 0 if they are unknown [rad].
    """

    mechanism: Mechanism
    readings: Readings
    encoder: Encoders | None
    confidence: float
    bins: int
    input: FloatArray = field(repr=False)
    output: FloatArray = field(repr=False)
    fit: Positions = field(repr=False)
    steps: tuple[float, float] = field(repr=False)

    @property
    def errors(self) -> FloatArray:
        """Measured less theoretical position of the output, shape (n,) [rad]."""
        return self.fit.errors

    @cached_property
    def mean(self) -> float:
        """Mean error [rad]; zero except for rounding if the offset was fitted."""
        return float(self.errors.mean())

    @cached_property
    def standard_deviation(self) -> float:
        """Standard deviation of the errors about their mean, with divisor n - 1 [rad]."""
        return float(self.errors.std(ddof=1))

    @cached_property
    def histogram(self) -> normality.Histogram:
        """Numbers of errors in classes of equal width, found and expected of normal errors."""
        return normality.histogram(self.errors, self.bins)

    @cached_property
    def published_test(self) -> normality.NormalityTest:
        """Normality as the paper tests it; see `published_chi_squared`."""
        return normality.published_chi_squared(self.histogram)

    @cached_property
    def anderson_darling_test(self) -> normality.NormalityTest:
        """Normality by the Anderson-Darling test."""
        return normality.anderson_darling(self.errors)

    def _about_the_mean(self, freedom: float, deviation: float) -> tuple[float, float]:
        half = reach_of(self.confidence, freedom) * deviation
        return self.mean - half, self.mean + half

    @property
    def interval(self) -> tuple[float, float]:
        """Interval that contains the share `confidence` of normal errors [rad].

        mean -+ m sd with Phi(m) - Phi(-m) = confidence, eq. 19 of the paper. The paper calls it
        the confidence interval of the mean, which is `mean_interval`.
        """
        return self._about_the_mean(math.inf, self.standard_deviation)

    @property
    def mean_interval(self) -> tuple[float, float]:
        """Confidence interval of the mean error, by Student's distribution [rad]."""
        n = self.errors.size
        return self._about_the_mean(n - 1, self.standard_deviation / math.sqrt(n))

    @cached_property
    def autocorrelation(self) -> float:
        """Correlation of each error with the next one, -1 to 1 [-]."""
        return correlation(self.errors - self.mean)

    @cached_property
    def periodogram(self) -> periodic.Periodogram:
        """Periodogram of the errors over the input angle."""
        return periodic.periodogram(self.input, self.errors)

    @cached_property
    def sensor_share(self) -> SensorShare | None:
        """Errors that the encoders alone explain; None without an encoder."""
        return sensors.sensor_share(self.encoder, self.fit.slope) if self.encoder else None

    @cached_property
    def verdict(self) -> Verdict:
        """Whether the mechanism is good, what is wrong with it, and on which shaft."""
        return verdict_on(self)

    @cached_property
    def message(self) -> str:
        """Warnings that a user of these figures must know, "" if there are none."""
        return "; ".join(remarks_on(self))


def measure(
    readings: Readings | str | PathLike[str], mechanism: Mechanism, *, bins: int | str = "sturges",
    confidence: float = 0.99, encoder: Encoders | None = None,
    zeros: tuple[float, float] | None = None,
) -> Measurement:  # fmt: skip
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
        Share of the errors, or level of the mean's interval, for both intervals, in (0, 1) [-].
    encoder : Encoder or (Encoder, Encoder), optional
        Data of both encoders, or of those of input and output; with it the result has
        `sensor_share`.
    zeros : (float, float), optional
        Phase and offset if they are known [rad]: driver angle from dead centre
        at which the input reads zero, and reading of the output at follower angle
        zero. Default: both are fitted, which makes the mean error zero.

    Returns
    -------
    Measurement
        Its errors and their causes are computed at once, its statistics when they are read.

    Raises
    ------
    InvalidValue
        If an argument breaks its rule, or all errors are equal.
    MissingInput, InputFileError
        If the file does not exist, or cannot be understood.

    Source: Prikhodko (2020), section 3.
    """
    sensors.check_drive(mechanism, encoder)
    share = checked_confidence(confidence)
    known = None if zeros is None else sensors.checked_zeros(zeros)
    if not isinstance(readings, Readings | str | PathLike):
        remedy = "give Readings(input, output) in rad"
        raise validate.fail("readings", "Readings or a path", readings, remedy)
    taken = readings if isinstance(readings, Readings) else read_readings(readings)
    if taken.half_widths is not None:
        raise validate.fail("readings", "those of encoders", readings, "see escapement.timekeeping")
    check_samples(taken.samples, taken.input.size)
    # the input of samples without an output helps to count turns, so they are left out last
    angle, output = taken.counted_input[taken.complete], taken.output[taken.complete]
    first = np.flatnonzero(np.isfinite(taken.input))[0]
    turns = np.round((taken.input[first] - taken.counted_input[first]) / TURN)
    # a first reading of nearly a turn may be one a little below zero; the better fit decides
    starts = (0.0,) if known is None else dict.fromkeys([0.0, turns * TURN])
    fits = [(fit_zeros(mechanism, angle + start, output, known), angle + start) for start in starts]
    found, angle = min(fits, key=lambda tried: tried[0].errors @ tried[0].errors)
    # errors as small as rounding come from computed angles
    if not np.ptp(found.errors) > 1e-13 * max(1.0, float(np.abs(output).max())):
        raise InvalidValue(
            "readings must be measured, got angles that equal theory to all digits; give the "
            "angles that the encoders showed"
        )
    count, line = normality.class_count(found.errors, bins), np.asarray(taken.line)[taken.complete]
    steps = sensors.steps_of(encoder, angle, output)
    causes = find_errors(mechanism, angle + found.phase, found.sense, found.errors, line, steps)
    return Measurement(
        mechanism=mechanism, readings=taken, encoder=encoder, confidence=share, bins=count,
        input=angle, output=output, fit=found, steps=steps, **vars(causes),
    )  # fmt: skip


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
