"""Prikhodko (2020): printed numbers, errata, figures and the command line."""

import math

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.special import gammaincc

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.measurement import sturges
from escapement.outlines.gears import EllipticalOutline
from escapement.plots import planetary
from escapement.sources import prikhodko
from escapement.sources.prikhodko import prikhodko_figures
from escapement.study.parse import parse_plan
from figure_tools import by_id

PAPER = esc.EllipticalPlanetary(sun_radius=0.016, planet_radius=0.009)


# --- numbers ------------------------------------------------------------------------------


def test_every_number_is_right_or_has_its_reason():
    rows = {row.column: row for row in prikhodko.table()}
    assert len(rows) == 17
    wrong = {name: (row.true, row.reason) for name, row in rows.items() if not row.agrees}
    assert wrong == {
        "intervals": ("8", "the next greater whole number: 8.205"),
        "quantile": ("2.58", "cut off, not rounded: 2.5758"),
        "half_width": ("3.34", "cut off, not rounded: 3.3359"),
    }
    raw = [name for name, row in rows.items() if row.true is None]
    assert raw[:3] == ["sun_radius", "planet_radius", "sample_size"]
    assert raw[3:] == ["error_mean", "error_deviation", "chi_squared"]


def test_statistics_by_other_means():
    rows = {row.column: row.value for row in prikhodko.table()}
    # (16) is the incomplete gamma function; for six degrees of freedom a finite sum
    half = 7.595 / 2.0
    assert rows["significance"] == pytest.approx(100.0 * gammaincc(3.0, half), rel=1e-12)
    by_hand = math.exp(-half) * (1.0 + half + half * half / 2.0)
    assert rows["significance"] == pytest.approx(100.0 * by_hand, rel=1e-12)
    assert math.erf(rows["quantile"] / math.sqrt(2.0)) == pytest.approx(0.99, abs=1e-14)
    assert rows["half_width"] == pytest.approx(3.33586, abs=1e-12)
    assert sturges(148) == pytest.approx(3.32 * math.log10(148) + 1.0)
    assert rows["degrees_of_freedom"] == 6.0


def test_the_drive_is_that_of_table_1():
    assert prikhodko.drive() == PAPER


def test_a_measurement_such_as_the_paper_s():
    made_up = prikhodko.synthetic_measurement()
    assert made_up.readings.synthetic
    assert made_up.errors.size == 148
    assert made_up.histogram.observed.size == 9
    deviation = math.degrees(made_up.standard_deviation)
    assert deviation == pytest.approx(1.298, abs=4.0 * 1.298 / math.sqrt(2 * 148))
    assert made_up.published_test.degrees_of_freedom == 6


# --- figures ------------------------------------------------------------------------------


def test_position_function_is_flat_at_the_stops():
    ax = prikhodko_figures.plot_position_function(PAPER)
    curve, marks = (line.get_xydata() for line in ax.lines[:2])
    stops = [line.get_xdata()[0] for line in ax.lines if line.get_linestyle() == ":"]
    assert stops == pytest.approx([101.25, 303.75])
    assert curve[-1] == pytest.approx([405.0, -315.0])
    near = np.abs(curve[:, 0] - stops[0]) < 5.0
    assert np.ptp(curve[near, 1]) < 0.02
    assert marks[[0, 4], 0] == pytest.approx(stops)
    assert marks[2] == pytest.approx([202.5, -157.5])


@pytest.mark.parametrize("drive", [PAPER, esc.EllipticalPlanetary.from_ellipse(0.1, 0.6)])
def test_velocity_plans_hold_equation_3(drive):
    """Lines of a plan: its slopes are the speeds, and D' lies on the planet's line."""
    axes = prikhodko_figures.plot_velocity_plans(drive).axes
    for ax, theta in zip(axes, prikhodko_figures.positions(drive), strict=True):
        carrier, planet, output = (line.get_xydata() for line in ax.lines[-3:])
        scale = carrier[1, 0] / carrier[1, 1]
        np.testing.assert_allclose(carrier[1], planet[1])
        speeds = output[1, 0] / scale, output[1, 1]
        g = float(drive.transmission(theta).g)
        assert speeds[0] / speeds[1] == pytest.approx(-g, abs=1e-12)
        # the planet does not move where it rolls on the sun
        share = (1e3 * drive.sun_radius - planet[0, 1]) / (planet[1, 1] - planet[0, 1])
        rolling = planet[0, 0] + share * (planet[1, 0] - planet[0, 0])
        assert rolling == pytest.approx(0.0, abs=1e-12 * drive.ratio)
        np.testing.assert_allclose(planet[0], output[1], atol=1e-9)


@pytest.mark.parametrize("theta", [-2.0, 0.0, 0.4, 1.7, 9.0])
@pytest.mark.parametrize("drive", [PAPER, esc.EllipticalPlanetary.from_ellipse(0.1, 0.6)])
def test_ellipses_touch_where_the_dot_is_and_nowhere_overlap(drive, theta):
    ax = planetary.plot_planetary(drive, theta, Figure().add_subplot())
    assert ax.get_aspect() == 1.0
    dot = by_id(ax, "contact").get_xydata()[0] @ [1, 1j]
    along = np.exp(1j * theta)
    assert (dot / along).imag == pytest.approx(0.0, abs=1e-9)
    pivots, semi = (0.0, 1e3 * drive.centre_distance * along), 1e3 * drive.semi_major_axis
    edges = [by_id(ax, name).get_path().vertices @ [1, 1j] for name in ("driven", "driving")]
    for edge, pivot in zip(edges, pivots, strict=True):
        # the other focus lies opposite: distances to both make up 2a
        ends = edge[[0, (edge.size - 1) // 2]]
        other = ends.sum() - pivot
        # the arcs that are drawn leave the ellipse by less than a micrometre
        np.testing.assert_allclose(np.abs(edge - pivot) + np.abs(edge - other), 2 * semi, atol=1e-3)
        assert abs(dot - pivot) + abs(dot - other) == pytest.approx(2 * semi, rel=1e-12)
    # outside of the driving ellipse is beyond 2a from its focuses
    apart = np.abs(edges[0] - pivot) + np.abs(edges[0] - other)
    assert apart.min() >= 2.0 * semi - 2e-3


def test_output_turns_in_the_drawing_as_it_should():
    first, second = (EllipticalOutline(PAPER).bodies(at, carrier=0.0)[2] for at in (0.3, 1.4))
    # seen from the carrier; in space the carrier's turn is added
    turned = np.angle(second.edges[0].corners[0] / first.edges[0].corners[0]) + (1.4 - 0.3)
    expected = -np.diff(PAPER.follower_angle([0.3, 1.4]))[0]
    assert turned == pytest.approx(expected, abs=1e-9)


# --- command line -------------------------------------------------------------------------


def test_a_study_names_the_loss_of_its_mechanism():
    study = {
        "mechanism": {"kind": "elliptical-planetary", "sun_radius": 0.016},
        "inertia": {"driver": 1e-5, "follower": 2e-5},
        "torque": 0.01,
        "sweep": {"planet_radius": [0.008, 0.009]},
    }
    assert parse_plan(study).escapement(1).mechanism == PAPER
    study["friction"] = 0.1
    with pytest.raises(InvalidValue, match=r"'friction' .* a mechanism with a slot"):
        parse_plan(study)
    study |= {"mechanism": {"slots": 4}, "sweep": {"load_torque": [0.0]}}
    study["efficiency"] = study.pop("friction")
    with pytest.raises(InvalidValue, match=r"'efficiency' .* a mechanism without a slot"):
        parse_plan(study)
