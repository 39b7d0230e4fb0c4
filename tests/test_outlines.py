"""Curves of lines and arcs: their moments, curves beside them, gaps, and the motion check."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.outlines.bodies import Disc
from escapement.outlines.curves import Curve, chain, stadium
from escapement.outlines.gaps import gap, outside, segments_of
from escapement.outlines.gears import pitch_curve
from escapement.outlines.geneva import GenevaOutline, locking_disc
from escapement.outlines.interference import least_gaps

SIZED = {"crank_radius": 0.02, "pin_radius": 0.001, "clearance": 2e-5}
WHEEL = esc.Geneva(5, 1, **SIZED)
CURVES = {
    "follower": GenevaOutline(WHEEL).follower_edge,
    "ring": GenevaOutline(esc.Geneva(4, internal=True)).follower_edge,
    "locking disc": locking_disc(WHEEL),
    "ellipse": pitch_curve(12.5, 0.28),
    "stadium": stadium(0.3, 2.0),
}
SHAPES = pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)


@SHAPES
def test_moments_are_those_of_a_polygon_of_a_hundred_thousand_points(curve):
    z = curve.drawn(np.abs(curve.turns).sum() / 1e5)
    assert z.size > 1e5
    a, b = z[:-1], z[1:]
    cross = (a.conj() * b).imag
    # of the triangles from the origin
    first = np.sum(cross * (a + b)) / 6.0
    second = np.sum(cross * (np.abs(a) ** 2 + (a.conj() * b).real + np.abs(b) ** 2)) / 12.0
    found = curve.moments
    assert found.area == pytest.approx(0.5 * cross.sum(), rel=1e-7)
    assert found.second == pytest.approx(second, rel=1e-7)
    assert found.first == pytest.approx(first, rel=1e-7, abs=1e-7 * abs(found.area))


@SHAPES
def test_a_cutter_runs_beside_the_line_by_its_half_width(curve):
    width = 0.01
    beside = curve.grown(width)
    distance, _ = outside(segments_of([curve]), beside.at(np.linspace(0.0, 1.0, 7)).ravel())
    np.testing.assert_allclose(distance, width, rtol=1e-9)
    # Steiner: a body without corners that point inwards grows by its edge and one circle
    whole = math.copysign(1.0, curve.moments.area)
    expected = curve.moments.area + width * curve.length + whole * math.pi * width**2
    assert beside.moments.area == pytest.approx(expected, rel=1e-9)
    back = np.array(curve.reversed().moments) + np.array(curve.moments)
    np.testing.assert_allclose(back, 0.0, atol=1e-9 * abs(curve.moments.area))


def test_a_cutter_that_does_not_get_in_is_refused():
    with pytest.raises(InvalidValue, match="choose a narrower kerf"):
        CURVES["follower"].grown(0.06)
    corner = chain([0.0, 2.0, 2.0 + 1j, 1.0 + 1j, 1.0 + 2j, 2j], [0.0] * 6)
    with pytest.raises(InvalidValue, match=r"got one at 1\+1j that points into the body"):
        corner.grown(0.1)


PLACE = st.complex_numbers(max_magnitude=2.0, allow_nan=False)


@settings(deadline=None)
@given(PLACE, PLACE, st.floats(0.0, 6.3), st.floats(0.1, 0.5), st.floats(0.1, 2.0))
def test_gap_of_two_rounded_bars(by, at, angle, radius, length):
    one, two = stadium(0.2, 1.0), stadium(radius, length)
    found, _ = gap(segments_of([one]), segments_of([two.moved(np.exp(1j * angle), by)]))
    # the bars are all that lies within a radius of a segment
    along = by + length * np.exp(1j * angle) * np.linspace(0.0, 1.0, 2001)
    axes = np.abs(along - np.clip(along.real, 0.0, 1.0)).min()
    apart = axes - 0.2 - radius
    if axes > 1e-3:  # else they may lie across each other
        assert (found < 0.0) == (apart < 0.0) or abs(apart) < 1e-3
    if apart > 0.0:
        assert found == pytest.approx(apart, abs=1e-3)
    disc, _ = outside(segments_of([one]), np.array([at]))
    assert disc[0] == pytest.approx(abs(at - np.clip(at.real, 0.0, 1.0)) - 0.2, abs=1e-12)


def test_a_point_right_beside_a_sharp_corner_is_outside():
    sharp = segments_of([chain([0.0, -2.0 + 0.3j, -2.0 - 0.3j], [0.0] * 3)])
    for turn in np.exp(1j * np.arange(1.0, 7.0)):
        for apart in (1e-7, 1e-8, 1e-9, 1e-10):
            points = 0.7 + apart * turn * np.exp(1j * np.linspace(-1.6, 1.6, 101))
            assert outside(sharp.moved(turn, 0.7), points)[0].min() > 0.0


@pytest.mark.parametrize("eccentricity", [0.05, -0.28, 0.9])
@pytest.mark.parametrize("a", [1.0, 12.5, 400.0])
def test_arcs_leave_an_ellipse_by_less_than_a_micrometre(a, eccentricity):
    turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 3001))
    minor = math.sqrt(1.0 - eccentricity**2)
    ellipse = a * (eccentricity + turn.real + 1j * minor * turn.imag)  # a focus at 0 [mm]
    distance, _ = outside(segments_of([pitch_curve(a, eccentricity)]), ellipse)
    assert np.abs(distance).max() < 1e-3


def test_the_box_of_a_curve_holds_it_and_touches_it():
    for curve in (*CURVES.values(), Curve.circle(2.0, 1.0 + 1.0j)):
        low, high = curve.moved(np.exp(0.3j)).box
        z = curve.moved(np.exp(0.3j)).drawn(1e-3)
        found = [low.real, high.real, low.imag, high.imag]
        expected = [z.real.min(), z.real.max(), z.imag.min(), z.imag.max()]
        np.testing.assert_allclose(found, expected, atol=1e-5 * abs(high - low))


# --- the motion check -----------------------------------------------------------------------

ERROR = 0.02e-3 / SIZED["crank_radius"]
GAP = 0.5 * SIZED["clearance"] / SIZED["crank_radius"]


@pytest.mark.parametrize("slots", [3, 4, 6, 12])
def test_nominal_designs_pass(slots):
    for pins in (None, 1):
        found = least_gaps(GenevaOutline(esc.Geneva(slots, pins, **SIZED)), 181)
        assert min(pair.gap for pair in found) > 0.99 * GAP
        pins_ = [pair.gap for pair in found if "pin" in pair.names[0]]
        np.testing.assert_allclose(pins_, GAP, rtol=1e-9)


def planted(change):
    """The outline of a wheel in which `change` replaces the bodies by name."""
    outline = GenevaOutline(WHEEL)

    def bodies(theta):
        return [change.get(b.name, lambda body, _: body)(b, theta) for b in outline.bodies(theta)]

    given = {"mechanism": WHEEL, "plane": outline.plane, "meshing": outline.meshing}
    return SimpleNamespace(**given, bodies=bodies)


def test_an_error_of_two_hundredths_of_a_millimetre_is_found():
    def thicker(pin, _):
        return pin._replace(radius=pin.radius + GAP + ERROR)

    def nearer(body, _):
        if isinstance(body, Disc):
            return body._replace(centre=body.centre - GAP - ERROR)
        return body.rotated(0.0, -GAP - ERROR)

    def wider(body, theta):
        edges = tuple(edge.moved(by=-WHEEL.centre_distance) for edge in body.edges)
        edges = tuple(edge.grown(2.0 * GAP + ERROR) for edge in edges)
        return body._replace(edges=edges).rotated(0.0, WHEEL.centre_distance)

    # a thick pin has the wall of the slot in it, one too near its end, a large disc the wheel
    for change, name, theta in (
        ({"pin-0": thicker}, "pin-0", None),
        ({"pin-0": nearer}, "pin-0", 0.0),
        ({"locking-disc": wider}, "locking-disc", None),
    ):
        worst = least_gaps(planted(change), 181)[0]
        assert worst.names == (name, "follower")
        assert theta is None or worst.theta == pytest.approx(theta, abs=1e-3)
        assert worst.gap < 0.0
        if name == "pin-0":
            assert worst.gap == pytest.approx(-ERROR, rel=1e-6)
        else:
            assert -1.7 * ERROR < worst.gap < -0.9 * ERROR
