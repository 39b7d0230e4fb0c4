"""What the formulation gains, what compiled code gains, and how far the rest is from its limits.

    python benchmarks/limits.py

The problem is the first one of `escapement bench`: twenty engagements, each of three smooth pieces.
It is solved in time by `solve_ivp`, and with the squared speed over the driver angle by
`solve_ivp`, by NumPy at Gauss points, and by the engine `energy`. The last row is no solver: it is
the arithmetic that remains at the points of `energy` if the geometry and the solution of the linear
equation are tabulated. Runs alternate; times are the least processor times.
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
CENTRE, RHO, _, _ = PROBLEM.numbers
ROUNDS, SHORT = 7, 0.02
"""Rounds of all runs, and the time for which a short run is repeated in each [s]."""
PANELS = 10
"""Panels into which `energy` divides an engagement of this problem, counted in its memory."""


def geometry(theta):
    """g, u and g' of the wheel; NumPy's functions take floats and arrays."""
    length = CENTRE**2 + 1.0 - 2.0 * CENTRE * np.cos(theta)
    g, u = (CENTRE * np.cos(theta) - 1.0) / length, CENTRE * np.sin(theta) / length
    return g, u, -(1.0 + 2.0 * g) * u


def law(theta, kappa):
    """Factor B of w, and A, in dw/dtheta = A - B w."""
    g, u, dg = geometry(theta)
    p = g + kappa * u
    return 2.0 * p * dg / (RHO + g * p), 2.0 / (RHO + g * p)


def contact(theta, w):
    """A number of the sign of the contact force of the front wall."""
    g, _u, dg = geometry(theta)
    return RHO * dg * w + g


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


def over_angle(method, rtol, count):
    """Handoffs from `solve_ivp`, by the linear equation of w over the angle."""
    now, w, theta, answer = 0.0, 0.0, 0.0, []
    for _ in range(PROBLEM.engagements):
        for (_a, _rho, kappa), start, end in pieces_of(PROBLEM):
            left = theta if start is None else start
            rest = w == 0.0  # then the speed over the root x of the angle, which is smooth

            def slope(x, y, kappa=kappa, left=left, rest=rest):
                b, a = law(left + x * x if rest else x, kappa)
                if not rest:
                    return a - b * y[0], 1.0 / math.sqrt(y[0])
                if x == 0.0:
                    return math.sqrt(a), 2.0 / math.sqrt(a)
                return x * (a - b * y[0] ** 2) / y[0], 2.0 * x / y[0]

            def turns(x, y):
                return contact(x, y[0])

            turns.terminal, turns.direction = True, -1.0
            last = PROBLEM.numbers[3] if end is None else end
            span = (0.0, math.sqrt(last - left)) if rest else (left, last)
            solved = solve_ivp(
                slope, span, (w, now), method=method, rtol=rtol, atol=rtol,
                events=turns if end is None else None,
            )  # fmt: skip
            count.points += solved.nfev
            theta = solved.t[-1]
            w, now = solved.y[:, -1]
            w = w * w if rest else w
            if end is None:
                theta, (w, now) = solved.t_events[0][0], solved.y_events[0][0]
        answer.append((now, math.sqrt(w)))
    return np.array(answer).T


class Gauss:
    """Handoffs from NumPy: the solution of the linear equation at Gauss points."""

    def __init__(self, points):
        self.x, self.weights = np.polynomial.legendre.leggauss(points)
        basis = np.linalg.inv(np.polynomial.legendre.legvander(self.x, points - 1))
        whole = np.polynomial.legendre.legint(np.eye(points), lbnd=-1.0)
        self.cumulate = np.polynomial.legendre.legval(self.x, whole).T @ basis

    def piece(self, left, right, w, kappa, count):
        """Squared speed at the right end, and the time."""
        count.points += self.x.size
        x = 0.5 * (1.0 + self.x)
        theta, change = left + (right - left) * x, 0.5 * (right - left)
        if w == 0.0:
            theta, change = left + (right - left) * x * x, (right - left) * x
        b, a = law(theta, kappa)
        decay = np.exp(self.cumulate @ (change * b))
        inside = (w + self.cumulate @ (change * a * decay)) / decay
        gained = w + self.weights @ (change * a * decay)
        return gained * math.exp(-self.weights @ (change * b)), self.weights @ (
            change / np.sqrt(inside)
        )

    def __call__(self, count):
        _a, _rho, mu, end = PROBLEM.numbers
        now, w, turn, answer = 0.0, 0.0, 0.5 * end, []
        for _ in range(PROBLEM.engagements):
            w, first = self.piece(-end, 0.0, w, -mu, count)
            before, at = 0.9 * turn, self.piece(0.0, 0.9 * turn, w, mu, count)
            old = contact(before, at[0])
            while abs(turn - before) > 1e-13:
                at = self.piece(0.0, turn, w, mu, count)
                new = contact(turn, at[0])
                before, turn, old = turn, turn - new * (turn - before) / (new - old), new
            w, last = self.piece(turn, end, at[0], -mu, count)
            now += first + at[1] + last
            answer.append((now, math.sqrt(w)))
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


def fastest(solve):
    """The fastest run within `ERROR`: its evaluations, error and method, and the run itself."""
    found = []
    for method in ("RK45", "DOP853", "LSODA"):
        for power in range(-13, -6):
            count = Count()
            answer = solve(method, 10.0**power, count)
            error = PROBLEM.error(answer[0] * PROBLEM.clock, answer[1] / PROBLEM.clock)
            if error <= ERROR:
                run = partial(solve, method, 10.0**power)
                took = min(spent(partial(run, Count())) for _ in range(2))
                found.append((took, count.points, error, method, run))
    return min(found, key=lambda one: one[0])[1:]


def motions():
    """Rows of one motion."""
    rows = []
    for name, solve in (("solve_ivp in time", in_time), ("solve_ivp over the angle", over_angle)):
        points, error, method, run = fastest(solve)
        rows.append((f"{name}, {method}", points, error, partial(run, Count())))
    for size in range(8, 65, 4):
        gauss, count = Gauss(size), Count()
        answer = gauss(count)
        error = PROBLEM.error(answer[0] * PROBLEM.clock, answer[1] / PROBLEM.clock)
        if error <= ERROR:
            break
    rows.append(("NumPy over the angle", count.points, error, partial(gauss, Count())))
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
        (name, points, f"{error:.1e}", f"{1e6 * took:.4g}", f"{took / times[3]:.3g}")
        for (name, points, error, _), took in zip(rows, times, strict=True)
    ]


def main():
    write_rows("limits", motions(), ("solver", "points", "error", "microseconds", "ratio"))


if __name__ == "__main__":
    main()
