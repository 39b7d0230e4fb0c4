"""The planetary drive with elliptical gears against its geometry and the paper's equations."""

import math
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import escapement as esc
from escapement.errors import InvalidValue
from escapement.mechanisms._slotted import transmission
from escapement.mechanisms.elliptical_teeth import fewest_teeth, tooth_module
from escapement.model import Mechanism
from escapement.units import INCH_POUND

PAPER = esc.EllipticalPlanetary(sun_radius=0.016, planet_radius=0.009)
drives = st.builds(
    esc.EllipticalPlanetary.from_ellipse, st.floats(1e-3, 1e3), st.floats(1e-3, 0.95)
)
places = st.floats(-1.0, 1.0)


def analogue(drive, theta):
    """The paper's (9), with (6), in 30 digits: output over input speed."""
    with mpmath.workdps(30):
        sun, planet = mpmath.mpf(drive.sun_radius), mpmath.mpf(drive.planet_radius)
        a, e = (sun + planet) / 2, (sun - planet) / (sun + planet)
        rho = a * (1 - e**2) / (1 - e * mpmath.cos(sun / planet * theta))
        return 1 - sun * rho / (planet * (sun + planet - rho))


def test_the_paper_s_drive():
    """Table 1, and the stop interval of section 3; R1 = 16, R2 = 9 mm."""
    assert 1e3 * PAPER.semi_major_axis == pytest.approx(12.5, rel=1e-15)
    assert 1e3 * PAPER.semi_minor_axis == pytest.approx(12.0, rel=1e-15)
    assert 1e3 * PAPER.focal_distance == pytest.approx(3.5, rel=1e-15)
    assert PAPER.eccentricity == pytest.approx(0.28, rel=1e-15)
    assert math.degrees(PAPER.cell_angle) == pytest.approx(202.5, rel=1e-15)
    assert -math.degrees(PAPER.follower_step) == pytest.approx(-157.5, rel=1e-15)
    assert PAPER.ratio_max == pytest.approx((16 / 9) ** 2 - 1, rel=1e-15)
    assert PAPER.stations == 16
    assert isinstance(PAPER, Mechanism)


@settings(deadline=None, max_examples=40)
@given(drives, st.floats(-3.0, 3.0))
def test_transmission_is_equation_9(drive, place):
    theta = place * drive.cell_angle
    found = drive.transmission(theta)
    expected = -analogue(drive, mpmath.mpf(theta))
    # an angle of this size carries its own rounding into the planet's turn
    assert float(found.g) == pytest.approx(float(expected), abs=1e-14 * (1.0 + drive.ratio**4))
    assert float(found.u) == 0.0


@settings(deadline=None, max_examples=15)
@given(drives.filter(lambda drive: drive.ratio < 5.0), places)
def test_position_function_is_the_integral_of_equation_9(drive, place):
    theta = 0.5 * place * drive.cell_angle
    with mpmath.workdps(20):
        integral = mpmath.quad(lambda x: analogue(drive, x), [0, theta / 2, theta])
    scale = 1.0 + drive.follower_step
    assert float(drive.follower_angle(theta)) == pytest.approx(-float(integral), abs=1e-14 * scale)


def test_position_function_of_the_paper_to_1e_14():
    """Three cells of the drive that was measured, by quadrature of (9)."""
    theta = np.linspace(0.0, 3.0 * PAPER.cell_angle, 13)
    with mpmath.workdps(20):
        pieces = [
            mpmath.quad(lambda x: analogue(PAPER, x), [low, high]) for low, high in pairwise(theta)
        ]
    np.testing.assert_allclose(
        PAPER.follower_angle(theta[1:]), -np.cumsum(pieces).astype(float), rtol=0.0, atol=1e-14
    )


@settings(deadline=None)
@given(drives, places)
def test_closed_form_of_the_position_function(drive, place):
    """phi = theta - p - 2 atan2(e sin p, 1 - e cos p), another form of the integral."""
    theta = 0.5 * place * drive.cell_angle
    e, p = drive.eccentricity, drive.ratio * theta
    other = theta - p - 2.0 * math.atan2(e * math.sin(p), 1.0 - e * math.cos(p))
    assert float(drive.follower_angle(theta)) == pytest.approx(-other, abs=2e-14)


@settings(deadline=None)
@given(drives, places)
def test_derivatives_are_derivatives(drive, place):
    theta = 0.5 * place * drive.cell_angle
    h = 1e-3 * drive.cell_angle * (1.0 - drive.eccentricity)
    nodes = theta + h * np.array([-2.0, -1.0, 1.0, 2.0])
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * h)
    found, near = drive.transmission(theta), drive.transmission(nodes)
    scale = drive.ratio_max
    rate = scale / drive.cell_angle / (1.0 - drive.eccentricity)
    assert weights @ drive.follower_angle(nodes) == pytest.approx(float(found.g), abs=1e-7 * scale)
    assert weights @ near.g == pytest.approx(float(found.dg), abs=1e-6 * rate)
    jerk = float(drive.jerk_function(theta))
    assert weights @ near.dg == pytest.approx(
        jerk, abs=1e-5 * rate / drive.cell_angle / (1.0 - drive.eccentricity)
    )


@settings(deadline=None)
@given(drives)
def test_the_output_stops_at_both_ends_of_a_cell(drive):
    ends = np.array(drive.breaks)
    found = drive.transmission(ends)
    assert np.abs(found.g).max() < 1e-28 * drive.ratio_max * drive.ratio**2
    assert np.abs(found.dg).max() < 1e-14 * drive.ratio_max * drive.ratio
    assert np.diff(ends)[0] == pytest.approx(drive.cell_angle, rel=1e-15)
    turned = np.diff(drive.follower_angle(ends))[0]
    assert turned == pytest.approx(drive.follower_step, rel=1e-13)
    inside = np.linspace(*ends, 101)[1:-1]
    assert (drive.transmission(inside).g > 0.0).all()
    away = drive.follower_angle(inside + 7.0 * drive.cell_angle) - 7.0 * drive.follower_step
    np.testing.assert_allclose(away, drive.follower_angle(inside), rtol=0.0, atol=1e-12)


@settings(deadline=None)
@given(drives)
def test_kernels_see_the_same_transmission(drive):
    theta = np.linspace(*drive.breaks, 201)
    mine, theirs = drive.transmission(theta), transmission(drive.path, theta)
    # the stops lie a few last digits outside, and the angle itself has one
    moved = 10.0 * math.ulp(drive.breaks[1])
    slope = np.abs(mine.dg).max()
    assert np.abs(mine.g - theirs.g).max() <= 1e-14 * drive.ratio_max + moved * slope
    # a rounding error in every coefficient of order k comes out k^2 times as great
    pieces, order = int(drive.path[1]), drive.path[2]
    length = np.diff(drive.path[3 : 4 + pieces])
    piece = np.clip(np.searchsorted(drive.path[3 : 3 + pieces], theta, "right") - 1, 0, pieces - 1)
    tops = np.maximum(mine.g, drive.transmission(drive.path[3 + piece]).g)
    tops = np.maximum(tops, drive.transmission(drive.path[3 + piece] + length[piece]).g)
    rounding = np.finfo(float).eps * tops * 2.0 / length[piece] * order**3
    bend = np.abs(drive.jerk_function(theta)).max()
    assert (np.abs(mine.dg - theirs.dg) <= rounding + moved * bend).all()


@settings(deadline=None)
@given(drives)
def test_the_table_keeps_its_signs_up_to_the_stops(drive):
    """Within a millionth of a cell of a stop g and g' are what their squares and lines say."""
    away = drive.cell_angle * np.geomspace(1e-10, 1e-6, 25)
    curvature = 0.5 * drive.ratio_max
    for stop, side in zip(drive.breaks, (1.0, -1.0), strict=True):
        theta = stop + side * away
        found, left = transmission(drive.path, theta), side * (theta - stop)
        np.testing.assert_allclose(found.dg, side * curvature * left, rtol=1e-3)
        np.testing.assert_allclose(found.g, 0.5 * curvature * left**2, rtol=1e-3)
        near = stop + side * drive.cell_angle * np.append(0.0, np.geomspace(1e-16, 1e-6, 41))
        assert (side * transmission(drive.path, near).dg > 0.0).all()


@settings(deadline=None)
@given(drives)
def test_peak_acceleration(drive):
    top, angle = drive.acceleration_max
    theta = np.linspace(drive.breaks[0], 0.0, 4001)
    found = drive.transmission(theta).dg
    assert top >= found.max() * (1.0 - 1e-13)
    assert top == pytest.approx(found.max(), rel=1e-4)
    scale = drive.ratio**2 * drive.ratio_max * drive.ratio**2
    assert abs(float(drive.jerk_function(angle))) < 1e-12 * scale


@settings(deadline=None)
@given(drives, st.floats(1e-9, 0.99), st.floats(1e-9, 0.49))
def test_dwells_end_where_they_say(drive, speed, position):
    stop = drive.breaks[1]
    limit = speed * drive.ratio_max
    half = 0.5 * drive.dwell_below(limit)
    ends = drive.transmission(np.array([stop - half, stop + half])).g
    np.testing.assert_allclose(ends, limit, rtol=1e-7)
    limit = position * drive.follower_step
    half = 0.5 * drive.dwell_within(limit)
    moved = drive.follower_angle(np.array([stop - half, stop, stop + half]))
    np.testing.assert_allclose(np.diff(moved), limit, rtol=1e-6, atol=1e-14)


def test_dwell_of_the_whole_cell():
    assert PAPER.dwell_below(PAPER.ratio_max) == PAPER.cell_angle
    assert PAPER.dwell_within(PAPER.follower_step) == PAPER.cell_angle
    assert PAPER.dwell_below(0.0) == 0.0
    # within the resolution of the paper's encoders the output rests for a ninth of the time
    share = PAPER.dwell_within(2.0 * math.pi / 4096) / PAPER.cell_angle
    assert share == pytest.approx(0.115, abs=5e-4)


# --- pitch curves -------------------------------------------------------------------------


@settings(deadline=None)
@given(drives, st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=20))
def test_pitch_curves_roll_without_slip(drive, places):
    theta = np.array(places) * drive.cell_angle
    driving, driven = drive.pitch_ellipses
    alpha, beta = drive.ratio * theta, theta + drive.follower_angle(theta)
    size = drive.centre_distance
    total = driving.radius(alpha) + driven.radius(beta)
    np.testing.assert_allclose(total, size, rtol=1e-12)
    slack = 1e-12 * (1.0 + np.abs(places).max())
    np.testing.assert_allclose(driving.arc(alpha), driven.arc(beta), rtol=0.0, atol=slack * size)
    # one common tangent: angles from opposite radii
    both = driving.tangent_angle(alpha) + driven.tangent_angle(beta)
    np.testing.assert_allclose(both, math.pi, rtol=0.0, atol=1e-12)
    # and the radii give the speeds
    ratio = drive.ratio * driving.radius(alpha) / driven.radius(beta) - 1.0
    np.testing.assert_allclose(
        drive.transmission(theta).g, ratio, rtol=0.0, atol=1e-11 * drive.ratio**2
    )


def test_arcs_by_quadrature_and_around():
    driving, driven = PAPER.pitch_ellipses
    for gear, sign in ((driving, 1.0), (driven, -1.0)):
        a, e = gear.semi_major_axis, sign * gear.eccentricity

        def speed(x, a=a, e=e):
            r = a * (1 - e * e) / (1 - e * mpmath.cos(x))
            slope = -r * e * mpmath.sin(x) / (1 - e * mpmath.cos(x))
            return mpmath.hypot(r, slope)

        for angle in (0.7, 2.9, 6.0):
            length = float(mpmath.quad(speed, [0, angle / 2, angle]))
            assert float(gear.arc(angle)) == pytest.approx(length, rel=1e-14)
        around = float(gear.arc(2.0 * math.pi))
        whole = float(4 * a * mpmath.ellipe(mpmath.mpf(e) ** 2))
        assert around == pytest.approx(whole, rel=1e-14)


def test_curvature_is_the_turn_of_the_tangent_over_the_arc():
    for gear in PAPER.pitch_ellipses:
        angle = np.linspace(0.0, 2.0 * math.pi, 37)
        h = 1e-4
        turn = angle + gear.tangent_angle(angle)
        turned = (angle + h + gear.tangent_angle(angle + h)) - (
            angle - h + gear.tangent_angle(angle - h)
        )
        assert (np.diff(turn) > 0.0).all()
        slope = turned / (gear.arc(angle + h) - gear.arc(angle - h))
        np.testing.assert_allclose(gear.curvature(angle), slope, rtol=1e-7)
        a, b = gear.semi_major_axis, gear.semi_minor_axis
        assert float(gear.curvature(0.0)) == pytest.approx(a / b**2, rel=1e-14)


# --- the planet's inertia -----------------------------------------------------------------


def test_planet_inertia_is_that_of_a_plate_in_motion():
    """Kinetic energy of a homogeneous ellipse, point by point, at several driver angles."""
    drive, density = PAPER, 3.0
    a, b, c = drive.semi_major_axis, drive.semi_minor_axis, drive.focal_distance
    nodes, weights = np.polynomial.legendre.leggauss(40)
    r, turn = 0.5 * (nodes + 1.0), np.linspace(0.0, 2.0 * math.pi, 64, endpoint=False)
    area = (0.5 * weights * r)[:, None] * np.full(turn.size, 2.0 * math.pi / turn.size) * a * b
    # seen from the shaft; the far vertex points at the carrier's axis when theta = 0
    plate = -(c + a * r[:, None] * np.cos(turn) + 1j * b * r[:, None] * np.sin(turn))
    mass = density * area.sum()
    moment = density * (area * np.abs(plate) ** 2).sum()
    mean, swing = drive.planet_inertia(mass, moment, offset=c)
    for theta in np.linspace(0.0, drive.cell_angle, 7):
        spin = 1.0 + drive.ratio
        points = plate * np.exp(1j * spin * theta)
        speed = 1j * drive.centre_distance * np.exp(1j * theta) + 1j * spin * points
        energy = 0.5 * density * (area * np.abs(speed) ** 2).sum()
        assert 0.5 * (mean - swing * math.cos(drive.ratio * theta)) == pytest.approx(
            energy, rel=1e-12
        )
    assert drive.planet_inertia(mass, moment)[1] == 0.0


# --- construction -------------------------------------------------------------------------


@settings(deadline=None)
@given(st.floats(1e-3, 6.28), st.floats(1e-3, 1e3))
def test_a_wanted_stop_interval(interval, distance):
    drive = esc.EllipticalPlanetary.from_stop_interval(interval, distance)
    assert drive.cell_angle == pytest.approx(interval, rel=1e-14)
    assert drive.centre_distance == pytest.approx(distance, rel=1e-14)
    assert drive.follower_step == pytest.approx(2.0 * math.pi - interval, rel=1e-9)


def test_an_ellipse():
    drive = esc.EllipticalPlanetary.from_ellipse(0.0125, 0.28)
    assert drive.sun_radius == pytest.approx(0.016, rel=1e-15)
    assert drive.planet_radius == pytest.approx(0.009, rel=1e-15)


@pytest.mark.parametrize(
    ("sun", "planet", "stations"), [(2.0, 1.0, 2), (3, 1, 3), (4, 3, 4), (math.pi, 1.0, None)]
)
def test_stations(sun, planet, stations):
    drive = esc.EllipticalPlanetary(sun, planet)
    assert drive.stations == stations
    if stations:
        stops = drive.follower_step * np.arange(stations) / (2.0 * math.pi)
        assert np.unique(np.round(stops % 1.0, 9) % 1.0).size == stations


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: esc.EllipticalPlanetary(9e-3, 16e-3), ["sun_radius", "greater than the planet"]),
        (lambda: esc.EllipticalPlanetary(1.0, 1.0), ["sun_radius", "greater", "1.0"]),
        (lambda: esc.EllipticalPlanetary(1.0, 0.0), ["planet_radius", "greater than 0", "0.0"]),
        (lambda: esc.EllipticalPlanetary("a", 1.0), ["sun_radius", "finite number", "'a'"]),
        (lambda: esc.EllipticalPlanetary(1e6, 1.0), ["sun_radius / planet_radius", "10000"]),
        (lambda: esc.EllipticalPlanetary.from_ellipse(1.0, 1.0), ["eccentricity", "below 1"]),
        (lambda: esc.EllipticalPlanetary.from_ellipse(1.0, 0.0), ["eccentricity", "circle"]),
        (lambda: esc.EllipticalPlanetary.from_ellipse(-1.0, 0.5), ["semi_major_axis", "-1.0"]),
        (lambda: esc.EllipticalPlanetary.from_stop_interval(7.0, 1.0), ["stop_interval", "2 pi"]),
        (lambda: PAPER.dwell_below(-1.0), ["ratio", "at least 0", "-1.0"]),
        (lambda: PAPER.dwell_within(0.0), ["angle", "greater than 0", "0.0"]),
        (lambda: PAPER.planet_inertia(1.0, 1e-9, 1e-3), ["moment", "offset^2", "shaft"]),
    ],
)
def test_impossible_drives_are_refused(make, words):
    with pytest.raises(InvalidValue) as caught:
        make()
    message = str(caught.value)
    assert "\n" not in message
    assert all(word in message for word in words)


# --- as an escapement ---------------------------------------------------------------------

INERTIA = esc.Inertia(driver=3e-6 * INCH_POUND, follower=50e-6 * INCH_POUND)
TORQUE = 0.1 * INCH_POUND


def between_stops(motion, drive):
    """Reversals inside the cells: without a load the force vanishes at the stops as well."""
    place = motion.reversals.theta / drive.cell_angle + 0.5
    return place[np.abs(place - np.rint(place)) > 1e-9]


@pytest.mark.parametrize(
    ("ratio", "efficiency", "load"), [(16 / 9, 0.9, 0.0), (16 / 9, 0.6, 0.3), (3.0, 0.95, 0.1)]
)
def test_both_engines_agree(ratio, efficiency, load):
    timer = esc.Escapement(
        esc.EllipticalPlanetary(ratio, 1.0), INERTIA, TORQUE,
        efficiency=efficiency, load_torque=load * TORQUE,
    )  # fmt: skip
    fast, slow = esc.simulate(timer, 5), esc.simulate(timer, 5, engine="ivp", rtol=1e-11)
    np.testing.assert_allclose(fast.handoff_times, slow.handoff_times, rtol=1e-10)
    np.testing.assert_allclose(fast.handoff_velocities, slow.handoff_velocities, rtol=1e-10)
    np.testing.assert_allclose(
        between_stops(fast, timer.mechanism), between_stops(slow, timer.mechanism), atol=1e-8
    )
    ours, theirs = esc.terminal(timer), esc.terminal(timer, engine="ivp", rtol=1e-10)
    for name in ("velocity_max", "velocity_min", "period", "rise_time", "contact_moment_max"):
        assert getattr(ours, name) == pytest.approx(getattr(theirs, name), rel=1e-7), name


def test_a_heavy_driver_passes_its_stops():
    """The force all but vanishes at a stop: its sign there must not be rounding."""
    timer = esc.Escapement(
        esc.EllipticalPlanetary(1.65, 1.0), esc.Inertia(242.0, 1.0), 1.0, efficiency=0.84
    )
    fast, slow = esc.simulate(timer, 3), esc.simulate(timer, 3, engine="ivp", rtol=1e-10)
    np.testing.assert_allclose(fast.handoff_times, slow.handoff_times, rtol=1e-10)


def test_a_motion_integrated_with_nothing_of_ours():
    """The equation of motion with the paper's (9) and the loss by hand, in time."""
    eta = 0.8
    k, driver, follower = 16 / 9, INERTIA.driver, INERTIA.follower
    e = (k - 1) / (k + 1)

    def ratio(theta):
        rho = (1 - e * e) / (1 - e * np.cos(k * theta))
        slope = -rho * e * k * np.sin(k * theta) / (1 - e * np.cos(k * theta))
        return k * rho / (2 - rho) - 1, 2 * k * slope / (2 - rho) ** 2

    def motion(_t, y):
        g, dg = ratio(y[0])
        # the moment on the follower has the sign of this, whatever the mesh loses
        pushed = driver * follower * dg * y[1] ** 2 + follower * g * TORQUE >= 0.0
        p = g / eta if pushed else g * eta
        return y[1], (TORQUE - p * follower * dg * y[1] ** 2) / (driver + follower * g * p)

    found = esc.simulate(esc.Escapement(PAPER, INERTIA, TORQUE, efficiency=eta), 4)
    times = np.linspace(0.0, found.handoff_times[-1], 25)
    run = solve_ivp(
        motion, (0.0, times[-1]), [PAPER.breaks[0], 0.0], t_eval=times, rtol=1e-10, atol=1e-12,
        max_step=1e-3,
    )  # fmt: skip
    np.testing.assert_allclose(found.at(times).theta_dot, run.y[1], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("efficiency", [0.98, 0.9, 0.6])
def test_contraction_in_closed_form(efficiency):
    """(rho + eta g^2)/(rho + g^2/eta), g being that of the reversal.

    Without a load the speed obeys a linear equation on each side of the reversal, and
    where the force is zero both sides are one: its shift changes nothing at first order.
    """
    cycle = esc.terminal(esc.Escapement(PAPER, INERTIA, TORQUE, efficiency=efficiency))
    angle = cycle.reversal_angles[0]
    rho, square = INERTIA.driver / INERTIA.follower, float(PAPER.transmission(angle).g) ** 2
    expected = (rho + efficiency * square) / (rho + square / efficiency)
    assert cycle.contraction == pytest.approx(expected, rel=1e-8)
    # and the reversal is where I_d (I_f g' w) + I_f g tau = 0
    motion = esc.simulate(
        esc.Escapement(PAPER, INERTIA, TORQUE, efficiency=efficiency), 1,
        initial_speed=cycle.handoff_velocity,
    )  # fmt: skip
    speed, table = motion.reversals.theta_dot[0], PAPER.transmission(motion.reversals.theta[0])
    balance = INERTIA.driver * float(table.dg) * speed**2 / (float(table.g) * TORQUE)
    assert balance == pytest.approx(-1.0, abs=1e-8)


def test_without_a_loss_the_energy_is_the_work():
    found = esc.simulate(esc.Escapement(PAPER, INERTIA, TORQUE), 10)
    assert esc.terminal(found.escapement).status.label == "no_terminal"
    # at a stop the follower rests, so all of it is the driver's
    work = TORQUE * PAPER.cell_angle * np.arange(1, 11)
    np.testing.assert_allclose(0.5 * INERTIA.driver * found.handoff_velocities**2, work, rtol=1e-12)


def test_friction_is_for_slots():
    with pytest.raises(InvalidValue, match=r"friction must be 0 .* efficiency"):
        esc.Escapement(PAPER, INERTIA, TORQUE, friction=0.1)


@pytest.mark.parametrize("efficiency", [1.0, 0.8])
def test_torque_at_constant_speed(efficiency):
    """The drive pays for what the mesh loses, and gets back less than the follower gives."""
    speed, load = 30.0, 2e-4
    drive = esc.drive_torque(PAPER, speed, load, INERTIA.follower, efficiency=efficiency)
    theta = np.linspace(*PAPER.breaks, 4001)
    table = PAPER.transmission(theta)
    power = table.g * (load + INERTIA.follower * speed**2 * table.dg)
    torque = np.where(power > 0.0, power / efficiency, power * efficiency)
    # kernels know g' of a table to 17^3 rounding errors of g over a piece
    np.testing.assert_allclose(drive.at(theta).torque, torque, rtol=0.0, atol=1e-11 * torque.max())
    assert drive.torque_max == pytest.approx(torque.max(), rel=1e-6)
    assert drive.zone == 2
    assert len(drive.reversals) == 2
    # a mean over the whole cell: the load's work and what is lost
    if efficiency == 1.0:
        mean = np.trapezoid(drive.at(theta).torque, theta) / PAPER.cell_angle
        assert mean == pytest.approx(load * PAPER.follower_step / PAPER.cell_angle, rel=1e-6)


# --- teeth --------------------------------------------------------------------------------


def test_fewest_teeth_of_a_circle_are_those_of_every_textbook():
    round_one = esc.EllipticalPlanetary.from_ellipse(1.0, 1e-6)
    assert fewest_teeth(round_one) == 18
    assert fewest_teeth(round_one, math.radians(14.5)) == 32
    assert fewest_teeth(round_one, addendum=0.8) == 14
    assert fewest_teeth(PAPER) == 19


@settings(deadline=None, max_examples=20)
@given(st.floats(0.01, 0.9), st.floats(0.2, 0.6))
def test_a_rack_undercuts_where_its_flank_leaves_a_cusp(eccentricity, angle):
    """The flank that a rolling rack leaves on the gear, point by point.

    Its speed vanishes first for a flank that is cut as the rack touches the sharpest
    place: a cusp, as deep below the pitch line as the addendum may be.
    """
    drive = esc.EllipticalPlanetary.from_ellipse(1.0, eccentricity)
    gear = drive.pitch_ellipses[0]
    radius = 1.0 / float(gear.curvature(0.0))
    few = fewest_teeth(drive, angle)

    def cut(place):
        """Point of the flank that is being cut while the rack touches at `place` [rad]."""
        rolled = float(gear.arc(place))
        heading = place + float(gear.tangent_angle(place))
        touch = float(gear.radius(place)) * np.exp(1j * place)
        away = (radius * math.tan(angle) - rolled) * math.cos(angle)
        return touch + away * np.exp(1j * (heading + angle)), away

    allowed = cut(0.0)[1] * math.sin(angle)
    assert tooth_module(drive, few) <= allowed * (1.0 + 1e-9) < tooth_module(drive, few - 1)
    h = 1e-4
    speed = abs(cut(h)[0] - cut(-h)[0]) / (float(gear.arc(h)) - float(gear.arc(-h)))
    assert speed < 1e-3 * (1.0 + 1.0 / radius)
    ahead = abs(cut(0.3 + h)[0] - cut(0.3 - h)[0]) / (2.0 * h)
    assert ahead > 10.0 * speed


def test_teeth_share_the_perimeter():
    around = 2.0 * float(PAPER.pitch_ellipses[0].arc(math.pi))
    assert 25 * math.pi * tooth_module(PAPER, 25) == pytest.approx(around, rel=1e-13)
    assert esc.EllipticalPlanetary.from_teeth(32, 18, 0.001).ratio == pytest.approx(16 / 9)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: tooth_module(PAPER, 2), ["teeth", "at least 3", "2"]),
        (lambda: fewest_teeth(PAPER, 1.0), ["pressure_angle", "below pi/4"]),
        (lambda: fewest_teeth(PAPER, addendum=0.0), ["addendum", "greater than 0"]),
        (lambda: esc.EllipticalPlanetary.from_teeth(18, 32, 1e-3), ["sun_radius", "greater"]),
        (lambda: esc.EllipticalPlanetary.from_teeth(18.5, 9, 1e-3), ["sun_teeth", "whole"]),
    ],
)
def test_impossible_teeth_are_refused(make, words):
    with pytest.raises(InvalidValue) as caught:
        make()
    assert all(word in str(caught.value) for word in words)
