"""One engagement between walls that yield: this package, solve_ivp and Exudyn.

    pip install -e ".[bench]"
    python benchmarks/compliant_peers.py

The mechanism has four slots, friction 0.3, pins of radius 0.05 r, a play of 5e-4 r on either side,
and walls with a stiffness of 1e6 torque/r^2 and more than critical damping. At the start the
driver turns at 86 rad/s, and the pin is in the middle of its slot. The error is the greater one of
those of time and speed of the handoff. Exudyn's friction is proportional to the speed at low
speeds, and its dashpot can pull, so that it solves a slightly different problem. Its error is
therefore measured against its own finest run, and the difference of that run from ours is printed
separately.

The runs of the solvers alternate; times are medians of processor time. The last column has, for the
fastest run of each solver with an error below 1e-6, its time divided by ours.
"""

import math
import time

import numba
import numpy as np
from common import write_rows
from peers import with_exudyn
from scipy.integrate import solve_ivp

import escapement as esc

RADIUS, TORQUE, DRIVER, FOLLOWER = 0.01, 0.1, 3e-6, 50e-6
CLOCK, UNIT = math.sqrt(FOLLOWER / TORQUE), TORQUE / RADIUS**2
SPEED, TURNS, OURS = 86.0, 7, 20
"""Rounds of all runs, and how often the package's own run in each, because they are short."""
LARGEST = 1e-6
"""Largest error [-] of runs that are compared."""


def problem():
    """The escapement of the comparison."""
    return esc.Escapement(
        esc.Geneva(4, crank_radius=RADIUS, pin_radius=0.05 * RADIUS, clearance=1e-3 * RADIUS),
        esc.Inertia(DRIVER, FOLLOWER),
        torque=TORQUE,
        friction=0.3,
        stiffness=1e6 * UNIT,
        damping=1e3 * UNIT * CLOCK,
        slip_speed=1e-4 * RADIUS / CLOCK,
    )


@numba.njit(error_model="numpy")
def slope(_t, y, centre, rho, play, pin, stiffness, damping, friction, slip):
    """The equations of motion in natural units, in the form that solve_ivp needs."""
    theta, phi, driver, follower = y
    angle = -theta - phi
    sine, cosine = math.sin(angle), math.cos(angle)
    across = -sine - centre * math.sin(phi)
    radius = -cosine + centre * math.cos(phi)
    out = np.empty(4)
    out[0], out[1] = driver, follower
    side = 1.0 if across > 0.0 else -1.0
    depth, rate = side * across - play, side * (cosine * driver - radius * follower)
    on_driver = on_follower = 0.0
    if depth > 0.0:
        force = max(stiffness * depth + damping * rate, 0.0)
        arm = side * pin
        slide = (across + arm) * follower - (sine - arm) * driver
        drag = friction * force * slide / math.sqrt(slide * slide + slip * slip)
        on_driver = drag * (sine - arm) - side * force * cosine
        on_follower = side * force * radius - (across + arm) * drag
    out[2], out[3] = (1.0 + on_driver) / rho, on_follower
    return out


def by_solve_ivp(own, method, rtol):
    """Handoff time and speed by a method of solve_ivp with the compiled law."""
    scene, joint = own.scene, own.joint
    numbers = (own.mechanism.centre_distance, scene.rho, joint.half_clearance, scene.pin)
    numbers += (joint.stiffness, joint.damping, scene.mu_plus, joint.slip)
    start = float(scene.edges[0])
    phi = float(own.mechanism.follower_angle(np.array([start]))[0])

    def arrives(_t, y, *_rest):
        return float(y[0] + start)

    arrives.terminal = True
    atol = rtol * np.array([1e-3, 1e-3, 1.0, 1.0])

    def run():
        found = solve_ivp(
            slope, (0.0, 10.0), [start, phi, SPEED * CLOCK, 0.0], method,
            events=arrives, args=numbers, rtol=rtol, atol=atol,
        )  # fmt: skip
        return float(found.t[-1] * CLOCK), float(found.y[2, -1] / CLOCK)

    return run


def by_package(own, rtol):
    """The same by `simulate`."""

    def run():
        motion = esc.simulate(own, 1, initial_speed=SPEED, rtol=rtol)
        return float(motion.handoff_times[0]), float(motion.handoff_velocities[0])

    return run


def spent_by(run, count):
    """Processor time of a run [s], the mean of several."""
    start = time.process_time()
    for _ in range(count):
        run()
    return (time.process_time() - start) / count


def error_of(found, exact):
    return max(abs(a / b - 1.0) for a, b in zip(found, exact, strict=True))


def runs_of(own):
    """Name of the solver, tolerance or number of steps, and the run."""
    runs = [("escapement", rtol, by_package(own, rtol)) for rtol in (1e-4, 1e-5, 1e-6, 1e-8, 1e-10)]
    for method, rtols in (("Radau", (1e-5, 1e-6, 1e-7)), ("LSODA", (1e-7, 1e-8, 1e-9))):
        runs += [(method, rtol, by_solve_ivp(own, method, rtol)) for rtol in rtols]
    # with fewer steps the explicit methods are unstable
    for method, counts in (
        ("RK33", (11_000, 12_000, 14_000)),
        ("RK44", (11_000, 12_000, 14_000)),
        ("GeneralizedAlpha", (12_000, 16_000, 20_000)),
    ):
        runs += [
            (f"Exudyn {method}", count, with_exudyn.run(own, SPEED, count, method))
            for count in counts
        ]
    return runs


def main():
    """Print and write one row a run."""
    own = problem()
    exact = by_package(own, 1e-12)()
    finest = with_exudyn.run(own, SPEED, 1_600_000, "RK44")()
    print("Exudyn's finest run differs from ours by", f"{error_of(finest, exact):.1e}")
    runs = runs_of(own)
    errors = [
        error_of(run(), finest if name.startswith("Exudyn") else exact) for name, _, run in runs
    ]
    spent = [
        [spent_by(run, OURS if name == "escapement" else 1) for name, _, run in runs]
        for _ in range(TURNS)
    ]
    medians = 1e3 * np.median(spent, axis=0)
    best = {}
    for i, (name, *_rest) in enumerate(runs):
        if errors[i] < LARGEST and (name not in best or medians[i] < medians[best[name]]):
            best[name] = i
    rows = []
    for i, (name, size, _run) in enumerate(runs):
        ratio = f"{medians[i] / medians[best['escapement']]:.3g}" if best.get(name) == i else ""
        rows.append((name, size, f"{errors[i]:.1e}", f"{medians[i]:.4g}", ratio))
        print(*rows[-1], flush=True)
    head = ["solver", "rtol or steps", "error", "milliseconds", "times ours"]
    write_rows("compliant_peers", rows, head)


if __name__ == "__main__":
    main()
