"""The columns of the search for errors: what each cause does to the errors at each sample."""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from escapement.measurement.normal_equations import PHASE, Indices, NormalEquations
from escapement.measurement.readings import blocks
from escapement.measurement.shaft_errors import ORDERS
from escapement.measurement.slot_errors import Parts
from escapement.mechanisms.protocol import FloatArray

_EDGES = 2000  # a change is looked for behind as many samples
_NUMBERS = 4e6  # but their sums of products need no more doubles than this
_NEAR = 100  # samples to either side of a change that are looked at again, one by one


Key = tuple[str, int | str]
"""An error that is looked for: its shaft, and its order, "parts", "lag" or "change"."""


class Behind(NamedTuple):
    """A column that repeats another one behind a sample.

    sample : the first one at which it acts.
    column : the other column, of the phase or of the offset.
    """

    sample: int
    column: int


class Columns(NamedTuple):
    """Errors, offset, phase, two columns for each wave, and those of parts and of lags.

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

    def indices(self) -> dict[Key, Indices]:
        """The columns of each error, by its shaft and its order, "parts" or "lag"."""
        found: dict[Key, Indices] = {}
        end = PHASE + 1
        sizes: list[tuple[str, int | str, int]] = [(n, m, 2) for n in self.angles for m in ORDERS]
        sizes += [(name, "parts", parts.size - 1) for name, parts in self.parts.items()]
        sizes += [(name, "lag", 1) for name in self.lags]
        for name, kind, size in sizes:
            found[name, kind] = tuple(range(end, end + size))
            end += size
        return found

    def acting(self, part: slice) -> Iterator[tuple[str, FloatArray]]:
        """Each column from the phase on at some samples, and the shaft on which it acts."""
        yield "input", np.ones_like(self.errors[part])
        for name, angle in self.angles.items():
            for order in ORDERS:
                wave = np.exp(1j * order * angle[part])
                yield from ((name, wave.real), (name, wave.imag))
        for name, parts in self.parts.items():
            yield from ((name, column) for column in parts.columns(part))
        for name, share in self.lags.items():
            yield name, share[part]

    def table(self, part: slice) -> FloatArray:
        """All columns at some samples, shape (p, m), as they show in the output."""
        rate = self.slope[part]
        # an error of the input reaches the output through the transmission
        acting = [column * (rate if name == "input" else 1.0) for name, column in self.acting(part)]
        return np.array([self.errors[part], np.ones_like(rate), *acting])

    def sums(self, near: list[int]) -> NormalEquations:
        """Normal equations over all samples, with edges also at every sample near some of them."""
        size = len(self.table(slice(0, 1)))
        edges = _edges(self.errors.size, int(min(_EDGES, _NUMBERS / size**2)), near)
        if edges.size == self.errors.size:
            rows = (self.table(slice(None)) * self.scale).T
            each = rows[:, :, None] * rows[:, None, :]
        else:
            each = np.zeros((edges.size, size, size))
            for part in blocks(self.errors.size):
                rows = self.table(part) * self.scale[part]
                # the segments between edges that this block touches, and where they begin in it
                first = int(np.searchsorted(edges, part.start, "right")) - 1
                starts = np.maximum(edges[first:] - part.start, 0)
                starts = starts[starts < rows.shape[1]].tolist()
                for i, (low, high) in enumerate(pairwise([*starts, rows.shape[1]])):
                    some = rows[:, low:high]
                    each[first + i] += some @ some.T
        behind = np.cumsum(each[::-1], axis=0)[::-1]
        return NormalEquations(behind, edges, int(np.count_nonzero(self.scale)))

    def rest(self, coefficients: FloatArray, changes: list[Behind]) -> FloatArray:
        """What the fit leaves of the errors, shape (n,) [rad]."""
        left = np.empty_like(self.errors)
        for part in blocks(left.size):
            table = self.table(part)
            factors = np.concatenate([[-1.0], coefficients[1 : len(table)]])
            left[part] = -(factors @ table)
        for value, change in zip(
            coefficients[len(coefficients) - len(changes) :], changes, strict=True
        ):
            after = slice(change.sample, None)
            left[after] -= value * (self.slope[after] if change.column == PHASE else 1.0)
        return left

    def input_error(self, coefficients: FloatArray, changes: list[Behind]) -> FloatArray:
        """By how much the driver is ahead of its reading, shape (n,) [rad]."""
        found = np.empty_like(self.errors)
        for part in blocks(found.size):
            named = zip(coefficients[PHASE:], self.acting(part), strict=False)
            found[part] = sum(value * column for value, (name, column) in named if name == "input")
        for value, change in zip(
            coefficients[len(coefficients) - len(changes) :], changes, strict=True
        ):
            if change.column == PHASE:
                found[change.sample :] += value
        return found


def _edges(samples: int, most: int, near: list[int]) -> np.ndarray:
    """Samples behind which a change is looked for; the first one is 0."""
    if samples <= most:
        return np.arange(samples)
    even = np.linspace(0, samples, most, endpoint=False).astype(int)
    gap = samples // most + 1
    fine = [at + np.linspace(-gap, gap, 2 * _NEAR + 1).astype(int) for at in near]
    edges = np.unique(np.concatenate([even, *fine]))
    return edges[(edges >= 0) & (edges < samples)]
