"""The search for all errors that readings show: which of them are certain, and how large.

The candidates are errors that repeat with a shaft or a cell, errors of single slots and pins,
backlash, changes for good, and single readings far out. Over few turns some of them look similar.
The most significant one is therefore fitted first, with a phase and an offset, then the most
significant of the rest, and so on.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from escapement.measurement import error_columns, findings, normal_equations
from escapement.measurement.error_columns import Step
from escapement.measurement.estimate import SURE, correlation
from escapement.measurement.findings import DOUBT, ORDERS, Found, Key
from escapement.measurement.noise import noise_of, rounding_of
from escapement.measurement.normal_equations import Candidate, Fitted, Indices, NormalEquations
from escapement.measurement.positions import position, slope
from escapement.measurement.readings import TURN
from escapement.mechanisms.protocol import FloatArray, Mechanism

# the width of a backlash changes its column in the fit; it converges in so many fits. Before, the
# first fit allows one cause, the second two, ..: a great one must not be taken for several
_FITS = 5
_FITS_OF_CHANGES = 9  # a slip of the input may be large, and takes more of them
_CHANGES = 4  # so many changes are looked for
_SAME_WEIGHT = 1e-2  # weights that differ by a smaller share change no test
_SAME = 1e-9  # sums of squares that differ by a smaller share are equal
_LOG_SURE, _LOG_DOUBT = math.log(SURE), math.log(DOUBT)
_UNKNOWN = (math.nan, math.nan, math.nan)
CELLS = 2.0
"""So many cells tell errors of a shaft from others although it made less than a turn."""


def find_errors(
    mechanism: Mechanism, driver: FloatArray, sense: int, errors: FloatArray, line: np.ndarray,
    steps: tuple[float, float] = (0.0, 0.0),
) -> Found:  # fmt: skip
    """Find the causes of errors.

    An error counts as found if noise alone would cause one as great anywhere in less than one of a
    thousand sets of readings. Each error is tested together with those that were found.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    driver : ndarray, shape (n,)
        Driver angle as read, growing over the turns [rad].
    sense : int
        1 if the readings of both encoders grow together, -1 if one grows while the other falls.
    errors : ndarray, shape (n,)
        Measured less theory [rad].
    line : ndarray of int, shape (n,)
        Line of each sample in its file.
    steps : (float, float)
        Steps of the encoders of input and output, 0 if unknown [rad].

    Notes
    -----
    The problem is not linear: an error of the input changes the angle at which the transmission
    is read, and the width of a backlash changes where it is crossed. The method is Gauss-Newton,
    with weights where the noise is uneven.
    """
    search = _Search(mechanism, driver, sense, errors, steps)
    while True:
        search.fit()
        most = _FITS_OF_CHANGES if search.steps_found else _FITS
        if search.fits >= most or not search.moved():
            return search.found(line)


@dataclass
class _Certain:
    """What is certain in one fit.

    sums : with a column for each change.
    indices : columns of all that is certain.
    changes : the changes among them, by their columns.
    next_change : the most significant one of those that are not certain.
    rounded : errors that may be rounding.
    """

    sums: NormalEquations
    indices: list[Indices] = field(default_factory=list)
    changes: dict[Indices, Candidate] = field(default_factory=dict)
    next_change: Candidate | None = None
    rounded: set[Key] = field(default_factory=set)

    def sample(self, change: Candidate) -> int:
        """First sample behind a change."""
        return int(self.sums.edges[change.edge])


class _Search:
    """The state of the Gauss-Newton method.

    true : driver angle less the errors of the input that were found [rad].
    rest : errors linearised at `true` [rad].
    left : what the fit leaves of them [rad].
    """

    def __init__(
        self, mechanism: Mechanism, driver: FloatArray, sense: int, errors: FloatArray,
        steps: tuple[float, float],
    ) -> None:  # fmt: skip
        self.mechanism, self.driver, self.sense = mechanism, driver, sense
        self.errors, self.steps, self.fits = errors, steps, 0
        self.steps_found: list[Step] = []
        self.theory = sense * position(mechanism, driver)
        self._at(np.zeros_like(driver))
        self.rounding = rounding_of(driver, steps)
        self.backlash_widths, start = error_columns.first_widths(
            driver, self.follower, self.slope, errors
        )
        self.counted = np.arange(errors.size) >= start
        self.noise = noise_of(errors, self.slope, steps)
        self.scale = self.counted / self.noise.deviation(self.slope)
        cell, step = mechanism.cell_angle, abs(mechanism.follower_step)
        travels = np.ptp(driver) / TURN, np.ptp(self.follower) / TURN, np.ptp(driver) / cell
        self.turns = dict(zip(("input", "output", "cell"), map(float, travels), strict=True))
        # a shaft made a full turn if one mean step after the last sample completes it
        least = (1.0 - 1e-9) * (errors.size - 1) / errors.size
        self.enough = self.turns["cell"] >= CELLS * least
        self.judged = [n for n, turns in self.turns.items() if self.enough or turns >= least]
        self.limits = {"input": 0.5 * cell, "output": 0.5 * step, "cell": 0.5 * step}

    def _at(self, moved: FloatArray) -> None:
        """Linearise where the driver is ahead of its reading by `moved`."""
        self.true = self.driver + moved
        self.follower = self.sense * position(self.mechanism, self.true)
        self.slope = self.sense * slope(self.mechanism, self.true)
        self.rest = self.errors - (self.follower - self.theory) + self.slope * moved

    def fit(self) -> None:
        """Fit all that is certain, at the present point."""
        self.fits += 1
        cells = self.true * (TURN / self.mechanism.cell_angle)
        angles = {"input": self.true, "output": self.follower, "cell": cells}
        lags = {
            name: error_columns.lag(angles[name], width)
            for name, width in self.backlash_widths.items()
        }
        self.parts = error_columns.parts_met(self.mechanism, self.true) if self.enough else {}
        columns = error_columns.Columns(angles, self.slope, self.parts, lags, self.rest, self.scale)
        every = columns.indices().items()
        self.indices = {k: x for k, x in every if k[0] in self.judged or k[1] not in ORDERS}
        self.certain = certain = self._selected(columns.sums(self.steps_found))
        changes = certain.changes.values()
        self.steps_found = [Step(change.shaft, certain.sample(change)) for change in changes]
        self.coefficients = certain.sums.coefficients(certain.indices)
        self.caused = columns.caused(self.coefficients, self.steps_found)
        self.left = self.rest - self.caused["output"] - self.slope * self.caused["input"]
        for name in lags:
            size, error, _ = self._size((name, "lag"))
            width = max(abs(size), 3.0 * error)
            # a width that could not be fitted stays as it was
            if math.isfinite(width) and width > 0.0:
                self.backlash_widths[name] = width
        self._weigh()

    def moved(self) -> bool:
        """Go to the point that was found; whether there is any reason for another fit."""
        same = np.allclose(self.scale, self.next_scale, rtol=_SAME_WEIGHT, atol=0.0)
        # a cause of half a cell and more leads the method astray
        far = float(np.abs(self.caused["input"]).max()) > 0.5 * self.mechanism.cell_angle
        if far or (same and not self.certain.indices):
            return False
        self.scale = self.next_scale
        for index, indices in enumerate(self.certain.changes):
            size = float(self.coefficients[indices[0]])
            self.steps_found[index] = self._located(size, self.steps_found[index])
        self._at(self.caused["input"])
        return True

    def _located(self, size: float, step: Step) -> Step:
        """Move a slip to where the exact errors are least."""
        caused = self.caused[step.shaft]
        caused[step.sample :] -= size
        squares = []
        for shift in (0.0, size):
            caused += shift
            turned = self.sense * position(self.mechanism, self.driver + self.caused["input"])
            squares.append((self.errors - self.caused["output"] - turned + self.theory) ** 2)
            caused -= shift
        gain = np.cumsum(np.append(0.0, (squares[0] - squares[1]) * self.scale**2))
        # behind which sample it slipped in the dwell does not show
        same = np.flatnonzero(gain <= gain.min() + _SAME * np.ptp(gain))
        at = int(same[same.size // 2])
        caused[at:] += size
        return Step(step.shaft, at)

    def _weigh(self) -> None:
        """Find the readings that are far out, and weigh the others by their noise."""
        self.noise = noise_of(self.left, self.slope, self.steps)
        deviation = self.noise.deviation(self.slope)
        counted = np.flatnonzero(self.counted)
        # one count of each encoder is no reading far out
        count = self.steps[1] + self.steps[0] * np.abs(self.slope)
        far, chances = normal_equations.far_out((self.left / deviation)[counted], DOUBT)
        some = np.abs(self.left[counted[far]]) > count[counted[far]]
        far, chances = far[some], chances[some]
        self.glitches = dict(zip(counted[far].tolist(), chances.tolist(), strict=True))
        self.next_scale = self.counted / deviation
        self.next_scale[counted[far[chances < SURE]]] = 0.0

    def _selected(self, sums: NormalEquations) -> _Certain:
        """All that is certain, the most significant first, each tested with those before."""
        found = _Certain(sums)
        lags = {indices for (_, kind), indices in self.indices.items() if kind == "lag"}
        while True:
            found.rounded = set()
            trials = [*self._trials(found)]
            # a backlash that is certain comes before all others
            certain_lags = [one for one in trials if one[1] in lags and one[0] < _LOG_SURE]
            log_p, indices = min(certain_lags or trials, default=(0.0, ()))
            # where a shaft turns back once, a slip there looks like its backlash, until the width
            # of the latter has converged
            early = self.fits < _FITS and lags & {*found.indices}
            look = self.enough and indices not in lags and not early
            found.next_change = change = (
                normal_equations.best_change(found.sums, found.indices) if look else None
            )
            if change and self._may_be_rounding(change.shaft, change.fitted):
                if change.log_p < _LOG_DOUBT:
                    found.rounded.add(("change", found.sample(change)))
                change = None
            if self.fits < _FITS and len(found.indices) == self.fits:
                return found
            if change and change.log_p < min(log_p, _LOG_SURE):
                if len(found.changes) == _CHANGES:
                    return found
                indices = (len(found.sums.gram),)
                found.changes[indices] = change
                found.sums = found.sums.with_change(change.edge, change.column)
            elif log_p >= _LOG_SURE:
                return found
            found.indices.append(indices)

    def _trials(self, certain: _Certain) -> Iterator[tuple[float, Indices]]:
        """Each of the other errors that is no rounding: log p in the whole search, and columns."""
        waves = sum(kind != "parts" for _, kind in self.indices)
        for (name, kind), indices in self.indices.items():
            if indices in certain.indices:
                continue
            fitted = certain.sums.fitted(indices, certain.indices)
            if fitted is None:
                continue
            log_p, searched = fitted.log_p, math.log(waves)
            if kind == "parts":
                log_p, searched = error_columns.worst_part(fitted, self.parts[name])[-1], 0.0
            if not self._may_be_rounding(name, fitted):
                yield log_p + searched, indices
            elif log_p < _LOG_DOUBT:
                certain.rounded.add((name, kind))

    def _may_be_rounding(self, shaft: str, error: Fitted) -> bool:
        """Whether rounding alone may explain as large a sum of squares."""
        if not any(self.steps):
            return False
        # what this error explains is no noise
        left = error.variance * self.counted.sum()
        noise = self.noise.shrunk(left / (left + error.explained))
        return error.explained < self.rounding.explains(shaft, self.slope, self.scale, noise)

    def _fitted(self, key: Key) -> Fitted | None:
        """An error fitted together with all others that are certain."""
        indices = self.indices.get(key)
        return (indices and self.certain.sums.fitted(indices, self.certain.indices)) or None

    def _size(self, key: Key) -> tuple[float, float, float]:
        """Amplitude of a wave or width of a lag, its standard error, and its p-value.

        A size beyond its limit is none that a shaft can have: the fit does not determine it.
        """
        if (fitted := self._fitted(key)) is None:
            return _UNKNOWN
        values = fitted.values
        size = float(np.hypot(*values)) if values.size == 2 else float(values[0])
        along, p_value = values / size, math.exp(fitted.log_p)
        error = math.sqrt(float(along @ fitted.covariance @ along))
        known = abs(size) < self.limits[key[0]]
        return (size, error, p_value) if known else (*_UNKNOWN[:2], p_value)

    def found(self, line: np.ndarray) -> Found:
        """What was found at last."""
        weighted, kept = self.left * self.next_scale, self.next_scale > 0.0
        waves = [
            findings.ShaftError(name, order, *self._size((name, order)), turns)
            for name, turns in self.turns.items()
            for order in ORDERS
        ]
        far = sorted(self.glitches.items())
        rounded = {
            (name, int(line[int(kind) - 1])) if name == "change" else (name, kind)
            for name, kind in self.certain.rounded
        }
        hidden = self.rounding.explains("output", self.slope, self.scale, self.noise)
        return Found(
            shaft_errors=tuple(waves),
            backlash=tuple(
                findings.Backlash(name, *self._size((name, "lag"))) for name in self.backlash_widths
            ),
            slot_errors=tuple(self._worst_parts()),
            changes=tuple(self._changes(line)),
            glitches=tuple(
                findings.Glitch(int(line[at]), float(self.left[at]), p) for at, p in far
            ),
            rounded=frozenset(rounded),
            hidden=math.sqrt(2.0 * hidden / float(self.scale @ self.scale)),
            spread=float(self.errors[kept].std()),
            scatter=float(self.left[kept].std()),
            rest_autocorrelation=correlation(weighted),
        )

    def _worst_parts(self) -> Iterator[findings.SlotError]:
        """The worst slot and the worst pin, where several were seen."""
        for name, parts in self.parts.items():
            if (fitted := self._fitted((name, "parts"))) is not None:
                index, angle, error, log_p = error_columns.worst_part(fitted, parts)
                if abs(angle) >= self.limits[name]:
                    angle = error = math.nan
                yield findings.SlotError(name, index, parts.size, angle, error, math.exp(log_p))

    def _changes(self, line: np.ndarray) -> Iterator[findings.Change]:
        """Changes that are certain, and the next one if noise hardly causes it."""
        certain, found = self.certain, []
        for indices, change in certain.changes.items():
            if fitted := certain.sums.fitted(indices, certain.indices):
                found.append((change, fitted))
        if (last := certain.next_change) is not None and last.log_p < _LOG_DOUBT:
            found.append((last, last.fitted))
        for change, fitted in sorted(found, key=lambda one: certain.sample(one[0])):
            size, error = float(fitted.values[0]), math.sqrt(float(fitted.covariance[0, 0]))
            # a slip of a whole cell shows nothing, so a greater one is a fit that does not tell it
            told = (size, error) if abs(size) < 2.0 * self.limits[change.shaft] else _UNKNOWN[:2]
            before = int(line[certain.sample(change) - 1])
            yield findings.Change(change.shaft, before, *told, math.exp(change.log_p))
