"""Types of the records with named fields that kernels keep in arrays, and of their parts."""

from typing import Any

import numpy as np

from escapement.engines.energy.gauss import N
from escapement.jit import inner_jit
from escapement.mechanisms.slotted import transmission_at

NUMBER, WHOLE, FLAG = np.float64, np.int64, np.bool_
ROW = (NUMBER, (N,))
"""Type of a row: the values at the Gauss points."""


def record_dtype(fields: dict[str, Any]) -> np.dtype:
    """Type of a record whose fields are attributes, both in kernels and in plain Python.

    Parameters
    ----------
    fields : dict
        Name of each field and its type: a number, a row or another record.
    """
    # numbers lie at multiples of eight bytes, which a flag before them would otherwise prevent
    plain = np.dtype(
        [(name, *kind) if kind is ROW else (name, kind) for name, kind in fields.items()],
        align=True,
    )
    return np.dtype((np.record, plain))


END = record_dtype({"g": NUMBER, "u": NUMBER, "dg": NUMBER})
"""g, |u| and g' at one driver angle."""


@inner_jit
def fill_end(end, path, theta):
    """Fill an `END` with g, |u| and g' at a driver angle."""
    g, u, dg = transmission_at(path, theta)
    end.g, end.u, end.dg = g, abs(u), dg


@inner_jit
def copy_end(end, other):
    """Copy the `END` named `other`."""
    end.g, end.u, end.dg = other.g, other.u, other.dg


@inner_jit
def copy_row(row, other, count):
    """Copy the row named `other`; `count` is what `panels.points_of` gives."""
    # assigning to a slice would take longer to compile, because of its error messages
    for i in range(count & N):
        row[i] = other[i]
