"""Whether a fitted motion explains the readings: tests of its residuals.

Two things are asked. Do the residuals contain something that noise does not: a slow change, or one
that repeats with the engagements? And do the readings show the mechanism at all, or would a smooth
curve explain them as well?
"""

import math

import numpy as np

from escapement.base.lazy import Lazy
from escapement.mechanisms.protocol import FloatArray

special = Lazy("scipy.special")
SURE = 1e-3  # a p-value below this contradicts the model
_SLOW = 6  # slow changes that are looked for have up to so many half waves
_EXACT = 1e-8  # a scatter below this share of the travel is rounding, and is no evidence
_DEGREE = 3  # of the smooth curve
_ODDS = 1000.0  # the model must be so much more likely than the smooth curve
_LEAST = 12  # degrees of freedom that the tests need


def correlation(residuals: FloatArray) -> float:
    """Correlation of each residual with the next one [-]."""
    return float(residuals[1:] @ residuals[:-1] / (residuals @ residuals))


def chance(residuals: FloatArray, slopes: FloatArray, cells: FloatArray) -> float:
    """Probability that independent noise leaves as much slow or repeated change; NaN if unknown.

    Parameters
    ----------
    residuals : ndarray, shape (n,)
        With a mean of 0 [rad].
    slopes : ndarray, shape (n, m)
        Derivatives of the residuals by the unknowns that were fitted.
    cells : ndarray, shape (n,)
        Driver angle in cells of the mechanism [-].

    Notes
    -----
    An F test of half waves over the recording, and of one and two waves over a cell, beyond what
    the unknowns could have fitted.
    """
    size, unknowns = residuals.size, slopes.shape[1] + 1
    if size - unknowns < _LEAST:
        return math.nan
    angle = np.pi * (np.arange(size) + 0.5) / size
    angles = 2.0 * np.pi * cells
    slow = [np.cos(k * angle) for k in range(1, _SLOW + 1)]
    repeated = [wave(k * angles) for k in (1, 2) for wave in (np.cos, np.sin)]
    waves = np.column_stack([*slow[:2], *repeated, *slow[2:]])[:, : (size - unknowns) // 3]
    # the waves less all that the unknowns and the zero of the encoder can fit
    fitted, _ = np.linalg.qr(np.column_stack([np.ones(size), _scaled(slopes)]))
    basis, sizes, _ = np.linalg.svd(waves - fitted @ (fitted.T @ waves), full_matrices=False)
    basis = basis[:, sizes > 1e-6 * math.sqrt(size)]
    rest = residuals - fitted @ (fitted.T @ residuals)
    found, count = float(np.sum((basis.T @ rest) ** 2)), basis.shape[1]
    left = size - unknowns - count
    noise = (float(rest @ rest) - found) / left
    return float(special.fdtrc(count, left, found / count / noise)) if noise > 0.0 else math.nan


def _scaled(columns: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(columns, axis=0)
    return columns / np.where(lengths > 0.0, lengths, 1.0)


def is_exact(residuals: FloatArray, travel: float) -> bool:
    """Whether the residuals are so small that they are rounding and not noise."""
    return float(np.abs(residuals).max()) <= _EXACT * travel


def smooth_as_well(time: FloatArray, angle: FloatArray, residuals: FloatArray) -> bool:
    """Whether a smooth curve explains the readings about as well as the model.

    Parameters
    ----------
    time, angle : ndarray, shape (n,)
        Of the samples after the release [s, rad].
    residuals : ndarray, shape (n,)
        Those of the model [rad].
    """
    if time.size < _LEAST:
        return True
    half = 0.5 * float(np.ptp(time))
    at = (time - time[0]) / half - 1.0
    curve = np.polynomial.Polynomial.fit(at, angle, _DEGREE, domain=[-1.0, 1.0])
    left = float(np.sum((angle - curve(at)) ** 2))
    # the likelihood of normal noise falls with the n-th power of the scatter
    square = max(float(residuals @ residuals), 1e-30 * left)
    return bool(0.5 * time.size * math.log(left / square) < math.log(_ODDS)) if left > 0.0 else True
