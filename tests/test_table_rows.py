"""Which rows a table may have: both ends of the cell, repeated angles, a follower reversing."""

import math

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue

TURN = 2.0 * math.pi
ANGLES = np.linspace(0.0, TURN, 400)
CELL = {"cell_angle": TURN, "follower_step": TURN}


def wavy(theta):
    return theta + 0.3 * np.sin(theta)


def error(table):
    """Greatest error of g of a table of `wavy`."""
    return np.abs(table.transmission(ANGLES).g - 1.0 - 0.3 * np.cos(ANGLES)).max()


# --- both ends of the cell ----------------------------------------------------------------


@pytest.mark.parametrize("rows", [13, 61])
def test_both_ends_of_the_cell_may_be_given_with_its_angle(rows):
    """They miss the cell by rounding; the table is that without the options."""
    for start in (2, 107, *range(-360, 361, 93)):
        theta = np.radians(np.linspace(start, start + 360, rows))
        alone, told = esc.Tabulated(theta, wavy(theta)), esc.Tabulated(theta, wavy(theta), **CELL)
        np.testing.assert_allclose(
            told.transmission(ANGLES).g, alone.transmission(ANGLES).g, rtol=0.0, atol=1e-10
        )
        np.testing.assert_allclose(told.breaks, alone.breaks, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("off", [0.0, 1e-15, -1e-15, 1e-10, -1e-10])
def test_an_exact_table_has_one_row_an_angle(off):
    """Angles that differ by rounding are the same, in one cell or in two."""
    theta = np.linspace(0.0, TURN, 40, endpoint=False)
    for again in (theta[7] + off, theta[7] + off + TURN, theta[7] + off - 3.0 * TURN):
        rows = np.append(theta, again)
        with pytest.raises(InvalidValue, match="theta must differ from row to row"):
            _ = esc.Tabulated(rows, wavy(rows), **CELL).spline


# --- repeated angles ----------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_readings_on_one_grid_of_angles_over_several_turns(seed):
    """Turns or none, the same readings make the same table."""
    random = np.random.default_rng(seed)
    grid = np.radians(np.linspace(0.0, 360.0, int(random.integers(60, 140)), endpoint=False))
    theta, turns = np.tile(grid, 4), np.repeat(np.arange(4), grid.size)
    phi = wavy(theta) + 0.002 * random.standard_normal(theta.size)
    one = esc.Tabulated(theta, phi, measured=True, **CELL)
    far = esc.Tabulated(theta + TURN * turns, phi + TURN * turns, measured=True, **CELL)
    found, truth = far.transmission(ANGLES), one.transmission(ANGLES)
    np.testing.assert_allclose(found.g, truth.g, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(found.dg, truth.dg, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(
        far.deviation(ANGLES).g, one.deviation(ANGLES).g, rtol=1e-6, atol=1e-9
    )
    assert error(far) < 0.02


@pytest.mark.parametrize("places", [1, 2, 4])
def test_readings_at_a_few_places_make_no_table(places):
    theta = np.repeat(np.arange(places) / places * TURN, 12)
    with pytest.raises(InvalidValue, match=f"theta must be spread .* got rows at {places} places"):
        _ = esc.Tabulated(theta, wavy(theta), measured=True, **CELL).spline


# --- the sense ----------------------------------------------------------------------------


@pytest.mark.parametrize("sense", [-1.0, 1.0])
@pytest.mark.parametrize("swing", [0.0, 0.6])
@pytest.mark.parametrize("cells", [1, 3])
def test_a_follower_that_turns_back_keeps_its_sense(sense, swing, cells):
    theta = np.arange(60) / 60 * TURN + TURN * (np.arange(60) % cells)
    phi = sense * (0.5 * theta / TURN + swing * np.sin(theta))
    table = esc.Tabulated(theta, phi, cell_angle=TURN, follower_step=0.5)
    assert table.sense == sense
    truth = 0.5 / TURN + swing * np.cos(ANGLES)
    np.testing.assert_allclose(table.transmission(ANGLES).g, truth, rtol=0.0, atol=1e-7)
