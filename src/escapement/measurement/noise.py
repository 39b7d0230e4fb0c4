"""The noise of readings: its variance at each sample, and what rounding alone may look like."""

import math
from typing import NamedTuple

import numpy as np

from escapement.measurement.readings import TURN
from escapement.mechanisms.protocol import FloatArray

_ROUNDS = 20  # the variances converge in a few
_UNEVEN = 3.3  # the noise counts as uneven beyond so many standard errors, once in a thousand sets
_FAR = 5.0  # standard deviations of a difference that is no noise
_MEDIAN = 0.455  # of the square of a normal number of variance 1
_LEAST = 1e-2  # share of the mean variance below which the noise is nowhere assumed
_REVISITED = 0.75  # a smaller share of the positions expected at random means that they repeat
_TERMS = np.arange(1, 40)


class Noise(NamedTuple):
    """Variances of independent noise, rounding included [rad^2].

    of_output : the same at every sample.
    of_input : it reaches the output through the transmission.
    """

    of_output: float
    of_input: float

    def deviation(self, slope: FloatArray) -> FloatArray:
        """Standard deviation of each sample relative to that in the dwell, shape (n,) [-]."""
        return np.asarray(np.sqrt((self.of_output + self.of_input * slope**2) / self.of_output))

    def shrunk(self, share: float) -> "Noise":
        """The noise with a share of its variances."""
        return Noise(share * self.of_output, share * self.of_input)


def noise_of(errors: FloatArray, slope: FloatArray, steps: tuple[float, float]) -> Noise:
    """Variance a of the noise of the output, and b of that of the input [rad^2].

    Noise of the output is the same at every sample, and noise of the input reaches the output
    through the transmission g, so the variance of a sample is a + b g^2 (maximum likelihood).
    Unless the errors show that they scatter more where g is greater, b is that of rounding alone.

    The variances come from differences of neighbours, in which a cause whose errors change slowly
    hardly counts, whether it was found or not.

    Parameters
    ----------
    errors : ndarray, shape (n,)
        What the fit leaves [rad].
    slope : ndarray, shape (n,)
        Transmission g [-].
    steps : (float, float)
        Steps of the encoders of input and output, 0 if unknown [rad].

    Source: J. Rice, Bandwidth choice for nonparametric regression, 1984.
    """
    squares = 0.5 * np.diff(errors) ** 2
    through = 0.5 * (slope[1:] ** 2 + slope[:-1] ** 2)
    first = _typical(squares, through, steps)
    # a reading far out is no noise
    near = squares <= _FAR**2 * (first.of_output + first.of_input * through)
    return _likeliest(squares[near], through[near], steps)


def _typical(squares: FloatArray, through: FloatArray, steps: tuple[float, float]) -> Noise:
    """A first estimate from medians, which neither a reading far out nor a slip changes."""
    groups = through > through.mean(), through <= through.mean()
    (high, fast), (low, slow) = (
        (float(np.median(squares[some])) / _MEDIAN, float(through[some].mean()))
        if some.any()
        else (0.0, 0.0)
        for some in groups
    )
    b = max((high - low) / (fast - slow) if fast > slow else 0.0, steps[0] ** 2 / 12.0)
    a = max(low - b * slow, steps[1] ** 2 / 12.0) or float(squares.mean())
    return Noise(a, b)


def _likeliest(squares: FloatArray, through: FloatArray, steps: tuple[float, float]) -> Noise:
    """The variances that make squares with the means a + b `through` most likely."""
    mean, spread = float(squares.mean()), through - through.mean()
    scale = float(spread @ spread)
    known = steps[0] ** 2 / 12.0
    least = max(_LEAST * mean, steps[1] ** 2 / 12.0)
    # the score test: squares of normal differences have a variance of twice the square of their
    # mean, and neighbours, which share an error, add half as much
    if not scale > 0.0 or float(spread @ squares) < _UNEVEN * mean * math.sqrt(3.0 * scale):
        return Noise(max(mean - known * float(through.mean()), least), known)
    a, b = mean, 0.0
    for _ in range(_ROUNDS):
        weights = 1.0 / (a + b * through) ** 2
        sums = [float(weights @ (through**k)) for k in range(3)]
        right = float(weights @ squares), float(weights @ (squares * through))
        apart = sums[0] * sums[2] - sums[1] ** 2
        if not apart > 0.0:  # where all that counts has the same transmission, b stays unknown
            break
        b = max((sums[0] * right[1] - sums[1] * right[0]) / apart, known)
        a = max((right[0] - b * sums[1]) / sums[0], least)
    return Noise(a, b)


class Rounding(NamedTuple):
    """Errors of the output that the rounding of both encoders causes and that last.

    steps : of input and output, 0 if unknown [rad].
    repeats : whether the input stood at the same positions again and again; else its rounding
        does not last.
    """

    steps: tuple[float, float]
    repeats: bool

    def explains(self, shaft: str, slope: FloatArray, scale: FloatArray, noise: Noise) -> float:
        """Greatest sum of squares that it explains as an error of a shaft [rad^2].

        Parameters
        ----------
        shaft : str
            An error of the input acts where the transmission is great, others act everywhere.
        slope, scale : ndarray, shape (n,)
            Transmission, and root of the weight of each sample [-].
        noise : Noise
            That of both encoders.
        """
        of_input, of_output = (
            rounding_bias(step, math.sqrt(max(variance - step**2 / 12.0, 0.0)))
            for step, variance in zip(self.steps, (noise.of_input, noise.of_output), strict=True)
        )
        weight = scale**2
        through = float(weight @ slope**2)
        acting = float(weight.sum())
        if shaft == "input" and through > 0.0:
            # of all errors up to a bound, those explain most that have the sign of the column
            acting = float(weight @ np.abs(slope)) ** 2 / through
        lasting = of_input * math.sqrt(through) if self.repeats else 0.0
        return acting * of_output**2 + lasting**2


def rounding_of(angle: FloatArray, steps: tuple[float, float]) -> Rounding:
    """The rounding of readings of the input, of shape (n,) [rad]."""
    return Rounding(steps, steps[0] > 0.0 and _positions(angle, steps[0]) < _REVISITED)


def _positions(angle: FloatArray, step: float) -> float:
    """Number of different positions in a turn, over that of as many positions at random."""
    counts = np.round(np.mod(angle, TURN) / step)
    count = min(TURN, float(np.ptp(angle))) / step
    expected = -count * math.expm1(-counts.size / count)
    return float(np.unique(counts).size / expected)


def rounding_bias(step: float, noise: float) -> float:
    """Greatest error that rounding leaves in the mean of readings at one position [rad].

    Without noise it is half a step. Noise before the rounding makes it smaller: the sawtooth of
    rounding errors loses its harmonics one after the other.

    Parameters
    ----------
    step : float
        Step of the encoder [rad].
    noise : float
        Standard deviation of the noise before rounding [rad].

    Source: Widrow and Kollar, Quantization Noise, 2008, chapter 4.
    """
    if not step > 0.0:
        return 0.0
    left = np.exp(-2.0 * (math.pi * _TERMS * noise / step) ** 2) / (math.pi * _TERMS)
    return step * min(0.5, float(left.sum()))
