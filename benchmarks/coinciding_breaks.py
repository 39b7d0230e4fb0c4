"""Random torques whose knots coincide with breaks of the wheel: `energy` against `ivp`.

Knots of a torque curve, or the end of a spring, lie at dead centre, at a handoff, one rounding
error beside it, or near it. Prints the greatest differences, and every scene that breaks a bar.

    python benchmarks/coinciding_breaks.py [SCENES] [FIRST SEED]
"""

import sys
from time import process_time

import numpy as np

import escapement as esc

BESIDE = (0.0, 0.0, 0.0, 1e-16, -1e-16, 1e-13, -1e-13, 1e-11, -1e-10, 1e-6, -1e-4)
"""Distances of a knot from the break, as shares of the angle; twice an ulp at 1e-16."""
STATES = ("theta", "theta_dot", "phi", "phi_dot", "theta_ddot", "contact_moment")
BARS = {**dict.fromkeys(STATES, 1e-9), "residual": 1e-12, "seconds": 2.0}


def beside(rng, place):
    """A place, or one next to it; an ulp away for the smallest distances."""
    by = rng.choice(BESIDE)
    if 0.0 < abs(by) < 1e-15:
        return float(np.nextafter(place, np.copysign(np.inf, by)))
    return float(place * (1.0 + by))


def wheel(rng):
    """A Geneva wheel of 3 to 8 slots, its breaks in a cell, and the rest of an escapement."""
    geneva = esc.Geneva(int(rng.integers(3, 9)))
    ratio = 10.0 ** rng.uniform(-1.5, 0.5)
    inertia = esc.Inertia(ratio * 5.65e-6, 5.65e-6)
    plain = esc.Escapement(geneva, inertia, torque=0.0113, friction=0.0)
    critical = min(esc.terminal(plain).critical_friction, 1.0)
    entry, exit_ = geneva.breaks[0], geneva.breaks[-1]
    places = sorted({-entry, exit_ - entry, geneva.cell_angle})
    numbers = {"friction": float(rng.uniform(0.02, 0.8)) * critical}
    return geneva, inertia, places, numbers


def curve_scene(rng):
    """A periodic or single curve with knots at breaks; some of its torques are zero."""
    geneva, inertia, places, numbers = wheel(rng)
    knots = {beside(rng, x) for x in places if rng.random() < 0.8}
    knots |= {float(x) for x in rng.uniform(0.05, 0.95, rng.integers(0, 3)) * geneva.cell_angle}
    knots = sorted(x for x in knots if x < geneva.cell_angle)
    angles = [0.0, *knots, geneva.cell_angle]
    torques = 0.0113 * rng.uniform(0.3, 1.0, len(angles)) * (rng.random(len(angles)) < 0.6)
    # two knots closer than 1e-9 are one, so that a jump between them is not part of the model
    late = np.array(angles) > geneva.cell_angle - 1e-8
    torques[0], torques[late] = 0.0113, 0.0113
    curve = esc.TorqueCurve(angles, torques.tolist(), periodic=bool(rng.random() < 0.7))
    return esc.Escapement(geneva, inertia, torque=curve, **numbers)


def spring_scene(rng):
    """A spring that is spent at a break of one of the first three cells, or near it."""
    geneva, inertia, places, numbers = wheel(rng)
    spent = rng.integers(0, 3) * geneva.cell_angle + rng.choice(places)
    rate = 0.0113 / beside(rng, spent)
    return esc.Escapement(geneva, inertia, torque=0.0113, spring_rate=rate, **numbers)


def compare(escapement, engagements):
    """What `energy` and `ivp` say, and the greatest differences."""
    seconds, motions = [], []
    for engine, rtol in (("energy", None), ("ivp", 1e-12)):
        start = process_time()
        motion = esc.simulate(escapement, engagements, engine=engine, rtol=rtol)
        motion.ledger  # noqa: B018
        seconds.append(process_time() - start)
        motions.append(motion)
    fast, judge = motions
    counts = [_counts(motion) for motion in motions]
    found = {"residual": abs(fast.ledger.residual), "seconds": max(seconds)}
    times = np.linspace(0.0, min(fast.end_time, judge.end_time), 400)[1:-1]
    one, two = fast.at(times), judge.at(times)
    for name in STATES:
        x, y = getattr(one, name), getattr(two, name)
        found[name] = float(np.abs(x - y).max() / max(np.abs(y).max(), 1e-300))
    return counts, found


def _counts(motion):
    """Status, and numbers of handoffs, reversals, extrema and slide changes."""
    events = motion.reversals, motion.extrema, motion.slide_changes
    sizes = (it.time.size for it in events)
    return (motion.status.label, motion.handoff_times.size, *sizes)


def main(scenes=500, first=0):
    compare(spring_scene(np.random.default_rng(first)), 1)  # compiled and imported before it counts
    worst = dict.fromkeys(BARS, 0.0)
    for kind in (curve_scene, spring_scene):
        bad = 0
        for seed in range(first, first + scenes):
            counts, found = compare(kind(np.random.default_rng(seed)), 3 + seed % 2)
            broken = [name for name, bar in BARS.items() if not found[name] <= bar]
            if broken or counts[0] != counts[1]:
                bad += 1
                print(kind.__name__, seed, *counts, {k: f"{found[k]:.1e}" for k in broken})
            worst = {name: max(worst[name], found[name]) for name in BARS}
        print(f"{kind.__name__}: {bad} of {scenes} scenes break a bar", flush=True)
    print("greatest:", {name: f"{value:.2g}" for name, value in worst.items()})


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
