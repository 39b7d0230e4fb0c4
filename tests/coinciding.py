"""Random torques whose knots lie at breaks of a Geneva wheel, beside them or near them."""

import numpy as np

import escapement as esc

BESIDE = (0.0, 0.0, 0.0, 1e-16, -1e-16, 1e-13, -1e-13, 1e-11, -1e-10, 1e-6, -1e-4)
"""Distances of a knot from a break, as shares of its angle; the smallest stand for an ulp."""
STATES = ("theta", "theta_dot", "phi", "phi_dot", "theta_ddot", "contact_moment")
TORQUE = 0.0113


def curve_scene(rng):
    """A curve, mostly periodic, with knots at breaks; some of its torques are zero."""
    geneva, inertia, places, numbers = _wheel(rng)
    knots = {_beside(rng, x) for x in places if rng.random() < 0.8}
    knots |= {float(x) for x in rng.uniform(0.05, 0.95, rng.integers(0, 3)) * geneva.cell_angle}
    angles = [0.0, *sorted(x for x in knots if x < geneva.cell_angle), geneva.cell_angle]
    torques = TORQUE * rng.uniform(0.3, 1.0, len(angles)) * (rng.random(len(angles)) < 0.6)
    # two knots closer than 1e-9 are one, so that a jump between them is not part of the model
    late = np.array(angles) > geneva.cell_angle - 1e-8
    torques[0], torques[late] = TORQUE, TORQUE
    curve = esc.TorqueCurve(angles, torques.tolist(), periodic=bool(rng.random() < 0.7))
    return esc.Escapement(geneva, inertia, torque=curve, **numbers)


def spring_scene(rng):
    """A spring that is spent at a break of one of the first three cells, or near it."""
    geneva, inertia, places, numbers = _wheel(rng)
    spent = rng.integers(0, 3) * geneva.cell_angle + rng.choice(places)
    rate = TORQUE / _beside(rng, spent)
    return esc.Escapement(geneva, inertia, torque=TORQUE, spring_rate=rate, **numbers)


def counts(motion):
    """Status, and numbers of handoffs, reversals, extrema and slide changes."""
    events = motion.reversals, motion.extrema, motion.slide_changes
    sizes = (it.time.size for it in events)
    return (motion.status.label, motion.handoff_times.size, *sizes)


def differences(fast, judge):
    """Greatest difference of each state at 400 instants, relative to the greatest value."""
    times = np.linspace(0.0, min(fast.end_time, judge.end_time), 402)[1:-1]
    one, two = fast.at(times), judge.at(times)
    found = {}
    for name in STATES:
        x, y = getattr(one, name), getattr(two, name)
        found[name] = float(np.abs(x - y).max() / np.abs(y).max())
    return found


def _wheel(rng):
    """A Geneva wheel of 3 to 8 slots, its inertia, its breaks in a cell, and its friction."""
    geneva = esc.Geneva(int(rng.integers(3, 9)))
    inertia = esc.Inertia(10.0 ** rng.uniform(-1.5, 0.5) * 5.65e-6, 5.65e-6)
    plain = esc.Escapement(geneva, inertia, torque=TORQUE, friction=0.0)
    critical = min(esc.terminal(plain).critical_friction, 1.0)
    entry, leaves = geneva.breaks[0], geneva.breaks[-1]
    places = sorted({-entry, leaves - entry, geneva.cell_angle})
    return geneva, inertia, places, {"friction": float(rng.uniform(0.02, 0.8)) * critical}


def _beside(rng, place):
    """A place, or one next to it; an ulp away for the smallest distances."""
    by = rng.choice(BESIDE)
    if 0.0 < abs(by) < 1e-15:
        return float(np.nextafter(place, np.copysign(np.inf, by)))
    return float(place * (1.0 + by))
