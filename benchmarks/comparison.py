"""Compares a result of the package with `independent`, and where they differ with `judge`."""

import math
import os
import time
import warnings
from pathlib import Path
from typing import NamedTuple

import independent
import judge
import numpy as np

# the limit below is part of compiled code, which therefore has a cache of its own
os.environ["NUMBA_CACHE_DIR"] = str(Path(__file__).resolve().parent / "__pycache__")

import escapement as esc
import escapement.dynamics.figures_of_merit
from escapement.base.status import Status

FOLLOWED = 10_000
"""Most engagements that are followed until a motion settles, a hundredth of what users get; all of
them would take hours, and rise and settling times are not compared. A motion that stops later
counts as not converged."""
escapement.dynamics.figures_of_merit.MAX_ENGAGEMENTS = FOLLOWED

ENGAGEMENTS = {"bulk": 4, "ivp": 2}
SLOW = 20.0  # greatest processor time of a case [s]
OUTCOMES = (
    *("ok", "wrong", "not_converged", "crash", "slow", "warned", "beyond doubles"),
    "undecided",
)


class Numbers(NamedTuple):
    """Numbers that are compared: handoffs, and angle and time of a stall; absent ones are empty."""

    status: int
    times: np.ndarray
    speeds: np.ndarray
    reversals: list
    stall: tuple


def expected(problem, engagements):
    case = independent.case_of(*problem.physics[:6])
    rows = np.empty((engagements, independent.ROW))
    status, done = independent.motion(case, problem.speed**2, rows)
    stall = (rows[done, 1], rows[done, 2]) if status == independent.STALL else ()
    turned = [int(row[7]) for row in rows[:done]]
    return Numbers(status, rows[:done, 2], np.sqrt(rows[:done, 1]), turned, stall)


def simulated(problem, engine, rtol, engagements):
    motion = esc.simulate(
        problem.model, engagements, engine=engine, initial_speed=problem.speed, rtol=rtol
    )
    done = motion.handoff_times.size
    turned = [int(np.sum(motion.reversals.engagement == k)) for k in range(done)]
    stall = ()
    if motion.status.label == "stall":
        wheel = problem.model.mechanism
        at = wheel.breaks[0]
        if motion.end_time > 0.0:
            at = motion.at(motion.end_time).theta - done * wheel.cell_angle
        stall = (float(at), float(motion.end_time))
    times, speeds = motion.handoff_times, motion.handoff_velocities
    return Numbers(int(motion.status), times, speeds, turned, stall)


def distance(found, reference):
    """Greatest relative error of the numbers; infinite where the course of the motion differs."""
    if found.status != reference.status or found.times.size != reference.times.size:
        return math.inf
    errors = [0.0]
    for x, y in ((found.times, reference.times), (found.speeds, reference.speeds)):
        errors += list(np.abs(x / y - 1.0))
    if found.stall:
        (angle, end), (true_angle, true_end) = found.stall, reference.stall
        errors += [abs(angle - true_angle), abs(end / true_end - 1.0) if true_end else abs(end)]
    worst = max(errors)
    return worst if worst == worst else math.inf


def verdict(problem, found, reference, engagements, rtol):
    """Class and error of a result, as the judge decides."""
    try:
        exact = judge.answer(*problem.physics, engagements=engagements)
        truth = Numbers(
            independent.STALL if exact.stall else independent.OK,
            np.array([float(t) for t in exact.times]),
            np.array([math.sqrt(w) for w in exact.squares]),
            exact.reversals,
            tuple(float(x) for x in exact.stall) if exact.stall else (),
        )
        error = distance(found, truth)
        if error <= 10.0 * rtol:
            return "ok", error
        if error > 1e-3 and distance(reference, truth) < 1e-10:
            return "wrong", error  # the problem is well-conditioned
        unavoidable = judge.unavoidable(*problem.physics, engagements=engagements, exact=exact)
    except ArithmeticError:
        return "undecided", math.nan
    if unavoidable is None:
        return "beyond doubles", math.nan
    return ("beyond doubles" if error <= 10.0 * (rtol + max(unavoidable)) else "wrong"), error


def compare(problem, engine, rtol, engagements, reference):
    """Class of one result, its error over the tolerance, and a remark."""
    began = time.process_time()
    try:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            found = simulated(problem, engine, rtol, engagements)
    except Exception as problem_found:
        return "crash", math.nan, f"{type(problem_found).__name__}: {problem_found}"
    took = time.process_time() - began
    if took > SLOW:
        return "slow", math.nan, f"{took:.1f} s"
    if found.status == int(Status.NOT_CONVERGED):
        return "not_converged", math.nan, ""
    error = distance(found, reference)
    kind, told = "ok", ""
    if not error <= 10.0 * rtol:
        kind, error = verdict(problem, found, reference, engagements, rtol)
        told = f"status {found.status}, independent {reference.status}"
    elif found.reversals != reference.reversals:
        told = f"reversals {found.reversals}, independent {reference.reversals}"
        exact = judge.answer(*problem.physics, engagements=engagements)
        kind = "ok" if found.reversals == exact.reversals else "wrong"
    if kind == "ok" and said:
        kind, told = "warned", f"{said[0].category.__name__}: {said[0].message}"
    return kind, error / rtol, told


def compare_terminal(problem):
    """Class and error over the tolerance of the terminal cycle of `energy`."""
    out = np.empty(independent.ROW)
    case = independent.case_of(*problem.physics[:6])
    status = independent.terminal(case, problem.speed**2, out)
    began = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            figures = esc.terminal(problem.model, initial_speed=problem.speed, rtol=problem.rtol)
    except Exception as problem_found:
        return "crash", math.nan, f"{type(problem_found).__name__}: {problem_found}"
    took = time.process_time() - began
    if figures.status.label == "not_converged":
        return "not_converged", math.nan, f"{took:.1f} s, independent {status}"
    if took > SLOW:
        return "slow", math.nan, f"{took:.1f} s"
    if status == independent.LOST:
        return "undecided", math.nan, ""
    if int(figures.status) != status:
        return "wrong", math.inf, f"status {int(figures.status)}, independent {status}"
    if status != independent.OK:
        return "ok", 0.0, ""
    cycle = math.sqrt(out[5]), math.sqrt(out[6]), math.sqrt(out[1]), out[2]
    error = _apart(figures, cycle)
    if error <= 10.0 * problem.rtol:
        return "ok", error / problem.rtol, ""
    # change of the terminal speed by one rounding of friction, large where it hardly contracts
    noise = 2.0**-52 / max(-math.expm1(out[3]), 1e-300) * out[independent.VARIATION]
    if error <= 10.0 * (problem.rtol + noise):
        kind = "beyond doubles"
    else:
        try:
            error = _apart(figures, judge.cycle(*problem.physics[:6], figures.handoff_velocity))
        except ArithmeticError:
            return "undecided", math.nan, ""
        kind = "ok" if error <= 10.0 * problem.rtol else "wrong"
    return kind, error / problem.rtol, f"contraction {math.exp(out[3])!r}"


def _apart(figures, cycle):
    """Greatest relative error of a terminal cycle's numbers."""
    names = ("velocity_max", "velocity_min", "handoff_velocity", "period")
    return max(abs(getattr(figures, n) / x - 1.0) for n, x in zip(names, cycle, strict=True))


def case_results(part, problem, engagements):
    """Rows of (what, outcome, error over tolerance, remark) of one case."""
    reference = expected(problem, engagements)
    if reference.status == independent.LOST:
        return [("independent", "undecided", math.nan, "")]
    rows = [("energy", *compare(problem, "energy", problem.rtol, engagements, reference))]
    if part == "bulk" and problem.mu > 0.0:
        rows.append(("energy terminal", *compare_terminal(problem)))
    if part == "ivp":
        rtol = max(problem.rtol, 1e-12)  # solve_ivp clips smaller local tolerances
        rows.append(("ivp", *compare(problem, "ivp", rtol, engagements, reference)))
    return rows
