"""The search for all errors that readings show: which of them are certain, and how large.

The candidates are errors that repeat with a shaft or a cell, errors of single slots and pins,
backlash, changes for good, and single readings far out. Over few turns some of them look similar.
The most significant one is therefore fitted first, with a phase and an offset, then the most
significant of the rest, and so on.
"""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from escapement.measurement.backlash import Backlash, first_widths, lag, next_width
from escapement.measurement.changes import Candidate, Change, best_change
from escapement.measurement.error_columns import Behind, Columns, Key
from escapement.measurement.fit import position, slope
from escapement.measurement.glitches import Glitch, far_out
from escapement.measurement.noise import Noise, first_noise, noise_of, rounding_of
from escapement.measurement.normal_equations import PHASE, Fitted, Indices, NormalEquations
from escapement.measurement.readings import TURN
from escapement.measurement.shaft_errors import DOUBT, ORDERS, SURE, UNKNOWN, ShaftError, sized
from escapement.measurement.slot_errors import SlotError, parts_met, worst_part
from escapement.mechanisms.protocol import FloatArray, Mechanism

# the width of a backlash changes its column in the fit; it converges in so many fits. Before, the
# first fit allows one cause, the second two, ..: a great one must not be taken for several
_FITS = 5
_FITS_OF_CHANGES = 9  # a slip of the input may be large, and takes more of them
_CHANGES = 4  # so many changes are looked for
_SUSPECTED = 0.1  # what noise causes more seldom may be no noise
_FAR = 3.0  # standard deviations of a reading that may be far out
_SAME_WEIGHT = 1e-2  # weights that differ by a smaller share change no test
_SAME = 1e-9  # sums of squares that differ by a smaller share are equal
CELLS = 2.0
"""So many cells tell errors of a shaft from others although it made less than a turn."""


class Found(NamedTuple):
    """Errors with a cause, and what they leave.

    shaft_errors : one for each shaft and order.
    backlash : one for each shaft that turns both ways far enough.
    slot_errors : of the worst slot and of the worst pin, where several were seen.
    changes : changes for good that noise hardly causes, by their line.
    glitches : readings far out, by their line.
    rounded : errors that noise cannot cause, but the rounding of the encoders can; a change by
        its line.
    hidden : amplitude of an error of the output that rounding can hide [rad].
    spread : standard deviation of the errors, without readings far out [rad].
    scatter : standard deviation of what is left, likewise [rad].
    correlation : correlation of neighbouring errors in what is left [-].
    """

    shaft_errors: tuple[ShaftError, ...]
    backlash: tuple[Backlash, ...]
    slot_errors: tuple[SlotError, ...]
    changes: tuple[Change, ...]
    glitches: tuple[Glitch, ...]
    rounded: frozenset[Key]
    hidden: float
    spread: float
    scatter: float
    correlation: float


def find_errors(
    mechanism: Mechanism,
    driver: FloatArray,
    sense: int,
    errors: FloatArray,
    line: np.ndarray,
    steps: tuple[float, float] = (0.0, 0.0),
) -> Found:
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
        most = _FITS_OF_CHANGES if search.changes else _FITS
        if search.applies_to >= most or not search.moved():
            return search.found(line)


@dataclass
class _Certain:
    """What is certain in one fit.

    indices : columns of all that is certain.
    changes : the changes among them, and where each of them acts, by the index of its column.
    next_change : the most significant one of those that are not certain.
    suspect : the most significant of all errors that are not certain, if noise seldom causes it.
    rounded : errors that may be rounding.
    """

    sums: NormalEquations
    indices: list[Indices] = field(default_factory=list)
    changes: dict[Indices, tuple[Candidate, Behind]] = field(default_factory=dict)
    next_change: Candidate | None = None
    suspect: Indices | Candidate | None = None
    rounded: set[Key] = field(default_factory=set)


class _Search:
    """The state of the Gauss-Newton method.

    true : driver angle less the errors of the input that were found [rad].
    rest : errors linearised at `true` [rad].
    """

    def __init__(
        self, mechanism: Mechanism, driver: FloatArray, sense: int, errors: FloatArray,
        steps: tuple[float, float],
    ) -> None:  # fmt: skip
        self.mechanism, self.driver, self.sense = mechanism, driver, sense
        self.errors, self.steps = errors, steps
        self.theory = sense * position(mechanism, driver)
        self.changes: list[Behind] = []
        self.applies_to = 0
        self._at(np.zeros_like(driver))
        self.rounding = rounding_of(driver, steps)
        self.backlash_widths, start = first_widths(driver, self.follower, self.slope, errors)
        self.counted = np.arange(errors.size) >= start
        self.noise = first_noise(errors, self.slope, steps)
        self.scale = self.counted / self.noise.deviation(self.slope)
        cells = float(np.ptp(driver)) / mechanism.cell_angle
        self.turns = {
            "input": float(np.ptp(driver)) / TURN,
            "output": float(np.ptp(self.follower)) / TURN,
            "cell": cells,
        }
        # a shaft made a full turn if one mean step after the last sample completes it
        least = (1.0 - 1e-9) * (errors.size - 1) / errors.size
        self.enough = cells >= CELLS * least
        self.judged = [n for n, turns in self.turns.items() if self.enough or turns >= least]
        step = abs(mechanism.follower_step)
        self.limits = {
            "input": 0.5 * mechanism.cell_angle,
            "output": 0.5 * step,
            "cell": 0.5 * step,
        }

    def _at(self, moved: FloatArray) -> None:
        """Linearise where the driver is ahead of its reading by `moved`."""
        self.true = self.driver + moved
        self.follower = self.sense * position(self.mechanism, self.true)
        self.slope = self.sense * slope(self.mechanism, self.true)
        self.rest = self.errors - (self.follower - self.theory) + self.slope * moved

    def fit(self) -> None:
        """Fit all that is certain, at the present point."""
        self.applies_to += 1
        cell = self.mechanism.cell_angle
        angles = {"input": self.true, "output": self.follower, "cell": self.true * (TURN / cell)}
        lags = {name: lag(angles[name], width) for name, width in self.backlash_widths.items()}
        parts = parts_met(self.mechanism, self.true) if self.enough else {}
        self.columns = Columns(angles, self.slope, parts, lags, self.rest, self.scale)
        self.indices = {
            key: indices
            for key, indices in self.columns.indices().items()
            if key[0] in self.judged or key[1] not in ORDERS
        }
        sums = self.columns.sums([change.sample for change in self.changes])
        self.certain = self._ranked(sums)
        self.changes = [behind for _, behind in self.certain.changes.values()]
        found = self.coefficients = self.certain.sums.coefficients(self.certain.indices)
        self.input_error = self.columns.input_error(found, self.changes)
        self.left = self.columns.rest(found, self.changes)
        for (name, kind), indices in self.indices.items():
            if kind == "lag":
                self.backlash_widths[name] = next_width(
                    self._size(name, indices), self.backlash_widths[name]
                )

        self._weigh()

    def moved(self) -> bool:
        """Go to the point that was found; whether there is any reason for another fit."""
        same = np.allclose(self.scale, self.next_scale, rtol=_SAME_WEIGHT, atol=0.0)
        # a cause of half a cell and more leads the method astray
        far = float(np.abs(self.input_error).max()) > 0.5 * self.mechanism.cell_angle
        if far or (same and not self.certain.indices):
            return False
        self.scale = self.next_scale
        for indices, (_, behind) in self.certain.changes.items():
            if behind.column == PHASE:
                self._locate(float(self.coefficients[indices[0]]), behind.sample)
        self._at(self.input_error)
        return True

    def _locate(self, size: float, sample: int) -> None:
        """Move a slip of the input to where the exact errors are least."""
        without = self.input_error.copy()
        without[sample:] -= size
        # what the output itself has
        beside = self.rest - self.left - self.slope * self.input_error - self.theory
        before, behind = (
            (self.errors - beside - self.sense * position(self.mechanism, self.driver + shift)) ** 2
            for shift in (without, without + size)
        )
        gain = np.cumsum(np.append(0.0, (before - behind) * self.scale**2))
        # behind which sample it slipped in the dwell does not show
        same = np.flatnonzero(gain <= gain.min() + _SAME * np.ptp(gain))
        at = int(same[same.size // 2])
        self.input_error = without
        self.input_error[at:] += size

    def _weigh(self) -> None:
        """Find the readings that are far out, and weigh the others by their noise."""
        self.noise = self._noise()
        deviation = self.noise.deviation(self.slope)
        counted = np.flatnonzero(self.counted)
        # one count of each encoder is no reading far out
        count = self.steps[1] + self.steps[0] * np.abs(self.slope)
        far, chances = far_out((self.left / deviation)[counted], DOUBT)
        some = np.abs(self.left[counted[far]]) > count[counted[far]]
        far, chances = far[some], chances[some]
        self.glitches = dict(zip(counted[far].tolist(), chances.tolist(), strict=True))
        self.next_scale = self.counted / deviation
        self.next_scale[counted[far[chances < SURE]]] = 0.0

    def _noise(self) -> Noise:
        """The noise of the readings, if what is suspected is no noise.

        An error of the input that is not removed would look like noise of the input, and a reading
        far out like noise where it lies: both would hide themselves.
        """
        certain, left = self.certain, self.left
        sums, indices, changes = certain.sums, certain.indices, self.changes
        if isinstance(certain.suspect, Candidate):
            edge, column = certain.suspect.edge, certain.suspect.column
            indices = [*indices, (len(sums.gram),)]
            changes = [*changes, Behind(int(sums.edges[edge]), column)]
            sums = sums.with_column_behind(edge, column)
        elif certain.suspect is not None:
            indices = [*indices, certain.suspect]
        if certain.suspect is not None:
            left = self.columns.rest(sums.coefficients(indices), changes)
        inside = np.flatnonzero(self.scale > 0.0)
        left, slope = left[inside], self.slope[inside]
        noise = noise_of(left, slope, self.steps)
        near = left**2 <= _FAR**2 * (noise.of_output + noise.of_input * slope**2)
        return noise_of(left[near], slope[near], self.steps)

    def _ranked(self, sums: NormalEquations) -> _Certain:
        """All that is certain, the most significant first, each tested with those before."""
        found = _Certain(sums)
        lags = {indices for (_, kind), indices in self.indices.items() if kind == "lag"}
        while True:
            found.rounded = set()
            log_p, indices, is_backlash = self._most_significant(found)
            # where a shaft turns back once, a slip there looks like its backlash, until the width
            # of the latter has converged
            early = self.applies_to < _FITS and lags & {*found.indices}
            look = self.enough and not is_backlash and not early
            found.next_change = change = best_change(found.sums, found.indices) if look else None
            if change and self._may_be_rounding(change.shaft, change):
                if change.log_p < math.log(DOUBT):
                    found.rounded.add(("change", int(found.sums.edges[change.edge])))
                change = None
            shift = change is not None and change.log_p < log_p
            seldom = min(log_p, change.log_p if change else 0.0) < math.log(_SUSPECTED)
            found.suspect = (change if shift else indices) if seldom else None
            if self.applies_to < _FITS and len(found.indices) == self.applies_to:
                return found
            if shift and change and change.log_p < math.log(SURE):
                if len(found.changes) == _CHANGES:
                    return found
                indices = (len(found.sums.gram),)
                behind = Behind(int(found.sums.edges[change.edge]), change.column)
                found.changes[indices] = change, behind
                found.sums = found.sums.with_column_behind(change.edge, change.column)
            elif log_p >= math.log(SURE):
                return found
            found.indices.append(indices)

    def _most_significant(self, certain: _Certain) -> tuple[float, Indices, bool]:
        """The most significant of the other errors: log p, columns, and whether it is a backlash.

        A backlash that is certain comes before all others.
        """
        trials = []
        waves = sum(kind != "parts" for _, kind in self.indices)
        for (name, kind), indices in self.indices.items():
            fitted = (
                None
                if indices in certain.indices
                else certain.sums.fitted(indices, certain.indices)
            )
            if fitted is None:
                continue
            log_p, searched = fitted.log_p, math.log(waves)
            if kind == "parts":
                log_p, searched = worst_part(fitted, self.columns.parts[name])[-1], 0.0
            if self._may_be_rounding(name, fitted):
                certain.rounded |= {(name, kind)} if log_p < math.log(DOUBT) else set()
            else:
                trials.append((log_p + searched, indices, kind == "lag"))
        lags = [trial for trial in trials if trial[2] and trial[0] < math.log(SURE)]
        return min(lags or trials, default=(0.0, (), False))

    def _may_be_rounding(self, shaft: str, error: Fitted | Candidate) -> bool:
        """Whether rounding alone may explain as large a sum of squares."""
        if not any(self.steps):
            return False
        # what this error explains is no noise
        left = error.variance * self.counted.sum()
        noise = self.noise.shrunk(left / (left + error.explained))
        return error.explained < self.rounding.explains(shaft, self.slope, self.scale, noise)

    def _fitted(self, indices: Indices) -> Fitted | None:
        """An error fitted together with all others that are certain."""
        return self.certain.sums.fitted(
            indices, [it for it in self.certain.indices if it != indices]
        )

    def _size(self, name: str, indices: Indices) -> tuple[float, float, float]:
        """Size, standard error and p-value of a wave or a lag."""
        fitted = self._fitted(indices)
        return UNKNOWN if fitted is None else sized(fitted, self.limits[name])

    def found(self, line: np.ndarray) -> Found:
        """What was found at last."""
        shaft_errors, backlash, slots = [], [], []
        for name, turns in self.turns.items():
            for order in ORDERS:
                indices = self.indices.get((name, order))
                size = UNKNOWN if indices is None else self._size(name, indices)
                shaft_errors.append(ShaftError(name, order, *size, turns))
        for (name, kind), indices in self.indices.items():
            if kind == "lag":
                backlash.append(Backlash(name, *self._size(name, indices)))
            fitted = self._fitted(indices) if kind == "parts" else None
            if fitted is not None:
                parts = self.columns.parts[name]
                index, angle, error, log_p = worst_part(fitted, parts)
                if abs(angle) >= self.limits[name]:
                    angle = error = math.nan
                slots.append(SlotError(name, index, parts.size, angle, error, math.exp(log_p)))
        weighted = self.left * self.next_scale
        square = float(weighted @ weighted)
        alike = float(weighted[1:] @ weighted[:-1]) / square if square > 0.0 else 0.0
        kept = self.next_scale > 0.0
        rounded = {
            (name, int(line[int(kind) - 1])) if name == "change" else (name, kind)
            for name, kind in self.certain.rounded
        }
        hidden = self.rounding.explains("output", self.slope, self.scale, self.noise)
        glitches = sorted(self.glitches.items())
        return Found(
            shaft_errors=tuple(shaft_errors),
            backlash=tuple(backlash),
            slot_errors=tuple(slots),
            changes=self._changes(line),
            glitches=tuple(Glitch(int(line[at]), float(self.left[at]), p) for at, p in glitches),
            rounded=frozenset(rounded),
            hidden=math.sqrt(2.0 * hidden / float(self.scale @ self.scale)),
            spread=float(self.errors[kept].std()),
            scatter=float(self.left[kept].std()),
            correlation=alike,
        )

    def _changes(self, line: np.ndarray) -> tuple[Change, ...]:
        """Changes that are certain, and the next one if noise hardly causes it."""
        certain, found = self.certain, []
        for indices, (change, behind) in certain.changes.items():
            if (fitted := self._fitted(indices)) is not None:
                size, error = float(fitted.values[0]), math.sqrt(float(fitted.covariance[0, 0]))
                found.append((behind.sample, change.shaft, size, error, change.log_p))
        if (last := certain.next_change) is not None and last.log_p < math.log(DOUBT):
            sample = int(certain.sums.edges[last.edge])
            found.append((sample, last.shaft, last.size, last.standard_error, last.log_p))
        limits = {"input": self.mechanism.cell_angle, "output": abs(self.mechanism.follower_step)}
        # a slip of a whole cell shows nothing, so a greater one is a fit that does not tell it
        return tuple(
            Change(
                shaft, int(line[sample - 1]),
                *((size, error) if abs(size) < limits[shaft] else UNKNOWN[:2]), math.exp(log_p),
            )
            for sample, shaft, size, error, log_p in sorted(found)
        )  # fmt: skip
