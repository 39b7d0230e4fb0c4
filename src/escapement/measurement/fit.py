"""Position function over any number of cells, and the fit of readings to it.

Nobody can set the zeros of two encoders exactly, so least squares finds the phase and the
offset of  sense * phi(input + phase) + offset,  the model of the output's reading.
"""

import math
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from escapement.measurement.readings import TURN, blocks
from escapement.mechanisms.slotted import transmission
from escapement.model import FloatArray, Mechanism

_START_SAMPLES = 1000
_START_PHASES = 120
_ROUNDS = 60
_HALVINGS = 40
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)


def spread_samples(count: int, most: int) -> np.ndarray:
    """Indices of at most `most` of `count` samples, in step with no period of theirs.

    Every tenth sample of an even motion could always meet the same pin; steps of the
    golden ratio cannot.
    """
    if count <= most:
        return np.arange(count)
    return np.unique((count * np.mod(np.arange(1, most + 1) * _GOLDEN, 1.0)).astype(int))


def position(mechanism: Mechanism, theta: FloatArray) -> FloatArray:
    """Follower angle at driver angles over any number of cells [rad].

    Each cell adds the mechanism's step; in the dwell the follower stands still.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    theta : ndarray, shape (n,)
        Driver angle, counted on from dead centre of one cell [rad].
    """
    phi = np.empty_like(theta)
    for part in blocks(theta.size):
        cell, local = _split(mechanism, theta[part])
        # rounding may have moved the angle out of the cell by a hair
        local = np.clip(local, mechanism.breaks[0], mechanism.breaks[-1])
        phi[part] = mechanism.follower_angle(local) + cell * mechanism.follower_step
    return phi


def slope(mechanism: Mechanism, theta: FloatArray) -> FloatArray:
    """Transmission g = dphi/dtheta at driver angles over any number of cells [-].

    Zero in the dwell.
    """
    # a follower that turns back has no path, only a transmission of its own
    read = getattr(mechanism, "transmission", None) or partial(transmission, mechanism.path)
    g, exit_ = np.empty_like(theta), mechanism.breaks[-1]
    for part in blocks(theta.size):
        _, local = _split(mechanism, theta[part])
        g[part] = np.where(local > exit_, 0.0, read(np.minimum(local, exit_)).g)
    return g


def _split(mechanism: Mechanism, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Number of the cell, and the driver angle in it."""
    cell = np.floor((theta - mechanism.breaks[0]) / mechanism.cell_angle)
    return cell, theta - cell * mechanism.cell_angle


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
    """The sum of squares that a sense, a phase and an offset [rad] leave, and these three."""

    squares: float
    sense: int
    phase: float
    offset: float


class _FitTask(NamedTuple):
    """What is to be fitted; the input counts on, the output may start again each turn."""

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
        """How well these zeros fit."""
        rest = self.residual(sense, phase, offset)
        return _Zeros(float(rest @ rest), sense, phase, offset)

    def centred(self, sense: int, phase: float, offset: float) -> _Zeros:
        """The same with the offset that makes the mean error zero."""
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
    task = _FitTask(mechanism, angle, output, wraps)
    if zeros is None:
        some = spread_samples(angle.size, _START_SAMPLES)
        few = _FitTask(mechanism, angle[some], output[some], wraps)
        start = min(_improved(few, zeros) for zeros in _starts(few))
        best = _reduced(task, _improved(task, task.centred(*start[1:])))
    else:
        best = min(task.at(sense, *zeros) for sense in (1, -1))
    _, sense, phase, offset = best
    errors = task.residual(sense, phase, offset)
    g = sense * slope(mechanism, angle + phase)
    uncertain = (0.0, 0.0) if zeros is not None else _standard_errors(g, errors)
    return Fit(phase, offset, *uncertain, sense, output - errors, errors, g)


def _starts(task: _FitTask) -> list[_Zeros]:
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


def _improved(task: _FitTask, zeros: _Zeros) -> _Zeros:
    """Gauss-Newton on the phase; the offset follows from it in closed form."""
    longest = task.mechanism.cell_angle / 20.0
    for _ in range(_ROUNDS):
        g, spread = _varying(zeros.sense * slope(task.mechanism, task.input + zeros.phase))
        if spread == 0.0:
            return zeros
        step = float(g @ task.residual(*zeros[1:])) / spread
        step = math.copysign(min(abs(step), longest), step)
        # a step below a thousandth of the standard error changes nothing that matters
        if abs(step) < max(1e-3 * math.sqrt(zeros.squares / spread / g.size), 1e-14):
            return zeros
        for _ in range(_HALVINGS):
            new = task.centred(zeros.sense, zeros.phase + step, zeros.offset)
            if new.squares < zeros.squares:
                break
            step *= 0.5
        else:
            return zeros
        zeros = new
    return zeros


def _varying(g: FloatArray) -> tuple[FloatArray, float]:
    """Slope less its mean, and the sum of its squares: 0 where that is rounding alone.

    Then the output turns evenly, and no phase can be told.
    """
    rest = g - g.mean()
    spread = float(rest @ rest)
    return rest, 0.0 if spread <= 1e-12 * float(g @ g) else spread


def _reduced(task: _FitTask, zeros: _Zeros) -> _Zeros:
    """The same fit with its phase within half a cell of zero."""
    cells = round(zeros.phase / task.mechanism.cell_angle)
    phase = zeros.phase - cells * task.mechanism.cell_angle
    offset = zeros.offset + zeros.sense * cells * task.mechanism.follower_step
    if task.wraps:
        offset -= TURN * round(offset / TURN)
    return task.at(zeros.sense, phase, offset)


def _standard_errors(g: FloatArray, errors: FloatArray) -> tuple[float, float]:
    """Standard errors of phase and offset, from the inverse of the normal equations."""
    _, spread = _varying(g)
    if spread == 0.0:
        return math.nan, math.nan
    variance = float(errors @ errors) / (g.size - 2)
    of_offset = 1.0 / g.size + float(g.mean()) ** 2 / spread
    return math.sqrt(variance / spread), math.sqrt(variance * of_offset)
