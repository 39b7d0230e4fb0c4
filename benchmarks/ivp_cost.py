"""Time of engine `ivp`, compared with the loop over solve_ivp that a user would write.

``python benchmarks/ivp_cost.py [--rounds 7]``

The loop integrates driver angle and speed over one smooth piece after the other, with DOP853 and
the same compiled right-hand side that `ivp` uses. A terminal event ends a piece at a fixed angle,
such as dead centre, or at a pin reversal, and an event on the acceleration locates the extrema of
the speed. Unlike `ivp`, the loop does not integrate losses, keeps no interpolant, and misses two
events within one step.

Both run at rtol 1e-4 to 1e-11. The error is the greatest relative one of handoff times and speeds
against `energy` at 1e-13. Times are processor times, the shortest of several rounds in which the
two alternate. They are compared at equal errors, by interpolation.
"""

import argparse
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import escapement as esc
from escapement.base.text import print_columns
from escapement.benchmark import shortest, write_csv
from escapement.dynamics.law import (
    bent_pose,
    contact,
    net_torque,
    reduced_inertia,
    root_of,
    scene_of,
)
from escapement.engines.ivp.law import side_from, slope
from escapement.model.scene import scene_tuple
from escapement.numerics.jit import jit

RESULTS = Path(__file__).resolve().parent / "results"
TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
COMPARED = (1e-6, 1e-8, 1e-10)
ENGAGEMENTS = 10
METER = {"crank_radius": 0.01}


def cases():
    """The ideal four-pin wheel, one with a dwell, and one with every effect of real parts."""
    inertia, torque = esc.Inertia(3.389e-7, 5.649e-6), 0.0113
    yield "ideal, four pins", esc.Escapement(esc.Geneva(4), inertia, torque, 0.35)
    yield "with a dwell", esc.Escapement(esc.Geneva(6, pins=2), inertia, torque, 0.2)
    wheel = esc.Geneva(4, pin_radius=4e-4, roller_radius=1e-3, **METER)
    effects = {
        "load_torque": 0.001,
        "driver_bearing_friction": 0.1,
        "driver_bearing_radius": 0.001,
        "driver_bearing_torque": 0.0005,
        "follower_bearing_friction": 0.1,
        "follower_bearing_radius": 0.0005,
        "driver_drag": 1e-8,
        "follower_drag": 1e-8,
        "driver_viscous": 5e-6,
        "follower_viscous": 5e-6,
    }
    yield "every effect", esc.Escapement(wheel, inertia, torque, 0.2, **effects)


class Line(NamedTuple):
    """One case at one measured error [-]: times of both [s], and their ratio."""

    case: str
    error: float
    loop: float
    ivp: float
    ratio: float


class Run(NamedTuple):
    """One of the two on one case at one tolerance: its error [-] and time [s]."""

    case: str
    program: str
    rtol: float
    error: float
    time: float


@jit(allocates=True)
def force_at(theta, speed, plain):
    """A number with the sign of the contact force."""
    scene, w = scene_of(plain), speed * speed
    g, _c, k = bent_pose(theta, 1.0, scene)
    return contact(g, k, 1.0 - scene.bearing, w, root_of(w, scene), scene)


@jit(allocates=True)
def acceleration_at(theta, speed, side, plain):
    """Driver acceleration in natural units."""
    scene, w = scene_of(plain), speed * speed
    g, c, k = bent_pose(theta, side, scene)
    torque = net_torque(g, c, k, 1.0 - scene.bearing, w, root_of(w, scene), scene)
    return torque / reduced_inertia(g, c, scene)


def plain_loop(escapement, rtol):
    """Handoff times [s] and speeds [rad/s] from the plain loop over solve_ivp."""
    scene, clock = escapement.scene, escapement.time_unit
    plain, none = scene_tuple(scene), np.empty(0, dtype=np.int64)
    corners = [(float(angle), False) for angle in scene.edges[1:]]
    if scene.dwell:
        corners.append((float(scene.edges[-1] + scene.dwell), True))

    def piece(x, theta, speed, side, end):
        def arrive(x, y, *_):
            return y[0] - end

        def reverse(x, y, *_):
            return force_at(y[0], y[1], plain)

        def extreme(x, y, *_):
            return acceleration_at(y[0], y[1], side, plain)

        arrive.terminal = reverse.terminal = True
        arrive.direction, reverse.direction = 1.0, -side
        events = (arrive, extreme, reverse) if side else (arrive, extreme)
        solved = solve_ivp(
            slope, (x, np.inf), (theta, speed), "DOP853", events=events, rtol=rtol,
            atol=1e-2 * rtol, args=(0.0, 1.0, side, 0.0, 0.0, none, plain),
        )  # fmt: skip
        if solved.status != 1:
            raise ArithmeticError(solved.message)
        return solved.t[-1], *solved.y[:, -1], solved.t_events[0].size > 0

    x, speed, rows = 0.0, 0.0, []
    for _ in range(ENGAGEMENTS):
        theta = float(scene.edges[0])
        for end, locked in corners:
            side = 0.0 if locked else float(side_from(theta, speed**2, plain))
            arrived = False
            while not arrived:
                x, theta, speed, arrived = piece(x, theta, speed, side, end)
                side = -side
            theta = end
        rows.append((x * clock, speed / clock))
    times, speeds = np.array(rows).T
    return times, speeds


def by_ivp(escapement, rtol):
    """The same from the engine, called as a user calls it."""
    motion = esc.simulate(escapement, ENGAGEMENTS, engine="ivp", rtol=rtol)
    return motion.handoff_times, motion.handoff_velocities


PROGRAMS = {"loop": plain_loop, "ivp": by_ivp}


def measure(case, escapement, rounds):
    """Errors and times of both programs over all tolerances."""
    truth = esc.simulate(escapement, ENGAGEMENTS, rtol=1e-13)
    exact = np.array([truth.handoff_times, truth.handoff_velocities])
    calls = [
        (name, rtol, partial(call, escapement, rtol))
        for rtol in TOLERANCES
        for name, call in PROGRAMS.items()
    ]
    errors = [float(np.abs(np.array(call()) / exact - 1.0).max()) for _, _, call in calls]
    times = shortest([call for *_, call in calls], rounds)
    return [
        Run(case, name, rtol, error, time)
        for (name, rtol, _), error, time in zip(calls, errors, times, strict=True)
    ]


def time_at(runs, error):
    """Time at an error, from a straight line through log time against log error."""
    # an error that is by chance below the level of rounding would bend the line
    kept = [run for run in runs if run.error > 1e-14]
    slope_, at_one = np.polyfit(
        np.log([run.error for run in kept]), np.log([run.time for run in kept]), 1
    )
    return float(np.exp(at_one + slope_ * np.log(error)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7, help="rounds of which the shortest counts")
    rounds = parser.parse_args().rounds
    runs, lines = [], []
    for case, escapement in cases():
        here = measure(case, escapement, rounds)
        runs += here
        for error in COMPARED:
            both = [time_at([r for r in here if r.program == name], error) for name in PROGRAMS]
            lines.append(Line(case, error, *both, both[1] / both[0]))
    print_columns([Run._fields], runs)
    print_columns([Line._fields], lines)
    write_csv(RESULTS / "ivp_cost.csv", lines)
    write_csv(RESULTS / "ivp_cost_runs.csv", runs)


if __name__ == "__main__":
    main()
