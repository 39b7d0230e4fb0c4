"""Position function of a mechanism over any number of cells, and its slope."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from escapement.mechanisms.slotted import transmission
from escapement.model import FloatArray, Mechanism

BLOCK = 1 << 17
"""Samples worked on at once, so that temporary arrays stay small."""


def blocks(count: int) -> Iterator[slice]:
    """Slices of `BLOCK` samples that cover `count`."""
    for start in range(0, count, BLOCK):
        yield slice(start, start + BLOCK)


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
        phi[part] = _within(mechanism, local) + cell * mechanism.follower_step
    return phi


def slope(mechanism: Mechanism, theta: FloatArray) -> FloatArray:
    """Transmission g = dphi/dtheta at driver angles over any number of cells [-].

    Zero in the dwell.
    """
    # not from the path where it can be helped: of a follower that turns back there is none
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


def _within(mechanism: Mechanism, local: FloatArray) -> FloatArray:
    """Follower angle within the cell; rounding may have left it by a hair."""
    entry, exit_ = mechanism.breaks[0], mechanism.breaks[-1]
    return np.asarray(mechanism.follower_angle(np.clip(local, entry, exit_)), dtype=float)
