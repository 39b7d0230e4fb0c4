"""Measured positions against a mechanism's position function."""

import math
from dataclasses import dataclass, field
from functools import cached_property

from escapement.measurement._fit import Fit
from escapement.measurement._position import position
from escapement.measurement._remarks import remarks
from escapement.measurement.classes import Histogram, histogram
from escapement.measurement.encoder import Encoder, SensorShare, sensor_share
from escapement.measurement.normality import (
    NormalityTest,
    anderson_darling,
    chi_squared,
    published_chi_squared,
)
from escapement.measurement.readings import Readings
from escapement.measurement.shafts import ShaftError, shaft_errors
from escapement.measurement.spectrum import Periodogram, periodogram
from escapement.model import FloatArray, Mechanism

_EXPECTED = 5  # errors in a class, on average, for the chi-squared law to hold


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
        return histogram(self.errors, self.bins)

    @cached_property
    def published_test(self) -> NormalityTest:
        """Normality as the paper tests it; see `published_chi_squared`."""
        return published_chi_squared(self.histogram)

    @cached_property
    def chi_squared_test(self) -> NormalityTest:
        """Normality by a chi-squared test that keeps its level; see `chi_squared`.

        With the same number of classes, or as many as leave five errors in each.
        """
        return chi_squared(self.errors, min(self.bins, self.errors.size // _EXPECTED))

    @cached_property
    def anderson_darling_test(self) -> NormalityTest:
        """Normality by the Anderson-Darling test."""
        return anderson_darling(self.errors)

    @property
    def interval(self) -> tuple[float, float]:
        """Where a normal law with this mean and deviation has its errors [rad].

        mean -+ m sd with Phi(m) - Phi(-m) = confidence, the paper's eq. 19 and
        there called the confidence interval of the mean, which it is not.
        """
        from scipy.special import ndtri

        half = float(ndtri(0.5 + 0.5 * self.confidence)) * self.standard_deviation
        return self.mean - half, self.mean + half

    @property
    def mean_interval(self) -> tuple[float, float]:
        """Confidence interval of the mean error, by Student's law [rad]."""
        from scipy.special import stdtrit

        n = self.errors.size
        share = 0.5 + 0.5 * self.confidence
        half = float(stdtrit(n - 1, share)) * self.standard_deviation / math.sqrt(n)
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
        """`autocorrelation` of what phase, offset and the sure ones of these leave [-]."""
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
        if self.encoder is None:
            return None
        return sensor_share(self.encoder, self.fit.slope)

    @cached_property
    def message(self) -> str:
        """What a reader of these figures must know, "" where there is nothing."""
        return "; ".join(remarks(self))
