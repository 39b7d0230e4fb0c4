"""Greatest accelerations and moments against a denser search; rise and settling by definition."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

import escapement as esc
from both_engines import each_engine
from escapement.dynamics.figures_of_merit import RISE_BAND, SETTLING_BAND

SUN = 0.02
# mechanism, driver over follower inertia, friction, efficiency: light drivers, whose
# acceleration peaks within a thousandth of the time of a piece
LIGHT = {
    "elliptical": (esc.EllipticalPlanetary(SUN, 0.006936), 2.6456e-4, 0.0, 0.6958),
    "eccentric": (esc.EllipticalPlanetary(SUN, 0.01767), 6.034e-6, 0.0, 0.3439),
    "gear": (esc.GearDriven(5, Fraction(11, 3), "epicycloid", pins=3), 1.796e-6, 1.783e-4, 1.0),
    "geneva": (esc.Geneva(6, pins=1), 4.518e-7, 4.961e-4, 1.0),
    "meyer": (esc.Geneva(4), 0.06, 0.35, 1.0),
}
NAMES = {
    "acceleration_max": "theta_ddot",
    "follower_acceleration_max": "phi_ddot",
    "contact_moment_max": "contact_moment",
}


def looked_up(motion, names):
    """Greatest magnitudes at some 60 000 times a piece, even in angle and close to its ends."""
    near = np.geomspace(1e-11, 0.5, 5000)
    shares = np.unique(np.concatenate([np.linspace(0.0, 1.0, 20001), near, 1.0 - near]))
    greatest = dict.fromkeys(names, 0.0)
    for piece, (start, end) in enumerate(pairwise([*motion.trajectory.start, motion.end_time])):
        times = start + (end - start) * shares
        theta = motion.within(piece, times).theta
        times = np.union1d(times, np.interp(theta[0] + np.ptp(theta) * shares, theta, times))
        state = motion.within(piece, times)
        for name in names:
            greatest[name] = max(greatest[name], np.abs(getattr(state, name)).max())
    return greatest


@pytest.mark.parametrize("scene", LIGHT)
def test_no_peak_is_overlooked(scene):
    mechanism, rho, friction, efficiency = LIGHT[scene]
    inertia = esc.Inertia(rho, 1.0)
    timer = esc.Escapement(mechanism, inertia, 1.0, friction, efficiency=efficiency)
    figures = esc.terminal(timer)
    cycle = esc.simulate(timer, 1, initial_speed=figures.handoff_velocity)
    expected = looked_up(cycle, NAMES.values())
    for figure, name in NAMES.items():
        ratio = getattr(figures, figure) / expected[name]
        assert 1.0 - 1e-9 < ratio < 1.0 + 1e-4, figure


UNEQUAL = {"slot_angle_errors": (2e-4, 1e-4, 5e-4, -3e-4, -2e-4), "centre_distance_error": 5e-6}


@each_engine
@pytest.mark.parametrize("wheel", [{"slots": 6, "pins": 3}, {"slots": 5, **UNEQUAL}])
def test_the_follower_bearing_rubs_one_way_up_to_the_ends_of_a_piece(wheel, engine):
    """At pin entry g is zero, where rounding must not choose the way of its friction."""
    timer = esc.Escapement(
        *(esc.Geneva(**wheel, crank_radius=0.01, pin_radius=5e-4), esc.Inertia(4e-7, 5e-6), 0.01),
        **{"friction": 0.2, "follower_bearing_friction": 0.2, "follower_bearing_radius": 1e-3},
    )
    figures = esc.terminal(timer, engine=engine, rtol=1e-12)
    shares = np.concatenate([[0.0, 1e-9], np.linspace(1e-3, 0.999, 5000), [1.0 - 1e-9, 1.0]])
    motion, forces = figures.motion, []
    for piece, (start, end) in enumerate(pairwise([*motion.trajectory.start, motion.end_time])):
        times = start + (end - start) * shares
        forces.append(np.abs(motion.within(np.full(times.size, piece), times).contact_force))
    jumps = np.abs(np.diff(forces, axis=1)[:, [0, -1]])
    assert jumps.max() < 1e-6 * figures.contact_force_max
    assert figures.contact_force_max == pytest.approx(np.max(forces), rel=1e-6)


TRUTH = {"engine": "ivp", "rtol": 1e-12}
# a wheel, and friction over its Painleve limit: enough to settle within six engagements
SCENES = {
    "a dwell": (esc.Geneva(6, pins=2), 0.8, 0.6),
    "one pin, heavy driver": (esc.Geneva(3, pins=1), 5.0, 0.95),
    "light driver": (esc.Geneva(8, pins=2), 0.01, 0.3),
}


def defined_times(drive, engagements):
    """Rise and settling time [s]: first extremum within the band, first of which none leaves it."""
    motion, last = esc.simulate(drive, engagements, **TRUTH), esc.terminal(drive, **TRUTH)
    found = motion.extrema
    final = np.where(found.maximum, last.velocity_max, last.velocity_min)
    off = np.abs(found.theta_dot / final - 1.0)
    leading = np.zeros(off.size, dtype=bool)
    for engagement in range(engagements):
        for maximum in (True, False):
            own = np.flatnonzero((found.engagement == engagement) & (found.maximum == maximum))
            if own.size:
                speeds = found.theta_dot[own]
                leading[own[speeds.argmax() if maximum else speeds.argmin()]] = True
    time, outside = found.time[leading], np.flatnonzero(off[leading] > SETTLING_BAND)
    assert 0 <= outside[-1] < time.size - 3, "give more engagements"
    return found.time[off <= RISE_BAND][0], time[outside[-1] + 1]


@pytest.mark.parametrize("scene", SCENES)
def test_times_are_those_of_the_extrema_at_any_tolerance(scene):
    wheel, ratio, share = SCENES[scene]
    inertia = esc.Inertia(ratio, 1.0)
    friction = share * esc.critical_friction(wheel, inertia)
    drive = esc.Escapement(wheel, inertia, 1.0, friction)
    rise, settling = defined_times(drive, 6)
    for rtol in (1e-4, 1e-8, 1e-10, 1e-12):
        figures = esc.terminal(drive, rtol=rtol)
        # the other engine's extrema are good to some 1e-11
        assert figures.rise_time == pytest.approx(rise, rel=rtol + 3e-11)
        assert figures.settling_time == pytest.approx(settling, rel=rtol + 3e-11)
