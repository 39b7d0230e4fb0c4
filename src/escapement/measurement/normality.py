"""Are errors normally distributed? Classes of errors, and three tests.

Sets of errors may be tested many at once: leading axes are sets. All tests assume
errors that are independent of each other.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.model import FloatArray

RULES = ("sturges", "scott", "freedman-diaconis", "square-root")
_MOST_CLASSES = 1000


class Histogram(NamedTuple):
    """Errors counted in k classes of equal width; leading axes: sets of errors.

    edges : of the classes, shape (..., k + 1) [rad].
    observed : errors in each, shape (..., k).
    expected : errors in each by the normal law with this mean and standard
        deviation, shape (..., k). Nothing is expected outside the classes.
    mean, standard_deviation : of the class midpoints weighted by frequency [rad].
    """

    edges: FloatArray
    observed: np.ndarray
    expected: FloatArray
    mean: FloatArray
    standard_deviation: FloatArray


def sturges(samples: int) -> float:
    """Sturges' number of classes before rounding, 1 + 3.32 lg n.

    Source: Prikhodko (2020), eq. 10; 3.32 stands for 1/lg 2.
    """
    return 3.32 * math.log10(samples) + 1.0


def class_count(errors: FloatArray, bins: int | str = "sturges") -> int:
    """Number of classes by a rule, or as given.

    Parameters
    ----------
    errors : ndarray, shape (n,)
        Errors, not all equal.
    bins : int or str
        A number, or a rule: "sturges", rounded up; "scott" and
        "freedman-diaconis", which fit the width to the spread; "square-root".

    Raises
    ------
    InvalidValue
        When the rule is unknown or the number below 4: two moments and the sum
        leave such a test no degree of freedom.
    """
    if not isinstance(bins, str):
        remedy = "a chi-squared test needs 4 classes or more"
        return validate.integer("bins", bins, 4, remedy, _MOST_CLASSES)
    rule = validate.choice("bins", bins, RULES)
    n = errors.size
    if rule == "sturges":
        count = sturges(n)
    elif rule == "square-root":
        count = math.sqrt(n)
    else:
        low, high = np.percentile(errors, [25.0, 75.0])
        width = 3.49 * errors.std(ddof=1) if rule == "scott" else 2.0 * (high - low)
        count = float(np.ptp(errors) / (width / n ** (1 / 3))) if width > 0.0 else math.inf
    return math.ceil(min(max(4.0, count), _MOST_CLASSES))


def histogram(errors: ArrayLike, bins: int) -> Histogram:
    """Classes of equal width from the least error to the greatest.

    Parameters
    ----------
    errors : array_like, shape (..., n)
        Errors [rad], not all equal.
    bins : int
        Number of classes.

    Source: Prikhodko (2020), eqs. 11 to 14. Eq. 12 lacks the sum over the classes.
    """
    values = np.asarray(errors, dtype=float)
    n = values.shape[-1]
    low = values.min(axis=-1, keepdims=True)
    width = (values.max(axis=-1, keepdims=True) - low) / bins
    observed = counts(np.minimum(((values - low) / width).astype(int), bins - 1), bins)
    edges = low + width * np.arange(bins + 1)
    middle = edges[..., :-1] + 0.5 * width
    mean = (observed * middle).sum(axis=-1, keepdims=True) / n
    variance = (observed * (middle - mean) ** 2).sum(axis=-1, keepdims=True) / n
    deviation = np.sqrt(variance)
    expected = n * _shares((edges - mean) / deviation)
    return Histogram(edges, observed, expected, mean[..., 0], deviation[..., 0])


def _shares(edges: FloatArray) -> FloatArray:
    """Probability of each class; from the nearer tail, where ends differ by little."""
    from scipy.special import ndtr

    low, high = edges[..., :-1], edges[..., 1:]
    above = low > 0.0
    return np.asarray(ndtr(np.where(above, -low, high)) - ndtr(np.where(above, -high, low)))


def counts(classes: np.ndarray, bins: int) -> np.ndarray:
    """How often each class number below `bins` stands in the last axis."""
    sets = classes.reshape(-1, classes.shape[-1])
    apart = sets + bins * np.arange(len(sets))[:, None]
    found = np.bincount(apart.reshape(-1), minlength=bins * len(sets))
    return found.reshape(*classes.shape[:-1], bins)


class NormalityTest(NamedTuple):
    """A test of the hypothesis that errors follow a normal law.

    statistic : its value, the greater the less normal [-].
    degrees_of_freedom : of the chi-squared law it is compared with; 0 where it is
        compared with another.
    p_value : probability that normal errors give a statistic at least as great. It
        is not the probability that the law is normal.
    """

    statistic: FloatArray
    degrees_of_freedom: int
    p_value: FloatArray


def published_chi_squared(classes: Histogram) -> NormalityTest:
    """Pearson's test as in the paper, with bins - 1 - 2 degrees of freedom.

    At a level of 5 % it rejects normal errors 1.6 to 4.6 times as often, in 11 of
    100 cases with 148 errors in 9 classes: the errors themselves choose the
    outermost classes, where next to nothing is expected. See `chi_squared`.

    Source: Prikhodko (2020), eqs. 15 and 16.
    """
    observed, expected = classes.observed, classes.expected
    with np.errstate(all="ignore"):  # nothing may be expected in a class
        terms = (observed - expected) ** 2 / expected
    statistic = np.where(observed == expected, 0.0, terms).sum(axis=-1)
    return _compared(statistic, classes.observed.shape[-1] - 3)


def chi_squared(errors: ArrayLike, bins: int) -> NormalityTest:
    """Chi-squared test that keeps its level: Rao, Robson and Nikulin's.

    Classes are equally probable under the law with the mean and standard deviation
    of the sample. Taken from the errors and not from the counts, these two take up
    less of Pearson's statistic than two degrees of freedom (Chernoff and Lehmann
    1954). What they take up is known to first order and put back, so that
    bins - 1 degrees remain.

    Parameters
    ----------
    errors : array_like, shape (..., n)
        Errors, not all equal.
    bins : int
        Number of classes, > 3; an expectation of five errors in each is enough.

    Source: Rao and Robson (1974), Communications in Statistics 3; Nikulin (1973),
    Theory of Probability and its Applications 18.
    """
    from scipy.special import ndtr, ndtri

    values = np.asarray(errors, dtype=float)
    expected = values.shape[-1] / bins
    share = ndtr(_standardised(values, ddof=0))
    observed = counts(np.minimum((bins * share).astype(int), bins - 1), bins)
    deviation = (observed - expected) / np.sqrt(expected)
    inner = ndtri(np.arange(1, bins) / bins)
    density = np.exp(-0.5 * inner**2) / np.sqrt(2.0 * np.pi)
    # how fast the classes' probabilities change with mean and deviation, in units of the latter
    rates = np.diff([density, inner * density], prepend=0.0, append=0.0, axis=-1)
    rates *= -np.sqrt(bins)
    information = np.diag([1.0, 2.0]) - rates @ rates.T
    known = deviation @ rates.T
    put_back = (known * np.linalg.solve(information, known[..., None])[..., 0]).sum(axis=-1)
    return _compared((deviation**2).sum(axis=-1) + put_back, bins - 1)


def anderson_darling(errors: ArrayLike) -> NormalityTest:
    """Anderson-Darling test with mean and standard deviation of the sample.

    Parameters
    ----------
    errors : array_like, shape (..., n)
        Errors, not all equal; n >= 8.

    Returns
    -------
    NormalityTest
        With A^2 as statistic; p below 3.7e-24 is given as that.

    Source: D'Agostino and Stephens (1986), Goodness-of-fit techniques, table 4.9.
    """
    from scipy.special import log_ndtr

    z = np.sort(_standardised(np.asarray(errors, dtype=float), ddof=1), axis=-1)
    n = z.shape[-1]
    weight = (2.0 * np.arange(1, n + 1) - 1.0) / n
    statistic = -n - ((log_ndtr(z) + log_ndtr(-z[..., ::-1])) * weight).sum(axis=-1)
    return NormalityTest(statistic, 0, _anderson_darling_p(statistic, n))


def _anderson_darling_p(statistic: FloatArray, n: int) -> FloatArray:
    """p-value of A^2, mean and standard deviation being those of the sample."""
    a = np.minimum(statistic * (1.0 + 0.75 / n + 2.25 / n**2), 10.0)
    p_values = [
        np.exp(1.2937 - 5.709 * a + 0.0186 * a**2),
        np.exp(0.9177 - 4.279 * a - 1.38 * a**2),
        1.0 - np.exp(-8.318 + 42.796 * a - 59.938 * a**2),
    ]
    smallest = 1.0 - np.exp(-13.436 + 101.14 * a - 223.73 * a**2)
    return np.select([a >= 0.6, a > 0.34, a > 0.2], p_values, smallest)


def _compared(statistic: FloatArray, degrees_of_freedom: int) -> NormalityTest:
    from scipy.special import chdtrc

    return NormalityTest(statistic, degrees_of_freedom, chdtrc(degrees_of_freedom, statistic))


def _standardised(values: FloatArray, ddof: int) -> FloatArray:
    centred = values - values.mean(axis=-1, keepdims=True)
    scaled: FloatArray = centred / values.std(axis=-1, ddof=ddof, keepdims=True)
    return scaled
