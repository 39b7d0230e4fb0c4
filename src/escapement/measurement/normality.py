"""Are errors normally distributed? Classes of errors, the test of the paper, and a better one.

All tests assume errors that are independent of each other.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.lazy import Lazy
from escapement.mechanisms.protocol import FloatArray

special, stats = Lazy("scipy.special"), Lazy("scipy.stats")
_MOST_CLASSES = 1000


class Histogram(NamedTuple):
    """Numbers of errors in k classes of equal width.

    edges : edges of the classes, shape (k + 1,) [rad].
    observed : number of errors in each class, shape (k,).
    expected : number of errors in each class expected of a normal distribution, shape (k,).
        Its mean and standard deviation are those of the class midpoints, weighted by `observed`.
        What it expects outside the classes is left out.
    """

    edges: FloatArray
    observed: np.ndarray
    expected: FloatArray


def sturges(samples: int) -> float:
    """Sturges' number of classes before rounding, 1 + 3.32 lg n.

    Source: Prikhodko (2020), eq. 10; 3.32 stands for 1/lg 2.
    """
    return 3.32 * math.log10(samples) + 1.0


def _of_width(width: float, errors: FloatArray) -> float:
    """Number of classes of a width for one error, which shrinks with their cube root."""
    return float(np.ptp(errors) / width) * errors.size ** (1 / 3) if width > 0.0 else math.inf


RULES: dict[str, Callable[[FloatArray], float]] = {
    "sturges": lambda errors: sturges(errors.size),
    "scott": lambda errors: _of_width(3.49 * errors.std(ddof=1), errors),
    "freedman-diaconis": lambda errors: _of_width(2.0 * stats.iqr(errors), errors),
    "square-root": lambda errors: math.sqrt(errors.size),
}
"""Number of classes, before rounding, by the rule's name."""


def class_count(errors: FloatArray, bins: int | str = "sturges") -> int:
    """Number of classes by a rule, or as given.

    Parameters
    ----------
    errors : ndarray, shape (n,)
        Errors, not all equal.
    bins : int or str
        A number, or a rule whose result is rounded up: "sturges", "square-root", or "scott"
        and "freedman-diaconis", which choose the width of a class by the spread of the errors.

    Raises
    ------
    InvalidValue
        If the rule is unknown or the number is below 4: such a test would have no degree of
        freedom left.
    """
    if not isinstance(bins, str):
        remedy = "a chi-squared test needs 4 classes or more"
        return validate.integer("bins", bins, 4, remedy, _MOST_CLASSES)
    count = RULES[validate.choice("bins", bins, tuple(RULES))](errors)
    return math.ceil(min(max(4.0, count), _MOST_CLASSES))


def histogram(errors: ArrayLike, bins: int) -> Histogram:
    """Classes of equal width from the least error to the greatest.

    Parameters
    ----------
    errors : array_like, shape (n,)
        Errors [rad], not all equal.
    bins : int
        Number of classes.

    Source: Prikhodko (2020), eqs. 11 to 14. Eq. 12 lacks the sum over the classes.
    """
    observed, edges = np.histogram(errors, bins)
    n, middle = observed.sum(), 0.5 * (edges[1:] + edges[:-1])
    mean = observed @ middle / n
    z = (edges - mean) / math.sqrt(observed @ (middle - mean) ** 2 / n)
    # from the nearer tail, where the ends of a class differ by little
    shares = np.where(z[:-1] > 0.0, np.diff(special.ndtr(-z)), np.diff(special.ndtr(z)))
    return Histogram(edges, observed, n * np.abs(shares))


class NormalityTest(NamedTuple):
    """A test of the hypothesis that errors are normally distributed.

    statistic : value of the test's statistic; it is greater if the errors are less normal [-].
    degrees_of_freedom : degrees of freedom of the chi-squared distribution with which the
        statistic is compared; 0 if it is compared with another one.
    p_value : probability that normal errors give a statistic at least as great. It
        is not the probability that the errors are normal.
    """

    statistic: float
    degrees_of_freedom: int
    p_value: float


def published_chi_squared(classes: Histogram) -> NormalityTest:
    """Pearson's test as in the paper, with bins - 1 - 2 degrees of freedom.

    At a level of 5 % it rejects normal errors 1.6 to 4.6 times as often as it should, for
    example in 11 of 100 cases with 148 errors in 9 classes. The reason is that the outermost
    classes depend on the errors, and almost none are expected there. See `anderson_darling`.

    Source: Prikhodko (2020), eqs. 15 and 16.
    """
    observed, expected = classes.observed, classes.expected
    with np.errstate(all="ignore"):  # nothing may be expected in a class
        terms = (observed - expected) ** 2 / expected
    statistic = float(np.where(observed == expected, 0.0, terms).sum())
    freedom = observed.size - 3
    return NormalityTest(statistic, freedom, float(special.chdtrc(freedom, statistic)))


def anderson_darling(errors: ArrayLike) -> NormalityTest:
    """Anderson-Darling test with mean and standard deviation of the sample.

    Parameters
    ----------
    errors : array_like, shape (n,)
        Errors, not all equal; n >= 8.

    Returns
    -------
    NormalityTest
        Its statistic is A^2. A p-value below 3.7e-24 is given as 3.7e-24.

    Source: D'Agostino and Stephens (1986), Goodness-of-fit techniques, table 4.9.
    """
    z = np.sort(stats.zscore(errors, ddof=1))
    logs = special.log_ndtr(z) + special.log_ndtr(-z[::-1])
    statistic = float(-z.size - logs @ (np.arange(1, 2 * z.size, 2) / z.size))
    return NormalityTest(statistic, 0, _anderson_darling_p(statistic, z.size))


_STEPHENS = (
    (0.6, 1.2937, -5.709, 0.0186), (0.34, 0.9177, -4.279, -1.38),
    (0.2, -8.318, 42.796, -59.938), (-math.inf, -13.436, 101.14, -223.73),
)  # fmt: skip
"""Least A^2, and the coefficients of its powers in the logarithm of p, or of 1 - p below .34."""


def _anderson_darling_p(statistic: float, n: int) -> float:
    """p-value of A^2, mean and standard deviation being those of the sample."""
    a = min(statistic * (1.0 + 0.75 / n + 2.25 / n**2), 10.0)
    least, *factors = next(row for row in _STEPHENS if a >= row[0])
    p_value = math.exp(np.polynomial.polynomial.polyval(a, factors))
    return p_value if least > 0.3 else 1.0 - p_value
