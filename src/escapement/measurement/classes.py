"""Classes of errors: how many, how wide, and how many errors a normal law expects."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.model import FloatArray

RULES = ("sturges", "scott", "freedman-diaconis", "square-root")
MOST_CLASSES = 1000


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
        count = validate.integer("bins", bins, 4, "a chi-squared test needs 4 classes or more")
        if count > MOST_CLASSES:
            raise validate.fail("bins", f"at most {MOST_CLASSES}", count, "give fewer classes")
        return count
    rule = validate.choice("bins", bins, RULES)
    n, spread = errors.size, float(np.ptp(errors))
    if rule == "sturges":
        return max(4, math.ceil(sturges(n)))
    if rule == "square-root":
        return min(max(4, math.ceil(math.sqrt(n))), MOST_CLASSES)
    if rule == "scott":
        width = 3.49 * float(errors.std(ddof=1)) / n ** (1 / 3)
    else:
        quarter = np.percentile(errors, [25.0, 75.0])
        width = 2.0 * float(np.diff(quarter)[0]) / n ** (1 / 3)
    return max(4, min(math.ceil(spread / width), MOST_CLASSES)) if width > 0.0 else MOST_CLASSES


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
