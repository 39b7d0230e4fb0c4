"""Measured beats, sorted by their pin and slot."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.text import Shown
from escapement.measurement.jitter import share_of, whitening
from escapement.measurement.ticks import ticks_of
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class Rounds(Shown):
    """Beats in rows; each row contains all pairs of pins and slots once.

    table : ndarray, shape (rounds, pattern)
        Beats [s], NaN where one is missing.
    jitter : float
        Share of the variance of a beat's noise that comes from the jitter of time stamps, so that
        the correlation of neighbouring beats is -jitter/2 [-].
    faults : tuple of str
        Ticks that were missed, doubled or out of place, in words.
    """

    table: FloatArray
    jitter: float = 0.0
    faults: tuple[str, ...] = ()

    @property
    def pattern(self) -> int:
        """Engagements after which pins and slots meet again."""
        return int(self.table.shape[1])

    @property
    def samples(self) -> int:
        """Number of measured beats."""
        return int(self.counts.sum())

    @cached_property
    def counts(self) -> np.ndarray:
        """How often each engagement of the pattern was measured, shape (pattern,)."""
        return np.asarray(np.isfinite(self.table).sum(axis=0))

    @cached_property
    def known(self) -> np.ndarray:
        """Indices of the measured beats in turn, shape (samples,)."""
        return np.flatnonzero(np.isfinite(self.table.ravel()))

    @cached_property
    def _solved(self) -> tuple[FloatArray, FloatArray, float]:
        """Means, the root of their information, and what is left."""
        white, _ = whitening(self.known, self.jitter)
        values = white(self.table.ravel()[self.known])
        basis, root = np.linalg.qr(white(_indices(self.known, self.pattern)))
        means = np.linalg.solve(root, basis.T @ values)
        rest = values - basis @ (basis.T @ values)
        return np.asarray(means), np.asarray(root), float(rest @ rest)

    @property
    def means(self) -> FloatArray:
        """Best estimate of the beat of each engagement of the pattern, shape (pattern,) [s]."""
        return self._solved[0]

    @property
    def root(self) -> FloatArray:
        """R such that R (means - true means) is independent noise of one beat's size."""
        return self._solved[1]

    @cached_property
    def spread(self) -> FloatArray:
        """Standard deviation of each mean less the mean of all, for noise of one beat of 1 [-].

        Shape (pattern,). Time stamps make it smaller than with independent beats, because a stamp
        that comes late makes one beat longer and the next one shorter.
        """
        weights = np.eye(self.pattern) - 1.0 / self.pattern
        return np.asarray(np.linalg.norm(weights @ np.linalg.inv(self.root), axis=1))

    @property
    def scatter(self) -> float:
        """Sum of the squared deviations from the means, made independent [s^2]."""
        return self._solved[2]

    def white(self, computed: FloatArray) -> FloatArray:
        """Measured beats less computed ones of one pattern, made independent, shape (samples,)."""
        white, _ = whitening(self.known, self.jitter)
        return np.asarray(white((self.table - computed).ravel()[self.known]))


def _indices(known: np.ndarray, pattern: int) -> FloatArray:
    """One in the column of the engagement that each beat belongs to, shape (samples, pattern)."""
    return np.asarray(np.eye(pattern)[known % pattern])


def rounds_of(given: ArrayLike, wheel: Geneva, times: bool = False) -> Rounds:
    """Beats or time stamps as rounds, the last of which may end early; see `fit_beats`."""
    size = math.lcm(wheel.pins or 1, wheel.slots)
    values, faults = ticks_of(given, times, size)
    padded = np.full(-(-max(values.size, 1) // size) * size, np.nan)
    padded[: values.size] = values
    found = Rounds(padded.reshape(-1, size), 0.0, faults)
    if found.counts.min() == 0:
        k = int(found.counts.argmin())
        amiss = f" ({'; '.join(faults)})" if faults else ""
        raise InvalidValue(
            f"beats must tell of all {size} engagements of the pattern, got none of pin "
            f"{k % (wheel.pins or 1)} in slot {k % wheel.slots}{amiss}; measure longer"
        )
    known = found.known
    jitter = share_of(padded[known], _indices(known, size), known, times)
    return replace(found, jitter=jitter)


def checked_wheel(mechanism: Any) -> Geneva:
    """A mechanism whose pins and slots may have errors, or InvalidValue."""
    if isinstance(mechanism, Geneva):
        return mechanism
    raise validate.fail("mechanism", "a Geneva wheel", mechanism, "see escapement.Geneva")
