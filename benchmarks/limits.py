"""How far the engine `energy` is from a general solver, and from its own limit.

    python benchmarks/limits.py

The problem is the first one of `escapement bench`: twenty engagements, each of three smooth pieces.
`solve_ivp` solves it in time. The last row is no solver: it is the arithmetic that remains at the
points of `energy` if the geometry and the solution of the linear equation are tabulated. Runs
alternate; times are the least processor times.
"""

import math
import time
from functools import partial

import numba
import numpy as np
from common import write_rows
from scipy.integrate import solve_ivp

from escapement.benchmark.problems import PROBLEMS, derivative, pieces_of, reversal
from escapement.engines.simulate import simulate

PROBLEM, ERROR = PROBLEMS[0], 1e-10
_, RHO, _, _ = PROBLEM.numbers
ROUNDS, SHORT = 7, 0.02
"""Rounds of all runs, and the time for which a short run is repeated in each [s]."""
PANELS = 10
"""Panels into which `energy` divides an engagement of this problem, counted in its memory."""


class Count:
    """Evaluations of the equation of motion."""

    points = 0


def in_time(method, rtol, count):
    """Handoffs from `solve_ivp`, by the equation of motion in time."""
    now, theta, speed, answer = 0.0, 0.0, 0.0, []
    for _ in range(PROBLEM.engagements):
        for numbers, start, end in pieces_of(PROBLEM):

            def event(t, y, *own, end=end):
                return reversal(t, y, *own) if end is None else y[0] - end

            event.terminal, event.direction = True, -1.0 if end is None else 1.0
            solved = solve_ivp(
                derivative, (now, math.inf), (theta if start is None else start, speed),
                method=method, rtol=rtol, atol=rtol, events=event, args=numbers,
            )  # fmt: skip
            count.points += solved.nfev
            now, (theta, speed) = solved.t_events[0][0], solved.y_events[0][0]
        answer.append((now, speed))
    return np.array(answer).T


@numba.njit(error_model="numpy", fastmath=True)
def arithmetic(alpha, beta, inverse, dg, g, width, rounds):
    """What is left to compute at tabulated points: speeds, contact forces and times."""
    energy, now, least = 1.0, 0.0, 1.0
    for _ in range(rounds):
        for k in range(alpha.size):
            w = (alpha[k] * energy + beta[k]) * inverse[k]
            least = min(least, RHO * dg[k] * w + g[k])
            now += width[k] / math.sqrt(w)
        energy = alpha[-1] * energy + beta[-1]
    return now, energy, least


def spent(run):
    """Processor time of a run, repeated if it is short."""
    began, runs = time.process_time(), 0
    while runs == 0 or time.process_time() - began < SHORT:
        run()
        runs += 1
    return (time.process_time() - began) / runs


def fastest():
    """The fastest run of `solve_ivp` within `ERROR`: its evaluations, error, method, the run."""
    found = []
    for method in ("RK45", "DOP853", "LSODA"):
        for power in range(-13, -6):
            count = Count()
            answer = in_time(method, 10.0**power, count)
            error = PROBLEM.error(answer[0] * PROBLEM.clock, answer[1] / PROBLEM.clock)
            if error <= ERROR:
                run = partial(in_time, method, 10.0**power, Count())
                found.append((min(spent(run) for _ in range(2)), count.points, error, method, run))
    return min(found, key=lambda one: one[0])[1:]


def motions():
    """Rows of one motion."""
    points, error, method, run = fastest()
    rows = [(f"solve_ivp in time, {method}", points, error, run)]
    run = partial(simulate, PROBLEM.escapement, PROBLEM.engagements)
    motion, points = run(), 16 * PANELS * PROBLEM.engagements
    error = PROBLEM.error(motion.handoff_times, motion.handoff_velocities)
    rows.append(("energy", points, error, run))
    numbers = 0.5 + np.random.default_rng(1).random((6, 16 * PANELS))
    floor = partial(arithmetic, *numbers, PROBLEM.engagements)
    floor()
    rows.append(("arithmetic at its points", points, math.nan, floor))
    times = np.min([[spent(run) for *_, run in rows] for _ in range(ROUNDS)], axis=0)
    return [
        (name, points, f"{error:.1e}", f"{1e6 * took:.4g}", f"{took / times[1]:.3g}")
        for (name, points, error, _), took in zip(rows, times, strict=True)
    ]


def main():
    write_rows("limits", motions(), ("solver", "points", "error", "microseconds", "ratio"))


if __name__ == "__main__":
    main()
