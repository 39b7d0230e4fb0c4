"""The columns of the search for errors: what each cause does to the errors at each sample.

A slot whose angle is wrong moves the follower while a pin is in it, and in the dwell behind it. A
pin whose angle is wrong acts as an error of the input. Each part is compared with the mean of the
others.

A shaft with a free play w is pushed at either end of it and stays in between: it lags by w/2
behind what drives it, in either sense, and crosses over after each reversal.
"""

import math
from collections.abc import Iterator
from fractions import Fraction
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from escapement.base.lazy import Lazy
from escapement.measurement.findings import ORDERS, Key
from escapement.measurement.normal_equations import PHASE, Fitted, Indices, NormalEquations, log_of
from escapement.measurement.readings import TURN, blocks
from escapement.mechanisms.protocol import FloatArray, Mechanism

special = Lazy("scipy.special")
_ENGAGED = 10  # the width is fitted if so many samples are at either end of the backlash
_ROOM = (
    0.1  # the first estimate is at most this share of the travel, so that the backlash is crossed
)
_WIDE = 4.0  # a backlash is narrower than this many standard deviations of errors that it causes


def with_backlash(angle: FloatArray, width: float) -> FloatArray:
    """Angle of a shaft that is driven through a free play, beginning in its middle [rad]."""
    half_width = 0.5 * width
    followed = accumulate(
        angle.tolist(), lambda at, end: min(max(at, end - half_width), end + half_width)
    )
    return np.array([*followed])


def lag(angle: FloatArray, width: float) -> FloatArray:
    """By how much a shaft leads, as a share of its free play, -1/2 to 1/2, shape (n,) [-]."""
    return np.asarray((with_backlash(angle, width) - angle) / width)


def first_engaged(share: FloatArray) -> int | None:
    """First sample at which a shaft is at an end of its backlash; before it the side is unknown.

    None if there are too few samples at both ends to fit the width.
    """
    ends = share > 0.499, share < -0.499
    if min(map(np.count_nonzero, ends)) < _ENGAGED:
        return None
    return int(min(map(np.argmax, ends)))


def first_widths(
    driver: FloatArray, follower: FloatArray, slope: FloatArray, errors: FloatArray
) -> tuple[dict[str, float], int]:
    """For each shaft that turns both ways, a first estimate of its backlash, rather too wide [rad].

    Also returned is the first sample at which the side of each backlash is known.
    """
    found, start = {}, 0
    through = math.sqrt(float(np.mean(slope**2)))
    for name, angle, rate in (("input", driver, through), ("output", follower, 1.0)):
        width = _ROOM * float(np.ptp(angle))
        width = min(_WIDE * float(errors.std()) / rate, width) if rate > 0.0 else width
        first = first_engaged(lag(angle, width)) if width > 0.0 else None
        if first is not None:
            found[name], start = width, max(start, first)
    return found, start


_MOST = 64  # parts of a shaft


class Parts(NamedTuple):
    """Which part of a shaft is engaged at each sample: 0, 1, .. below `size`.

    engaged : which part, shape (n,).
    numbers : number of each part, counted from that of the first sample on, shape (size,).
    """

    engaged: np.ndarray
    numbers: np.ndarray

    @property
    def size(self) -> int:
        """How many parts were seen."""
        return len(self.numbers)

    def columns(self, part: slice) -> Iterator[FloatArray]:
        """Columns whose coefficients are errors that add up to zero; the last one follows."""
        index = self.engaged[part]
        last = (index == self.size - 1).astype(float)
        for number in range(self.size - 1):
            yield (index == number) - last


def parts_met(mechanism: Mechanism, driver: FloatArray) -> dict[str, Parts]:
    """The pins and slots of a mechanism that has several, by their shaft."""
    cells = np.floor((driver - mechanism.breaks[0]) / mechanism.cell_angle).astype(int)
    angles = {"input": mechanism.cell_angle, "output": abs(mechanism.follower_step)}
    found = {}
    for shaft, angle in angles.items():
        share = Fraction(angle / TURN).limit_denominator(_MOST)
        if share.numerator != 1 or abs(float(share) * TURN - angle) > 1e-9:
            continue
        since = np.mod(cells - cells[0], share.denominator)
        numbers, index = np.unique(since, return_inverse=True)
        if numbers.size > 1:
            found[shaft] = Parts(index, numbers + 1)
    return found


def worst_part(fitted: Fitted, parts: Parts) -> tuple[int, float, float, float]:
    """Number of the worst part, its size and standard error, and the logarithm of its p-value."""
    count = parts.size
    # each part less the mean of the others, from errors that add up to zero
    contrasts = np.vstack([np.eye(count - 1), -np.ones(count - 1)]) * (count / (count - 1))
    sizes = contrasts @ fitted.values
    errors = np.sqrt(np.einsum("ij,jk,ik->i", contrasts, fitted.covariance, contrasts))
    worst = int(np.argmax(np.abs(sizes) / errors))
    height = abs(sizes[worst]) / errors[worst]
    # two parts differ from each other by the same
    tried = count if count > 2 else 1
    p_value = min(1.0, 2.0 * tried * float(special.stdtr(fitted.freedom, -height)))
    alone = fitted._replace(explained=height**2 * fitted.variance)
    return (
        int(parts.numbers[worst]),
        float(sizes[worst]),
        float(errors[worst]),
        log_of(p_value, alone),
    )


_EDGES = 10_000  # a change is looked for behind as many samples


class Step(NamedTuple):
    """A shaft that has slipped for good, and the first sample behind it."""

    shaft: str
    sample: int


class Columns(NamedTuple):
    """All causes that are looked for, and what they have to explain.

    angles : of input, output and cell, each of shape (n,) [rad].
    slope : transmission, shape (n,) [-].
    parts : which pin or slot is engaged, by shaft.
    lags : of the shafts with backlash, shape (n,) [-].
    errors : measured less theory, shape (n,) [rad].
    scale : root of the weight of each sample, 0 for those left out, shape (n,) [-].
    """

    angles: dict[str, FloatArray]
    slope: FloatArray
    parts: dict[str, Parts]
    lags: dict[str, FloatArray]
    errors: FloatArray
    scale: FloatArray

    def declared(self, part: slice, steps: list[Step]) -> Iterator[tuple[Key, FloatArray]]:
        """Each column at some samples as an error of its shaft, with its cause."""
        index = np.arange(self.errors.size)[part]
        yield ("output", "offset"), np.ones(index.size)
        yield ("input", "phase"), np.ones(index.size)
        for name, angle in self.angles.items():
            for order in ORDERS:
                wave = np.exp(1j * order * angle[part])
                yield (name, order), wave.real
                yield (name, order), wave.imag
        for name, parts in self.parts.items():
            yield from (((name, "parts"), column) for column in parts.columns(part))
        for name, share in self.lags.items():
            yield (name, "lag"), share[part]
        for step in steps:
            yield (step.shaft, "change"), (index >= step.sample).astype(float)

    def indices(self) -> dict[Key, Indices]:
        """The columns of each error that is looked for; errors, offset and phase come before."""
        found: dict[Key, Indices] = {}
        for index, (key, _) in enumerate(self.declared(slice(0, 1), []), 1):
            if index > PHASE:
                found[key] = (*found.get(key, ()), index)
        return found

    def sums(self, near: list[Step]) -> NormalEquations:
        """Normal equations over all samples, with edges also at the steps found before."""
        count = self.errors.size
        even = np.linspace(0, count, min(_EDGES, count), endpoint=False).astype(int)
        edges = np.union1d(even, [step.sample for step in near]).astype(int)
        size = 1 + sum(1 for _ in self.declared(slice(0, 1), []))
        gram, each = np.zeros((size, size)), np.zeros((edges.size, 2, size))
        for part in blocks(count):
            rate = self.slope[part]
            # an error of the input reaches the output through the transmission
            rows = [
                column * rate if shaft == "input" else column
                for (shaft, _), column in self.declared(part, [])
            ]
            table = np.array([self.errors[part], *rows]) * self.scale[part]
            gram += table @ table.T
            # the segments between edges that this block touches, and where they begin in it
            first = int(np.searchsorted(edges, part.start, "right")) - 1
            last = int(np.searchsorted(edges, part.start + rate.size))
            starts = np.maximum(edges[first:last] - part.start, 0)
            for row in (0, 1):
                each[first:last, row] += np.add.reduceat(table[1 + row] * table, starts, axis=1).T
        behind = np.cumsum(each[::-1], axis=0)[::-1]
        return NormalEquations(gram, behind, edges, int(np.count_nonzero(self.scale)))

    def caused(self, coefficients: FloatArray, steps: list[Step]) -> dict[str, FloatArray]:
        """Error of input and of output that the fit explains, each of shape (n,) [rad]."""
        found = {shaft: np.zeros_like(self.errors) for shaft in ("input", "output")}
        for part in blocks(self.errors.size):
            named = zip(coefficients[1:].tolist(), self.declared(part, steps), strict=True)
            for value, ((shaft, _), column) in named:
                if value:
                    found["input" if shaft == "input" else "output"][part] += value * column
        return found
