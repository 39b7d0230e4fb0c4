"""The measured error against the tolerance, and errors at the limits of the model.

    python benchmarks/tolerance.py [--cases 1000] [--only NAME ...]

Three studies compare the engines with the Taylor integrator of `independent`. Each writes a CSV
file to benchmarks/results; `figures.py` draws them:

    tolerance     error of random cases over the tolerance, both engines
    painleve      error and run time as friction approaches the Painleve limit
    long_run      drift of time and energy over a million engagements
"""

import argparse
import math
import time

import independent
import judge
import numpy as np
from common import write_rows
from random_cases import Problem, draw

import escapement as esc
from escapement.base.text import print_columns
from escapement.dynamics.painleve import critical_friction

SEED = 1954
ENGAGEMENTS = 3


def write(name, head, rows):
    write_rows(name, rows, head)
    print_columns([head], rows)


def exact(case, w, engagements=ENGAGEMENTS):
    """Handoff times and speeds, or None for a case that stops."""
    rows = np.empty((engagements, independent.ROW))
    status, _done = independent.motion(case, w, rows)
    return np.concatenate([rows[:, 2], np.sqrt(rows[:, 1])]) if status == independent.OK else None


def error_of(problem, engine, rtol, truth, **more):
    """Greatest relative error of handoff times and speeds; infinite if there are none."""
    motion = esc.simulate(
        problem.model,
        ENGAGEMENTS,
        engine=engine,
        rtol=rtol,
        initial_speed=problem.speed,
        **more,
    )
    found = np.concatenate([motion.handoff_times, motion.handoff_velocities])
    return float(np.abs(found / truth - 1.0).max()) if found.size == truth.size else math.inf


def study_tolerance(options):
    """Share of random cases whose error is at most ten times the tolerance.

    If an error is larger than the tolerance, `judge.py` decides with 34 digits, because the
    independent integrator works in double precision and has errors of its own.
    """
    head = ["engine", "rtol", "cases", "median", "q95", "worst", "worst / rtol", "share <= 10 rtol"]
    head += ["ms a case", *Problem._fields[:7]]
    rows, count = [], options.cases
    for engine, lowest in (("energy", 13), ("ivp", 12)):
        random = np.random.default_rng(SEED)
        problems = []
        while len(problems) < count:
            problem = draw(random)
            truth = exact(independent.case_of(*problem.physics[:6]), problem.speed**2)
            if truth is not None:
                problems.append([problem, truth])
        judged = set()
        for power in range(3, lowest + 1):
            rtol = 10.0**-power
            began = time.process_time()
            errors = np.array([error_of(p, engine, rtol, truth) for p, truth in problems])
            spent = (time.process_time() - began) / count
            for i in np.nonzero(errors > rtol)[0]:
                if i not in judged:
                    judged.add(i)
                    numbers = judge.answer(*problems[i][0].physics, ENGAGEMENTS).numbers()
                    problems[i][1] = np.array([float(number) for number in numbers])
                errors[i] = error_of(problems[i][0], engine, rtol, problems[i][1])
            errors = np.maximum(errors, 1e-17)
            worst = int(errors.argmax())
            middle, most = np.quantile(errors, [0.5, 0.95])
            share = float(np.mean(errors <= 10.0 * rtol))
            rest = [float(errors[worst] / rtol), share, spent * 1e3, *problems[worst][0].physics]
            rows.append(
                [engine, rtol, count, float(middle), float(most), float(errors[worst]), *rest]
            )
    write("tolerance", head, rows)


def study_painleve(_options):
    """Error and run time against the distance to the limit."""
    rows = []
    for slots, rho in ((4, 0.06), (3, 0.6), (6, 0.075)):
        wheel, inertia = esc.Geneva(slots), esc.Inertia(rho, 1.0)
        limit = critical_friction(wheel, inertia)
        for power in np.arange(1.0, 7.01, 0.5):
            gap = 10.0**-power
            mu = (1.0 - gap) * limit
            problem = Problem(slots, wheel.pins, False, rho, mu, 0.0, 0.0, 1e-12, 1.0 - gap)
            truth = exact(independent.case_of(*problem.physics[:6]), 0.0)
            for engine, rtol in (("energy", 1e-12), ("ivp", 1e-10)):
                error = error_of(problem, engine, rtol, truth)
                spent = math.inf  # the shortest of several, because the machine may be busy
                for _ in range(20 if engine == "energy" else 3):
                    began = time.process_time()
                    error_of(problem, engine, rtol, truth)
                    spent = min(spent, (time.process_time() - began) * 1e3)
                rows.append([slots, rho, gap, engine, rtol, error, spent])
    write("painleve", ["slots", "rho", "1 - mu/mu_c", "engine", "rtol", "error", "ms"], rows)


@independent.compiled
def _followed(case, known, times, squares):
    """Handoff times and squared speeds, from compensated sums; speeds from `known` if given."""
    work, turns = np.empty((24, independent.SIZE)), np.empty(16)
    row = np.empty(independent.ROW)
    time, time_lost, w, w_lost = 0.0, 0.0, 0.0, 0.0
    for k in range(times.size):
        independent.engage(case, w, work, turns, row)
        y = row[2] - time_lost
        t = time + y
        time_lost = (t - time) - y
        time = times[k] = t
        if known.size:
            w = known[k]
        else:
            y = row[4] / case[4] + w * math.expm1(row[3]) - w_lost
            t = w + y
            w_lost = (t - w) - y
            w = t
        squares[k] = w


def study_long_run(_options):
    """Drift without friction, where the speeds have a formula, and with very little friction."""
    count, rows = 1_000_000, []
    for mu in (0.0, 1e-6):
        case = independent.case_of(4, 4, False, 1.0, mu, 0.0)
        model = Problem(4, 4, False, 1.0, mu, 0.0, 0.0, 1e-12, 0.0).model
        began = time.perf_counter()
        motion = esc.simulate(model, count, rtol=1e-12)
        spent = time.perf_counter() - began
        # without friction w = 2 torque angle / driver inertia
        known = np.arange(1, count + 1) * math.pi if mu == 0.0 else np.empty(0)
        times, squares = np.empty(count), np.empty(count)
        _followed(case, known, times, squares)
        drift = np.abs(motion.handoff_times / times - 1.0)
        energy = np.abs(motion.handoff_velocities**2 / squares - 1.0)
        for k in np.unique(np.geomspace(1, count, 19).astype(int)):
            rows.append([mu, int(k), float(drift[k - 1]), float(energy[k - 1]), spent])
    write("long_run", ["friction", "engagements", "time drift", "energy drift", "s in all"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=1000, help="of the tolerance study")
    names = ("tolerance", "painleve", "long_run")
    parser.add_argument("--only", nargs="+", choices=names, default=names)
    options = parser.parse_args()
    for name in options.only:
        globals()[f"study_{name}"](options)


if __name__ == "__main__":
    main()
