"""What two encoders read: angles of input and output, sample by sample."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.errors import InvalidValue
from escapement.model import FloatArray

TURN = 2.0 * np.pi
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)
FARTHEST = 1e10 * TURN
"""Angle beyond which a double soon no longer tells a thousandth of a degree [rad]."""
WITHIN = "within 1e10 turns of zero, where a double tells a thousandth of a degree"
LEAST_SAMPLES = 20
"""Fewer leave nothing to test once a fit and the classes have taken their share."""


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings of an encoder on the input and of one on the output.

    Parameters
    ----------
    input, output : array_like, shape (n,)
        Angles in the order in which they were taken [rad]; NaN or masked where a
        reading is missing. A column that stays within one turn is taken for one that
        starts again at zero each turn, any other as counting on.
    line : array_like of int, shape (n,), optional
        Line of each sample in its file. Default: 1, 2, ...
    synthetic : bool
        Whether the readings were computed and not measured.
    remark : str
        A sentence that a reader of the figures must know.

    Raises
    ------
    InvalidValue
        When the columns do not match, hold infinite angles or ones beyond 1e10 turns,
        have fewer than 20 complete samples, or the input does not turn.
    """

    input: FloatArray
    output: FloatArray
    line: np.ndarray | None = None
    synthetic: bool = False
    remark: str = ""

    def __post_init__(self) -> None:
        columns = {name: _column(name, getattr(self, name)) for name in ("input", "output")}
        size = columns["input"].size
        lines = np.arange(1, size + 1) if self.line is None else np.asarray(self.line)
        if columns["output"].size != size or lines.shape != (size,):
            raise InvalidValue(
                f"input, output and line must be of one length, got {size}, "
                f"{columns['output'].size} and {lines.size}; give NaN for a missing reading"
            )
        for name, values in (*columns.items(), ("line", lines)):
            object.__setattr__(self, name, values)
        if self.samples < LEAST_SAMPLES:
            raise InvalidValue(
                f"readings must have at least {LEAST_SAMPLES} complete samples, "
                f"got {self.samples} of {size}; measure longer"
            )
        if np.ptp(self.input[self.complete]) == 0.0:
            raise InvalidValue(
                "input must turn, got the same angle in every sample; "
                "check which column is the input"
            )

    @cached_property
    def complete(self) -> np.ndarray:
        """Where both readings are there: bool, shape (n,)."""
        return np.isfinite(self.input) & np.isfinite(self.output)

    @cached_property
    def counted_input(self) -> FloatArray:
        """Input that counts on over turns, NaN where it is missing, shape (n,) [rad]."""
        known = np.flatnonzero(np.isfinite(self.input))
        angle = self.input[known]
        if not wraps(angle):
            return self.input
        counted = np.full_like(self.input, np.nan)
        counted[known] = unwrapped(angle, known)
        return counted

    @property
    def samples(self) -> int:
        """How many samples are complete."""
        return int(np.count_nonzero(self.complete))

    @property
    def missing(self) -> int:
        """How many samples are not."""
        return self.input.size - self.samples


def _column(name: str, values: ArrayLike) -> FloatArray:
    array: np.ma.MaskedArray[Any, Any] = np.ma.asanyarray(values)
    if array.dtype.kind not in "iuf" or array.ndim != 1:
        raise validate.fail(
            name, "a row of real numbers", _shape(array), "give the angles in rad, one a sample"
        )
    angles: FloatArray = np.ma.filled(array.astype(float, copy=False), np.nan)
    if np.isinf(angles).any():
        place = int(np.flatnonzero(np.isinf(angles))[0])
        raise InvalidValue(
            f"{name} must be finite, got {float(angles[place])!r} in sample {place + 1}; "
            "give NaN for a missing reading"
        )
    far = np.flatnonzero(np.abs(angles) > FARTHEST)
    if far.size:
        raise InvalidValue(
            f"{name} must be {WITHIN}, got {float(angles[far[0]])!r} rad in sample {far[0] + 1}; "
            "give NaN for a reading that is none"
        )
    return angles


def _shape(array: np.ndarray) -> str:
    return f"{array.dtype} of shape {array.shape}"


def spread_samples(count: int, most: int) -> np.ndarray:
    """Indices of at most `most` of `count` samples, in step with no period of theirs.

    Every tenth sample of an even motion could always meet the same pin; steps of the
    golden ratio cannot.
    """
    if count <= most:
        return np.arange(count)
    return np.unique((count * np.mod(np.arange(1, most + 1) * _GOLDEN, 1.0)).astype(int))


def wraps(angle: FloatArray) -> bool:
    """Whether angles [rad] stay within a turn: an encoder that starts again at zero."""
    return bool(np.ptp(angle) <= TURN * (1.0 + 1e-9))


def unwrapped(angle: FloatArray, place: np.ndarray) -> FloatArray:
    """Input angles that count on over turns [rad].

    Neighbouring samples are taken to be less than half a turn apart, the first to lie
    within half a turn of zero. Across samples without an input the latter is taken to have gone
    on at its usual pace meanwhile.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        Angles within a turn [rad].
    place : ndarray of int, shape (n,)
        Number of each sample, those without an input counted.
    """
    step = np.diff(angle)
    turns = -np.round(step / TURN)
    apart = np.diff(place)
    near = apart == 1
    if near.any() and not near.all():
        pace = float(np.median((step + TURN * turns)[near]))
        turns = np.where(near, turns, np.round((pace * apart - step) / TURN))
    first = -np.round(angle[0] / TURN)
    counted: FloatArray = angle + TURN * (first + np.concatenate([[0.0], np.cumsum(turns)]))
    return counted
