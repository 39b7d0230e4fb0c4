"""Single readings far out, which noise practically never causes.

A reading is judged by its error over the standard deviation of the others (Rosner 1983): the
greatest is tested, then the greatest of the rest, and so on, so that some do not hide others.
"""

import numpy as np

from escapement.base.lazy import Lazy
from escapement.mechanisms.protocol import FloatArray

special = Lazy("scipy.special")
_MOST = 0.01  # if more readings than this share are far out, the errors are just not normal
_FEWEST = 3  # but so many are always tried


def far_out(errors: FloatArray, level: float) -> tuple[np.ndarray, FloatArray]:
    """Samples that are far out, and the p-value of each.

    Parameters
    ----------
    errors : ndarray, shape (n,)
        Independent errors of equal variance about zero.
    level : float
        Samples with a p-value below this are far out.

    Source: B. Rosner, Percentage points for a generalized ESD many-outlier procedure, 1983.
    """
    n = errors.size
    most = max(_FEWEST, int(_MOST * n))
    order = np.argpartition(np.abs(errors), n - most)[n - most :]
    order = order[np.argsort(-np.abs(errors[order]))]
    squares = errors[order] ** 2
    # the squares of the others, with ever more of the greatest left out
    inner = float(errors @ errors) - np.cumsum(squares)
    left = n - 1 - np.arange(most)
    known = inner > 0.0
    ratio = np.sqrt(squares[known] * left[known] / inner[known])
    p_values = np.minimum(2.0 * (left[known] + 1) * special.stdtr(left[known], -ratio), 1.0)
    last = np.flatnonzero(p_values < level)
    count = int(last[-1]) + 1 if last.size else 0
    return order[:count], p_values[:count]
