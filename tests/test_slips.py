"""Slips of three papers: corrected formulas hold, and printed ones do not."""

from operator import attrgetter

import numpy as np
import pytest

from escapement.constant_speed import geneva, reversal_study
from escapement.mechanisms import Geneva
from escapement.sources import dijksman, report

SHARES = np.array([-0.93, -0.7, -0.41, -0.2, 0.13, 0.35, 0.62, 0.88])
SHARES_BEFORE = SHARES[:4]
"""Places as shares of half an engagement, and those before dead centre."""


def of_filemon():
    """Relative errors for 3 to 10 slots, against the path of the pin."""
    n = np.repeat(np.arange(3, 11), SHARES.size)
    c, half = geneva.crank_ratio(n), geneva.engagement_half(n)
    # the places keep clear of dead centre, where some of the functions are zero
    b = np.resize(SHARES, n.size) * half
    wheels = [Geneva(int(k), pins=1) for k in n]
    found = [wheel.transmission(at) for wheel, at in zip(wheels, b, strict=True)]
    g, dg = np.array([(one.g, one.dg) for one in found]).T
    ddg = np.array([wheel.jerk(at) for wheel, at in zip(wheels, b, strict=True)])
    x = np.cos(b)
    length = 1.0 + c * c - 2.0 * c * x
    ratio, swing = c * (x - c) / length, c * (1.0 - c * c)
    # the acceleration function, from which (7) and the slope of the torque follow
    rate = -swing * np.sin(b) / length**2
    quarters = ((1.0 + sign * c * c) / (4.0 * c) for sign in (-1.0, 1.0))
    curvatures = (2.0 * c * x**2 + (1.0 + sign * c * c) * x - 4.0 * c for sign in (-1.0, 1.0))
    top = 2.0 * c * x**3 + 2.0 * (1.0 - c * c) * x**2 - (5.0 * c + c**3) * x + 5.0 * c * c - 1.0
    # the second term of dM_2/d beta at F = 1, M_e = eta = 1, without its denominator
    term = c * swing * top
    # the formula as printed, the true one, and what both should give
    tried = {
        "acceleration": (ratio**2 * rate, rate, dg),
        "jerk": (*(-swing * curvature / length**3 for curvature in curvatures), ddg),
        "reversal ratio": (
            length**2 / (c * (1.0 - c * c * np.sin(b))), length**2 / (swing * np.sin(b)), -1.0 / dg
        ),
        "steepest": (
            *(np.sqrt(k * k + 2.0) - k for k in quarters), np.cos(geneva.acceleration_max_angle(n))
        ),
        "limit F23": (-1.0 / np.tan(np.arcsin(c)), 1.0 / np.tan(np.arcsin(c)), np.tan(half)),
        "torque slope": (
            rate - term / length**3, rate - term / length**4, dg + dg**2 + g * ddg
        ),
        "cubic": (_cubic(n, 0.0, -1.0, 0.333, 0.074), _cubic(n, 1 / 3, 1.0, 1 / 3, 2 / 27), 1.0),
    }  # fmt: skip
    deviations = {
        name: (printed / goal - 1.0, true / goal - 1.0)
        for name, (printed, true, goal) in tried.items()
    }
    return deviations


def _cubic(n, shift, sign, third, cube):
    """1 + the reduced cubic (12) over y^3, y = cos(beta*) + shift a, at its root."""
    c = geneva.crank_ratio(n)
    a, q, d = (1.0 - c * c) / c, 0.5 * (5.0 + c * c), (5.0 * c * c - 1.0) / (2.0 * c)
    # F is practically infinite
    y = np.cos(reversal_study(n, 1e15).torque_max_angle) + shift * a
    rest = y * (-third * a * a - q) + cube * a**3 + sign * third * q * a + d
    return 1.0 + (y**3 + rest) / y**3


def of_dijksman():
    """Residuals for the mechanisms of the design charts."""
    names = ("stations", "gear_ratio", "cognate.gear_ratio", "alpha", "motion_ratio")
    read = attrgetter(*names, "carrier_over_fixed", "entry_radius_over_fixed")
    # one row for each mechanism, one array for each quantity
    rows = [read(wheel) for wheel in dijksman.chart_mechanisms()]
    n, k, cognate_k, alpha, ratio, carrier, entry = np.array(rows, dtype=float).T
    gamma, factor, turn = 2.0 * np.pi / n, 2.0 / k - 1.0, alpha / (2.0 * np.pi)
    # pi V0 in (10) and (14), with the sign of k and, as (14) has it, without
    signed, positive = np.pi * k * turn, np.pi * ratio

    def left(x):
        return factor * np.sin(x) - np.sin(factor * x + gamma)

    # each is the residual of the formula
    deviations = {
        "(9)": (k * turn / ratio - 1.0, np.abs(k) * turn / ratio - 1.0),
        "(10)": (factor * np.sin(signed) - np.sin(factor * signed) + gamma, left(signed)),
        "(14)": (left(positive), left(np.sign(k) * positive)),
        "cognate": (entry * cognate_k - 1.0, carrier * cognate_k - 1.0),
    }
    return deviations


def of_meyer():
    """Relative errors for 3, 4 and 6 slots."""
    rows = []
    for slots in (3, 4, 6):
        wheel = Geneva(slots)
        theta = SHARES_BEFORE * wheel.breaks[-1]
        found = wheel.transmission(theta)
        a = np.full(theta.shape, 1.0 / np.sin(np.pi / slots))
        rows.append(np.array([a, theta, found.g, found.u, found.dg]))
    a, theta, g, u, dg = np.concatenate(rows, axis=1)
    sine, x = np.sin(theta), a * np.cos(theta) - 1.0
    length, bent = 1.0 + a * a - 2.0 * a * np.cos(theta), a * sine * (1.0 - a * a)
    # driver speed and acceleration, crank radius, and both inertias are 1
    force = (g + dg) / np.sqrt(length)
    moment = bent / length**2 + x / length
    first, second = -2.0 * x * a * sine / length**2, 4.0 * a * sine / length**3
    # the formula as printed, the true one, and what both should give
    tried = {
        "force": (moment / length**1.5, moment / length**0.5, force),
        "force 1-13": (
            bent / length**1.5 + x / length**1.5, bent / length**2.5 + x / length**1.5, force
        ),
        "arm": (a * sine / length**1.5, a * sine / length**0.5, u * np.sqrt(length)),
        "kinetic": (
            first + (-a * np.cos(theta) - 1.0) ** 2 * second, first - x * x * second, 2.0 * g * dg
        ),
        "inertia": (1.0 + x / length**2, 1.0 + x * x / length**2, 1.0 + g * g),
    }  # fmt: skip
    deviations = {
        name: (printed / goal - 1.0, true / goal - 1.0)
        for name, (printed, true, goal) in tried.items()
    }
    return deviations


@pytest.mark.parametrize(
    ("source", "errors", "count"),
    [("meyer", of_meyer, 21), ("filemon", of_filemon, 11), ("dijksman", of_dijksman, 11)],
)
def test_corrected_equations_hold_and_printed_ones_do_not(source, errors, count):
    slips, tried = report.read_table(source, "slips.csv"), errors()
    assert len(slips) == len(report.read_slips(source)) == count
    assert all(slip["printed"] != slip["true"] for slip in slips)
    assert {slip["formula"] for slip in slips} - {""} == set(tried)
    for name, (printed, true) in tried.items():
        assert np.abs(true).max() < 1e-12, name
        assert np.abs(printed).max() > 0.1, name
