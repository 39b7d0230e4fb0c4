"""Worst cases against every vertex of the box, and against the nominal value."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import escapement as esc
from escapement.tolerance.worst_case import EACH, worst_case

TIMER = esc.Escapement(
    esc.Geneva(4, crank_radius=0.01, pin_radius=5e-4), esc.Inertia(3e-7, 5e-6), 0.0113, 0.25
)


def without_slopes(place):
    return np.full(place.size, math.nan)


@pytest.mark.parametrize("corner", list(product((0.0, 1.0), repeat=3)))
def test_a_jump_at_any_vertex_is_found(corner):
    """The figure is even but for a step next to one vertex, as a rise time may be."""

    def figure(place):
        return 1.0 + 0.1 * place[0] + 0.5 * float(np.abs(place - corner).max() < 0.05)

    box, middle = np.array([[0.0, 1.0]] * 3), np.full(3, 0.5)
    found = worst_case(figure, without_slopes, box, middle, np.array([middle, middle]))
    assert found.searched
    # the value at the vertex, or one beside it on the step, which rises with the first number
    assert 0.0 <= found.high - (1.5 + 0.1 * corner[0]) < 0.005
    assert found.low == pytest.approx(1.0, abs=1e-5)


def test_a_figure_that_jumps_takes_few_cases():
    asked = []

    def figure(place):
        asked.append(place)
        return float(np.floor(3.0 * place.sum()) + 0.1 * np.sin(9.0 * place).sum())

    box, middle = np.array([[0.0, 1.0]] * 6), np.full(6, 0.5)
    worst_case(figure, without_slopes, box, middle, np.array([middle, middle]))
    assert len(asked) < 2**6 + 4 * 6 * EACH


def test_vertices_of_many_numbers_are_reached_one_number_at_a_time():
    random = np.random.default_rng(3)
    weights, box = random.normal(size=12), np.array([[-1.0, 1.0]] * 12)

    def figure(place):
        # steps in each number, so that no search along a line finds a slope
        return float(weights @ np.sign(place - 0.999) + weights @ np.sign(place + 0.999))

    drawn = random.uniform(-0.5, 0.5, (2, 12))
    found = worst_case(figure, without_slopes, box, np.zeros(12), drawn)
    assert found[:2] == pytest.approx((-2.0 * abs(weights).sum(), 2.0 * abs(weights).sum()))


def test_a_nominal_point_outside_the_box_is_no_case():
    box = np.array([[1.0, 2.0]])
    found = worst_case(lambda x: float(x[0]), lambda x: x * 0.0 + 1.0, box, np.zeros(1), box.T)
    assert found[:2] == (1.0, 2.0)


def test_a_peak_at_the_nominal_point_is_found():
    def figure(place):
        return 2.0 if (place == 0.5).all() else 1.0

    box, middle = np.array([[0.0, 1.0]] * 2), np.full(2, 0.5)
    assert worst_case(figure, without_slopes, box, middle, box.T)[:2] == (1.0, 2.0)


def test_no_vertex_lies_beyond_the_worst_case_of_a_rise():
    tolerances = {
        "friction": {"tolerance": 0.03},
        "torque": {"relative_tolerance": 0.03},
        "driver_inertia": {"relative_tolerance": 0.1},
    }
    figures = ["rise_time", "settling_time", "rise_time_98"]
    found = esc.budget(TIMER, tolerances, figures=figures, size=64, seed=2).figures
    cases = [
        replace(
            TIMER,
            friction=0.25 + 0.03 * x,
            torque=0.0113 * (1.0 + 0.03 * y),
            inertia=replace(TIMER.inertia, driver=3e-7 * (1.0 + 0.1 * z)),
        )
        for x, y, z in product((-1.0, 1.0), repeat=3)
    ]
    solved = [esc.terminal(case) for case in cases]
    for name in figures:
        low, high, _ = found[name].worst
        values = [getattr(one, name) for one in solved]
        assert low <= min(values) * (1.0 + 1e-12)
        assert max(values) * (1.0 - 1e-12) <= high
        assert low <= found[name].nominal <= high


@pytest.mark.parametrize(
    ("tolerances", "figure", "start"),
    [
        ({"centre_distance_error": {"tolerance": 1e-9}}, "rise_time_98", 0.0),
        ({"initial_speed": {"low": 39.0, "high": 41.0}}, "rise_time_63", 40.0),
    ],
)
def test_the_nominal_value_lies_within_its_worst_case(tolerances, figure, start):
    """It is that of perfect parts, and of a motion that starts like those of the sample."""
    found = esc.budget(TIMER, tolerances, figures=[figure], size=20).figures[figure]
    expected = getattr(esc.terminal(TIMER, initial_speed=start), figure)
    assert found.nominal == pytest.approx(expected, rel=1e-12)
    low, high, _ = found.worst
    assert low <= found.nominal <= high
    assert high - low < 0.1 * low
