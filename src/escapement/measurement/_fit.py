"""Least squares for the two zeros that nobody can set exactly: phase and offset.

The reading of the output is modelled as  sense * phi(input + phase) + offset.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from escapement.measurement._position import position, slope
from escapement.measurement.readings import TURN, spread
from escapement.model import FloatArray, Mechanism

_START_SAMPLES = 1000
_START_PHASES = 120
_ROUNDS = 60
_HALVINGS = 40


@dataclass(frozen=True, eq=False)
class Fit:
    """Zeros of the encoders and what remains of the readings.

    phase : driver angle from dead centre where the input reads zero [rad].
    offset : reading of the output where the follower angle is zero [rad].
    phase_error, offset_error : their standard errors if the errors are independent
        of each other [rad]; 0 where they were given, NaN where the readings do not
        tell: the output never changes its speed.
    sense : 1 where the output counts up while the driver does, else -1.
    theory : output the mechanism should have shown, shape (n,) [rad].
    errors : measured less theory, shape (n,) [rad].
    slope : rate of theory over input, shape (n,) [-].
    """

    phase: float
    offset: float
    phase_error: float
    offset_error: float
    sense: int
    theory: FloatArray
    errors: FloatArray
    slope: FloatArray


class _Zeros(NamedTuple):
    """A sense, a phase and an offset [rad], the sum of squares they leave first."""

    squares: float
    sense: int
    phase: float
    offset: float


class _Task(NamedTuple):
    """What is to be fitted: the input counts on, the output may start again."""

    mechanism: Mechanism
    input: FloatArray
    output: FloatArray
    wraps: bool

    def residual(self, sense: int, phase: float, offset: float) -> FloatArray:
        """Output less theory; of an output that starts again, the nearest."""
        rest = self.output - sense * position(self.mechanism, self.input + phase) - offset
        if self.wraps:
            rest -= TURN * np.round(rest / TURN)
        return rest

    def at(self, sense: int, phase: float, offset: float) -> _Zeros:
        rest = self.residual(sense, phase, offset)
        return _Zeros(float(rest @ rest), sense, phase, offset)

    def centred(self, sense: int, phase: float, offset: float) -> _Zeros:
        """With the offset that leaves errors of mean zero."""
        offset += float(self.residual(sense, phase, offset).mean())
        return self.at(sense, phase, offset)


def fit(
    mechanism: Mechanism,
    angle: FloatArray,
    output: FloatArray,
    wraps: bool,
    zeros: tuple[float, float] | None = None,
) -> Fit:
    """Fit the sense of the output, and phase and offset unless they are given.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    angle, output : ndarray, shape (n,)
        Readings [rad]; the input counts on.
    wraps : bool
        Whether the output starts again at zero each turn.
    zeros : (float, float), optional
        Phase and offset where they are known [rad].
    """
    task = _Task(mechanism, angle, output, wraps)
    if zeros is None:
        some = spread(angle.size, _START_SAMPLES)
        few = _Task(mechanism, angle[some], output[some], wraps)
        start = min(_improved(few, zeros) for zeros in _starts(few))
        best = _reduced(task, _improved(task, task.centred(*start[1:])))
    else:
        best = min(task.at(sense, *zeros) for sense in (1, -1))
    errors = task.residual(*best[1:])
    g = best.sense * slope(mechanism, angle + best.phase)
    uncertain = (0.0, 0.0) if zeros is not None else _standard_errors(g, errors)
    return Fit(
        best.phase, best.offset, *uncertain, best.sense, output - errors, errors, g,
    )  # fmt: skip


def _starts(task: _Task) -> list[_Zeros]:
    """For each sense the best phase on a grid over one cell.

    The mean direction of the residuals on a circle tells the offset, and its length
    how well they agree, whether the turns of the output are counted or not.
    """
    phases = np.arange(_START_PHASES) / _START_PHASES * task.mechanism.cell_angle
    angles = np.add.outer(phases, task.input)
    phi = position(task.mechanism, angles.reshape(-1)).reshape(angles.shape)
    starts = []
    for sense in (1, -1):
        turns = np.exp(1j * (task.output - sense * phi)).mean(axis=1)
        best = int(np.argmax(np.abs(turns)))
        starts.append(task.centred(sense, float(phases[best]), float(np.angle(turns[best]))))
    return starts


def _improved(task: _Task, zeros: _Zeros) -> _Zeros:
    """Gauss-Newton on the phase; the offset follows from it in closed form."""
    longest = task.mechanism.cell_angle / 20.0
    for _ in range(_ROUNDS):
        g = zeros.sense * slope(task.mechanism, task.input + zeros.phase)
        g, steady = _varying(g)
        if steady:
            break
        spread = float(g @ g)
        step = float(g @ task.residual(*zeros[1:])) / spread
        step = math.copysign(min(abs(step), longest), step)
        # a thousandth of the standard error is near enough
        if abs(step) < max(1e-3 * math.sqrt(zeros.squares / spread / g.size), 1e-14):
            break
        for _ in range(_HALVINGS):
            new = task.centred(zeros.sense, zeros.phase + step, zeros.offset)
            if new.squares < zeros.squares:
                break
            step *= 0.5
        else:
            break
        zeros = new
    return zeros


def _varying(g: FloatArray) -> tuple[FloatArray, bool]:
    """Slope less its mean, and whether nothing is left: then no phase can be told."""
    rest = g - g.mean()
    return rest, bool(rest @ rest <= 1e-12 * (g @ g))


def _reduced(task: _Task, zeros: _Zeros) -> _Zeros:
    """The same fit with its phase within half a cell of zero."""
    cells = round(zeros.phase / task.mechanism.cell_angle)
    phase = zeros.phase - cells * task.mechanism.cell_angle
    offset = zeros.offset + zeros.sense * cells * task.mechanism.follower_step
    if task.wraps:
        offset -= TURN * round(offset / TURN)
    return task.at(zeros.sense, phase, offset)


def _standard_errors(g: FloatArray, errors: FloatArray) -> tuple[float, float]:
    """Of phase and offset, from the inverse of the normal equations."""
    rest, steady = _varying(g)
    n = g.size
    variance = float(errors @ errors) / (n - 2)
    if steady:
        return math.nan, math.nan
    spread = float(rest @ rest)
    return (
        math.sqrt(variance / spread),
        math.sqrt(variance * (1.0 / n + float(g.mean()) ** 2 / spread)),
    )
