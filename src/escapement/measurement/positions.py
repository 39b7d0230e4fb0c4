"""Position function over any number of cells, and the fit of readings to it.

The zeros of two encoders cannot be set exactly. Therefore the output's reading is modelled as
sense * phi(input + phase) + offset,  and least squares finds the phase and the offset.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from escapement.base.lazy import Lazy
from escapement.base.text import Shown
from escapement.measurement.readings import TURN, blocks, wraps
from escapement.mechanisms.protocol import FloatArray, Mechanism

optimize = Lazy("scipy.optimize")
_START_SAMPLES = 1000
_START_PHASES = 120
# the fit ends if a step changes the phase or the sum of squares by such a share
_NEAR = dict.fromkeys(("ftol", "xtol", "gtol"), 1e-12)
Zeros = tuple[int, float, float]
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)


def spread_samples(count: int, most: int) -> np.ndarray:
    """Indices of at most `most` of `count` samples, spread evenly but without a period.

    Every tenth sample could always show the same pin; steps of the golden ratio cannot.
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
        # rounding may have moved the angle out of the cell
        local = np.clip(local, mechanism.breaks[0], mechanism.breaks[-1])
        phi[part] = mechanism.follower_angle(local) + cell * mechanism.follower_step
    return phi


def slope(mechanism: Mechanism, theta: FloatArray) -> FloatArray:
    """Transmission g = dphi/dtheta at driver angles over any number of cells [-].

    It is zero in the dwell.
    """
    g, exit_ = np.empty_like(theta), mechanism.breaks[-1]
    for part in blocks(theta.size):
        _, local = _split(mechanism, theta[part])
        g[part] = np.where(local > exit_, 0.0, mechanism.transmission(np.minimum(local, exit_)).g)
    return g


def _split(mechanism: Mechanism, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Number of the cell, and the driver angle in it."""
    cell = np.floor((theta - mechanism.breaks[0]) / mechanism.cell_angle)
    return cell, theta - cell * mechanism.cell_angle


@dataclass(frozen=True, eq=False, repr=False)
class Positions(Shown):
    """Zeros of the encoders, and the errors of the readings.

    phase : driver angle from dead centre where the input reads zero [rad].
    offset : reading of the output where the follower angle is zero [rad].
    phase_error, offset_error : their standard errors if the errors of the samples are
        independent of each other [rad]. They are 0 if the zeros were given, and NaN if the
        output turns at a constant ratio, so that the readings do not determine the phase.
    sense : 1 if the readings of both encoders grow together, -1 if one grows while the other
        falls.
    theory : reading of the output that the mechanism should give, shape (n,) [rad].
    errors : measured less theory, shape (n,) [rad].
    slope : derivative of theory by input, shape (n,) [-].
    """

    phase: float
    offset: float
    phase_error: float
    offset_error: float
    sense: int
    theory: FloatArray
    errors: FloatArray
    slope: FloatArray


class _Task(NamedTuple):
    """The readings to be fitted. The input grows over the turns.

    Zeros are a sense, a phase and an offset, the latter two in rad. `wraps` says whether the
    output starts again at zero each turn.
    """

    mechanism: Mechanism
    input: FloatArray
    output: FloatArray
    wraps: bool

    def residual(self, sense: int, phase: float, offset: float) -> FloatArray:
        """Output less theory, to the nearest turn if the output starts again each turn."""
        rest = self.output - sense * position(self.mechanism, self.input + phase) - offset
        if self.wraps:
            rest -= TURN * np.round(rest / TURN)
        return rest

    def squares(self, zeros: Zeros) -> float:
        """Sum of the squared errors with these zeros."""
        return float(np.square(self.residual(*zeros)).sum())

    def improved(self, zeros: Zeros) -> Zeros:
        """Zeros nearby with the least sum of squares, by Levenberg and Marquardt's method.

        The offset follows from the phase, because it makes the mean error zero.
        """
        sense, start, offset = zeros

        def rest(at: FloatArray) -> FloatArray:
            return _centred(self.residual(sense, at[0], offset))

        def rate(at: FloatArray) -> FloatArray:
            return -sense * _centred(slope(self.mechanism, self.input + at[0]))[:, None]

        # if the output turns at a constant ratio, the rate is only rounding: the phase stays
        found = optimize.least_squares(rest, start, rate, method="lm", **_NEAR)
        phase = float(found.x[0])
        return sense, phase, offset + float(self.residual(sense, phase, offset).mean())

    def starts(self) -> Iterator[Zeros]:
        """For each sense the best phase on a grid over one cell.

        The residuals are points on a circle. The direction of their mean is the offset, and its
        length says how well they agree, whether the turns of the output are counted or not.
        """
        phases = np.arange(_START_PHASES) / _START_PHASES * self.mechanism.cell_angle
        angles = np.add.outer(phases, self.input)
        phi = position(self.mechanism, angles.reshape(-1)).reshape(angles.shape)
        for sense in (1, -1):
            turns = np.exp(1j * (self.output - sense * phi)).mean(axis=1)
            best = int(np.argmax(np.abs(turns)))
            yield sense, float(phases[best]), float(np.angle(turns[best]))


def fit_zeros(
    mechanism: Mechanism, angle: FloatArray, output: FloatArray,
    zeros: tuple[float, float] | None = None,
) -> Positions:  # fmt: skip
    """Fit the sense of the output, and phase and offset unless they are given.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    angle, output : ndarray, shape (n,)
        Readings [rad]; the input grows over the turns, and so does the output unless it stays
        within a turn.
    zeros : (float, float), optional
        Phase and offset if they are known [rad].
    """
    task = _Task(mechanism, angle, output, wraps(output))
    if zeros is None:
        some = spread_samples(angle.size, _START_SAMPLES)
        few = task._replace(input=angle[some], output=output[some])
        start = min(map(few.improved, few.starts()), key=few.squares)
        sense, phase, offset = task.improved(start)
        # the same zeros, with the phase within half a cell of zero
        cells = round(phase / mechanism.cell_angle)
        phase -= cells * mechanism.cell_angle
        offset += sense * cells * mechanism.follower_step
        offset -= TURN * round(offset / TURN) if task.wraps else 0.0
    else:
        sense, phase, offset = min([(1, *zeros), (-1, *zeros)], key=task.squares)
    errors = task.residual(sense, phase, offset)
    g = sense * slope(mechanism, angle + phase)
    of_phase, of_offset = (0.0, 0.0) if zeros is not None else _standard_errors(g, errors)
    return Positions(
        phase=phase, offset=offset, phase_error=of_phase, offset_error=of_offset, sense=sense,
        theory=output - errors, errors=errors, slope=g,
    )  # fmt: skip


def _standard_errors(g: FloatArray, errors: FloatArray) -> tuple[float, float]:
    """Standard errors of phase and offset, from the inverse of the normal equations."""
    varying = _centred(g)
    spread = float(varying @ varying)
    # the output turns at a constant ratio except for rounding: no phase can be found
    if spread <= 1e-12 * float(g @ g):
        return math.nan, math.nan
    variance = float(errors @ errors) / (g.size - 2)
    of_offset = 1.0 / g.size + float(g.mean()) ** 2 / spread
    return math.sqrt(variance / spread), math.sqrt(variance * of_offset)


def _centred(values: FloatArray) -> FloatArray:
    return np.asarray(values - values.mean())
