"""Counters of few bits: a register that is full starts again, and the angle seems to jump."""

import numpy as np

from escapement.mechanisms.protocol import FloatArray

_BITS = (8, 16, 24, 32)
_NEAR = 0.25  # neighbours must be nearer than this share of the register once it is undone


def unrolled(angle: FloatArray, count: float, turn: float) -> tuple[FloatArray, int, int]:
    """Angles that go on counting where their register started again.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        Angles, NaN where they are missing [rad].
    count : float
        Angle of one count [rad].
    turn : float
        A register of just one turn starts again each turn, which is no roll-over [rad].

    Returns
    -------
    angle : ndarray, shape (n,)
        The same array if nothing rolled over [rad].
    bits : int
        Bits of the register, 0 if nothing rolled over.
    first : int
        First sample behind a roll-over.
    """
    present = np.flatnonzero(np.isfinite(angle))
    counts = angle[present] / count
    if counts.size < 2:
        return angle, 0, 0
    jumps = np.diff(counts)
    for bits in _BITS:
        size = 2.0**bits
        over = np.round(jumps / size)
        rest = np.abs(jumps - size * over)
        alike = np.ptp(counts) < size and rest.max() < _NEAR * size
        if alike and over.any() and abs(size * count - turn) > 1e-9 * turn:
            found = angle.copy()
            found[present[1:]] -= size * count * np.cumsum(over)
            return found, bits, int(present[1 + np.argmax(over != 0.0)])
    return angle, 0, 0
