"""Noise of measured beats: some of each beat alone, and some from the jitter of time stamps.

A stamp that comes late makes the beat before it longer and the one after it shorter. Let s be the
share of the variance of a beat that comes from the stamps at its ends. Then the correlation of
neighbouring beats is -s/2, and that of others is 0: noise of beats alone has s = 0, and that of
stamps alone s = 1, a moving average of first order.
"""

import math
from collections.abc import Callable

import numpy as np

from escapement.base.lazy import Lazy
from escapement.mechanisms.protocol import FloatArray

linalg, optimize = Lazy("scipy.linalg"), Lazy("scipy.optimize")
_ENOUGH = 10  # degrees of freedom from which on the share is estimated
_SURE = 10.83  # twice the gain of log-likelihood that chance exceeds once in a thousand times


def whitening(known: np.ndarray, share: float) -> tuple[Callable[[FloatArray], FloatArray], float]:
    """What turns noise of beats into independent noise of the same size, and its log determinant.

    Parameters
    ----------
    known : ndarray of int, shape (n,)
        Indices of the beats in the sequence; those between them are missing.
    share : float
        Share of the variance that comes from time stamps, in [0, 1].

    Returns
    -------
    function, float
        Of columns of shape (n,) or (n, m); and the logarithm of the determinant of the covariance
        of noise whose variance is 1.
    """
    if share == 0.0:
        return np.asarray, 0.0
    band = np.ones((2, known.size))
    band[1, :-1] = np.where(np.diff(known) == 1, -0.5 * share, 0.0)
    band[1, -1] = 0.0
    factor = linalg.cholesky_banded(band, lower=True)

    def white(columns: FloatArray) -> FloatArray:
        return np.asarray(linalg.solve_banded((1, 0), factor, columns))

    return white, 2.0 * float(np.log(factor[0]).sum())


def share_of(values: FloatArray, design: FloatArray, known: np.ndarray, stamps: bool) -> float:
    """Share of the variance that comes from time stamps, by restricted maximum likelihood.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Beats.
    design : ndarray, shape (n, p)
        Columns whose combination they are, except for noise.
    known : ndarray of int, shape (n,)
        Their indices in the sequence.
    stamps : bool
        Whether they are known to be differences of time stamps. If they are not, the share is 0
        unless the beats show with certainty that it is not; if they are, and are too few to show
        it, it is 1.
    """
    left = values.size - design.shape[1]
    if left < _ENOUGH:
        return float(stamps)

    def misfit(share: float) -> float:
        """Minus twice the logarithm of the restricted likelihood."""
        white, size = whitening(known, share)
        basis, upper = np.linalg.qr(white(design))
        rest = white(values)
        rest = rest - basis @ (basis.T @ rest)
        sizes = np.log(np.abs(np.diag(upper))).sum()
        return float(left * math.log(rest @ rest or 1e-300) + size + 2.0 * sizes)

    found = optimize.minimize_scalar(misfit, bounds=(0.0, 1.0), method="bounded")
    trials = {share: misfit(share) for share in (0.0, float(found.x), 1.0)}
    best = min(trials, key=lambda share: trials[share])
    certain = trials[0.0] - trials[best] > _SURE
    return best if stamps or certain else 0.0
