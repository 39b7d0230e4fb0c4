"""Random cases against independent answers: no wrong number may come with status ok.

    python benchmarks/stress.py bulk|ivp [--cases N] [--seconds S] [--seed 1973]

Two comparisons, over mechanisms of 3 to 1000 slots, external and internal, inertia
ratios of 1e-8 to 1e8, friction from 1e-12 to 0.999999 of the Painleve limit, loads from
none to more than the drive carries, starts at rest and at up to 1000 natural units of
speed, and tolerances of 1e-13 to 1e-3:

    bulk   the `energy` engine against the Taylor integrator of `independent.py`
    ivp    both engines and that integrator, on fewer engagements

What differs by more than ten times the tolerance goes to `judge.py`, 34 digits, which also
says what one rounding in each parameter does to the number; only what exceeds both is
called wrong. Every case runs in a process that is given up after five minutes.

Case number i is the same in every run. Each run goes on where the last one stopped, adds
its counts to results/stress_PART.csv and lists what failed in stress_PART.failures.csv,
until N cases are done (100 000 of bulk, 10 000 of ivp): so it can be run in slices of S
seconds. --again starts from nothing.
"""

import argparse
import csv
import math
import multiprocessing as mp
import sys
import time
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import independent
import judge

import escapement as esc
from escapement.status import Status

ENGAGEMENTS = {"bulk": 4, "ivp": 2}
CASES = {"bulk": 100_000, "ivp": 10_000}
SLICE = 500  # cases between two writes
PATIENCE = 300.0  # seconds of silence, the judge's included, after which a case counts as hung
SLOW = 20.0  # seconds that no single case may take
RESULTS = Path(__file__).resolve().parent / "results"
OUTCOMES = (
    "ok",
    "wrong",
    "not_converged",
    "crash",
    "hang",
    "slow",
    "warned",
    "beyond doubles",
    "undecided",
)


class Problem(NamedTuple):
    """One case in natural units: follower inertia and torque are 1."""

    slots: int
    pins: int
    internal: bool
    rho: float
    mu: float
    load: float
    speed: float
    rtol: float
    share: float  # friction over the Painleve limit

    @property
    def physics(self):
        return self[:7]

    @property
    def model(self):
        wheel = esc.Geneva(slots=self.slots, pins=self.pins, internal=self.internal)
        inertia = esc.Inertia(driver=self.rho, follower=1.0)
        return esc.Escapement(wheel, inertia, 1.0, self.mu, self.load)


def draw(random, smallest_rtol=1e-13):
    """A random case; every corner of the range gets its part."""
    internal = bool(random.random() < 0.15)
    few = random.random() < 0.9
    slots = int(random.integers(3, 41) if few else round(10 ** random.uniform(1.6, 3)))
    most = 1 if internal else 2 * slots // (slots - 2)
    pins = int(random.integers(1, most + 1))
    decades = 3 if random.random() < 0.75 else 8
    rho = 10 ** random.uniform(-decades, decades)
    case = independent.case_of(slots, pins, internal, rho, 0.0, 0.0)
    limit = independent.critical_friction(case)
    kind = random.random()
    if kind < 0.4:
        mu = random.uniform(0.0, 1.0) * limit
    elif kind < 0.65:
        mu = 10 ** random.uniform(-6, 0) * limit
    elif kind < 0.8:
        mu = 10 ** random.uniform(-12, 0)
    elif kind < 0.95:
        mu = (1.0 - 10 ** random.uniform(-6, -1)) * limit
    else:
        mu = 0.0
    mu = min(mu, 0.999999 * limit)
    # a load whose work over a cell is that of the drive
    bearable = (2.0 * case.beta + case.dwell) * slots / (2.0 * math.pi)
    kind = random.random()
    if kind < 0.5:
        load = 0.0
    elif kind < 0.8:
        load = random.uniform(0.0, 1.0) * bearable
    elif kind < 0.9:
        load = 10 ** random.uniform(-6, 0) * bearable
    else:
        load = random.uniform(0.9, 1.3) * bearable
    kind = random.random()
    speed = 0.0 if kind < 0.5 else 10 ** random.uniform(-3 if kind < 0.9 else -8, 3)
    rtol = 10 ** random.uniform(math.log10(smallest_rtol), -3)
    return Problem(slots, pins, internal, rho, mu, load, speed, rtol, mu / limit)


class Numbers(NamedTuple):
    """What is compared: handoffs, then angle and time of a stall; what cannot be is empty."""

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
    """Greatest relative error of the numbers; infinite where they tell another story."""
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
    """Class and error of an answer by the judge."""
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
            return "wrong", error  # the problem is a tame one
        unavoidable = judge.unavoidable(*problem.physics, engagements=engagements, exact=exact)
    except ArithmeticError:
        return "undecided", math.nan
    if unavoidable is None:
        return "beyond doubles", math.nan
    return ("beyond doubles" if error <= 10.0 * (rtol + max(unavoidable)) else "wrong"), error


def compare(problem, engine, rtol, engagements, reference):
    """Class of one answer, its error over the tolerance, and what happened."""
    began = time.perf_counter()
    try:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            found = simulated(problem, engine, rtol, engagements)
    except Exception as problem_found:
        return "crash", math.nan, f"{type(problem_found).__name__}: {problem_found}"
    took = time.perf_counter() - began
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
    began = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            figures = esc.terminal(problem.model, initial_speed=problem.speed, rtol=problem.rtol)
    except Exception as problem_found:
        return "crash", math.nan, f"{type(problem_found).__name__}: {problem_found}"
    took = time.perf_counter() - began
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
    true = math.sqrt(out[5]), math.sqrt(out[6]), math.sqrt(out[1]), out[2]
    names = ("velocity_max", "velocity_min", "handoff_velocity", "period")
    error = max(abs(getattr(figures, n) / x - 1.0) for n, x in zip(names, true, strict=True))
    # how far one rounding in friction alone moves a fixed point that hardly contracts
    noise = 2.0**-52 / max(-math.expm1(out[3]), 1e-300) * out[independent.VARIATION]
    if error <= 10.0 * problem.rtol:
        return "ok", error / problem.rtol, ""
    kind = "beyond doubles" if error <= 10.0 * (problem.rtol + noise) else "wrong"
    return kind, error / problem.rtol, f"contraction {math.exp(out[3])!r}"


def work(part, seed, first, last, pipe):
    """Cases first..last of a part, two messages each: begun, and done with what came out."""
    engagements = ENGAGEMENTS[part]
    warm_up = Problem(4, 4, False, 0.06, 0.35, 0.01, 0.0, 1e-9, 0.86)
    expected(warm_up, 1)
    compare_terminal(warm_up)
    simulated(warm_up, "energy", 1e-9, 1)
    simulated(warm_up, "ivp", 1e-9, 1)
    for index in range(first, last):
        problem = draw(np.random.default_rng([seed, part == "ivp", index]))
        pipe.send((index, problem, None))
        pipe.send((index, problem, case_results(part, problem, engagements)))


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


def run(part, first, last, seed, end, report):
    """Cases first..last of a part until the clock shows `end`; returns the next one's number."""
    context = mp.get_context("spawn")
    index = first
    while index < last and time.perf_counter() < end:
        near, far = context.Pipe(duplex=False)
        worker = context.Process(target=work, args=(part, seed, index, last, far), daemon=True)
        worker.start()
        far.close()
        problem, patience, lost = None, 6 * PATIENCE, ""  # a first case compiles
        while index < last and time.perf_counter() < end:
            if not near.poll(patience):
                lost = "hang"
                break
            try:
                index, problem, rows = near.recv()
            except EOFError:
                lost = "crash"
                break
            patience = PATIENCE
            if rows is not None:
                report(problem, rows)
                index += 1
        worker.terminate()
        worker.join()
        if lost:
            if problem is None or worker.exitcode == 1:
                raise RuntimeError("the comparison itself failed")
            report(problem, [("energy", lost, math.nan, f"exit code {worker.exitcode}")])
            index += 1
    return index


COUNTS = (*OUTCOMES, "error <= 0.1 rtol", "error <= rtol", "error <= 10 rtol")
HEAD = ("engine", "seed", "cases", *COUNTS, "worst ok error / rtol")
FAILED = ("engine", "outcome", "error / rtol", "told", *Problem._fields)


def added(table, results):
    """Counts of a table {engine: row}, with a case's results in them."""
    for engine, kind, error, _told in results:
        row = table.setdefault(engine, dict.fromkeys(("cases", *COUNTS), 0) | {"worst": 0.0})
        row["cases"] += 1
        row[kind] += 1
        if kind == "ok":
            for limit, name in ((0.1, COUNTS[-3]), (1.0, COUNTS[-2]), (10.0, COUNTS[-1])):
                row[name] += error <= limit
            row["worst"] = max(row["worst"], error)


def read(path, seed):
    """Table of earlier runs, and the number of the next case."""
    if not path.exists():
        return {}, 0
    with open(path, newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    if any(int(row["seed"]) != seed for row in rows):
        raise SystemExit(f"{path} is of another seed; add --again to start from nothing")
    table = {
        row["engine"]: {name: int(row[name]) for name in ("cases", *COUNTS)}
        | {"worst": float(row["worst ok error / rtol"])}
        for row in rows
    }
    # every case is in one of these rows
    return table, sum(table[name]["cases"] for name in ("energy", "independent") if name in table)


def write(path, table, seed):
    """Replace the table; each slice is in it whole or not at all."""
    partial = path.with_suffix(".partial")
    with open(partial, "w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(HEAD)
        for engine, row in table.items():
            counts = [row[name] for name in COUNTS]
            writer.writerow([engine, seed, row["cases"], *counts, f"{row['worst']:.3g}"])
    partial.replace(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=CASES)
    parser.add_argument("--cases", type=int, help="cases in all, those of earlier runs included")
    parser.add_argument("--seconds", type=float, default=math.inf, help="length of this slice")
    parser.add_argument("--seed", type=int, default=1973)
    parser.add_argument("--again", action="store_true", help="start from nothing")
    parser.add_argument("--out", type=Path, default=RESULTS)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / f"stress_{options.part}.csv"
    failures = path.with_suffix(".failures.csv")
    if options.again:
        path.unlink(missing_ok=True)
        failures.unlink(missing_ok=True)
    table, first = read(path, options.seed)
    last = CASES[options.part] if options.cases is None else options.cases
    end = time.perf_counter() + options.seconds
    while first < last and time.perf_counter() < end:
        lines = []

        def report(problem, results, lines=lines):
            added(table, results)
            for engine, kind, error, told in results:
                if kind not in ("ok", "beyond doubles"):
                    lines.append([engine, kind, f"{error:.3g}", told, *problem])

        until = min(first + SLICE, last)
        first = run(options.part, first, until, options.seed, end, report)
        write(path, table, options.seed)
        fresh = not failures.exists()
        with open(failures, "a", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerows([FAILED, *lines] if fresh else lines)
        wrong = {engine: row["cases"] - row["ok"] for engine, row in table.items()}
        print(f"{first} of {last} cases, not ok: {wrong}", flush=True)


if __name__ == "__main__":
    main()
