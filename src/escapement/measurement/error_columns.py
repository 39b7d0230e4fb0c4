"""The columns of the search for errors: what each cause does to the errors at each sample."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from escapement.measurement.findings import ORDERS, Key
from escapement.measurement.normal_equations import PHASE, Indices, NormalEquations
from escapement.measurement.readings import blocks
from escapement.measurement.slot_errors import Parts
from escapement.mechanisms.protocol import FloatArray

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
