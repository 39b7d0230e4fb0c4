"""Rise and settling time by their definition, from extrema that the other engine located."""

import numpy as np
import pytest

import escapement as esc
from escapement.metrics import RISE_BAND, SETTLING_BAND

TRUTH = {"engine": "ivp", "rtol": 1e-12}
# a wheel, and friction over its Painleve limit: enough to settle within six engagements
SCENES = {
    "no dwell": (esc.Geneva(4), 0.06, 0.9),
    "a dwell": (esc.Geneva(6, pins=2), 0.8, 0.6),
    "one pin, heavy driver": (esc.Geneva(3, pins=1), 5.0, 0.95),
    "internal": (esc.Geneva(5, pins=1, internal=True), 0.3, 0.7),
    "light driver": (esc.Geneva(8, pins=2), 0.01, 0.3),
}


def times(drive, engagements):
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
    rise, settling = times(drive, 6)
    for rtol in (1e-4, 1e-8, 1e-10, 1e-12):
        figures = esc.terminal(drive, rtol=rtol)
        # the other engine's extrema are good to some 1e-11
        assert figures.rise_time == pytest.approx(rise, rel=rtol + 3e-11)
        assert figures.settling_time == pytest.approx(settling, rel=rtol + 3e-11)
