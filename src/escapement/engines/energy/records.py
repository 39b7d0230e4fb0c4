"""Records with named fields: what the kernels keep in arrays."""

from typing import Any

import numpy as np

from escapement.engines.energy.gauss import N
from escapement.jit import inner_jit
from escapement.mechanisms.slotted import transmission_at

NUMBER, WHOLE, TRUTH = np.float64, np.int64, np.bool_
ROW = (NUMBER, (N,))
"""Values at the Gauss points."""


def record(fields: dict[str, Any]) -> np.dtype:
    """Type of a record whose fields are attributes, in kernels and where nothing is compiled.

    Parameters
    ----------
    fields : dict
        Name of each field and its type: a number, a row or another record.
    """
    plain = np.dtype(
        [(name, *kind) if kind is ROW else (name, kind) for name, kind in fields.items()],
        align=True,
    )
    return np.dtype((np.record, plain))


END = record({"g": NUMBER, "u": NUMBER, "dg": NUMBER})
"""g, |u| and g' at one driver angle."""


@inner_jit
def put_end(end, path, theta):
    """Fill an `END` with the transmission at a driver angle."""
    g, u, dg = transmission_at(path, theta)
    end.g, end.u, end.dg = g, abs(u), dg


@inner_jit
def copy_end(end, other):
    """Fill an `END` with another."""
    end.g, end.u, end.dg = other.g, other.u, other.dg


@inner_jit
def copy_row(row, other, count):
    """Fill a row with another; `count` is that of `panels.points_of`."""
    for i in range(count & N):
        row[i] = other[i]
