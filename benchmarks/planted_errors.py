"""How often readings with an error are called good, and readings without one are not.

``python benchmarks/planted_errors.py [--seeds 600]``

The readings are made here and not by the package: a Geneva wheel in closed form, independent noise
of both encoders, rounding to counts, any start and sense of turning. One set has no error, in the
other each set has one: an eccentric disc, a slot, a lost step, one reading far out, or another
mechanism. The size of an error is 5 to 50 times the standard error with which its own least-squares
fit finds it (the logarithm is uniform); both shafts move through two cells or more. The noise is at
least a third of the output's count, so that rounding is noise too; rows "coarse" have less of it.
"""

import argparse
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

import escapement as esc
from escapement.base.text import print_columns
from escapement.benchmark import write_csv

ROOT = Path(__file__).resolve().parents[1]
DEG, TURN = np.pi / 180.0, 2.0 * np.pi
KINDS = ("eccentric", "slot", "lost step", "far out", "other mechanism")
LEAST, MOST = 5.0, 50.0
LARGEST = 0.2  # share of a step; greater errors need no statistics


class Row(NamedTuple):
    """Verdicts on readings of one kind; `times` is the size of errors in standard errors."""

    error: str
    times: str
    sets: int
    good: int
    cannot_say: int
    not_good: int


class Drive(NamedTuple):
    """A Geneva wheel."""

    slots: int
    pins: int
    internal: bool

    def position(self, theta: np.ndarray) -> np.ndarray:
        """Follower angle over any number of cells; it is locked in the dwell."""
        cell, reach = (
            TURN / self.pins,
            np.pi / 2.0 + (1 if self.internal else -1) * np.pi / self.slots,
        )
        start = -reach
        number = np.floor((theta - start) / cell)
        local = np.minimum(theta - number * cell, reach)
        distance = 1.0 / np.sin(np.pi / self.slots)
        along = distance + np.cos(local) if self.internal else distance - np.cos(local)
        return np.arctan2(np.sin(local), along) + number * TURN / self.slots

    def engaged(self, theta: np.ndarray) -> np.ndarray:
        """Number of the slot that a pin is in, or was in last."""
        reach = np.pi / 2.0 + (1 if self.internal else -1) * np.pi / self.slots
        return np.floor((theta + reach) / (TURN / self.pins)) % self.slots

    def slope(self, theta: np.ndarray) -> np.ndarray:
        """Transmission by central differences."""
        return (self.position(theta + 1e-6) - self.position(theta - 1e-6)) / 2e-6


class Case(NamedTuple):
    """A drive, the angles at which it was read, and its encoders."""

    drive: Drive
    theta: np.ndarray
    noise: float
    input_noise: float
    steps: tuple[float, float]

    def deviation(self, slope: np.ndarray) -> np.ndarray:
        """Standard deviation of the error of each sample, rounding included."""
        of_output = self.noise**2 + self.steps[1] ** 2 / 12.0
        return np.sqrt(of_output + slope**2 * (self.input_noise**2 + self.steps[0] ** 2 / 12.0))


def case_of(random: np.random.Generator, coarse: bool) -> Case:
    """A drive and how it is read, at random."""
    slots = int(random.integers(3, 9))
    internal = bool(random.random() < 0.15)
    pins = 1 if internal else int(random.choice([1, 1, 2, 4] if slots == 4 else [1, 1, 2]))
    rows, cells = int(10.0 ** random.uniform(2.0, 3.3)), 10.0 ** random.uniform(np.log10(2.05), 1.5)
    even = np.arange(rows) / (rows - 1)
    uneven = np.sort(np.concatenate([[0.0, 1.0], random.random(rows - 2)]))
    share = even if random.random() < 0.5 else uneven
    travel = cells * TURN / pins * random.choice([-1.0, 1.0])
    theta = random.uniform(0.0, TURN) + travel * share
    noise = 10.0 ** random.uniform(-1.7, -0.4) * DEG
    input_noise = noise * random.choice([0.0, 0.0, 0.5, 1.0])
    counts = [0, *(2 ** np.arange(11, 17)), 6400, 2400]
    steps = [TURN / n if n else 0.0 for n in random.choice(counts, 2)]
    if coarse:
        steps[1] = noise * random.uniform(4.0, 10.0)
        steps[1] = TURN / round(TURN / steps[1])
    noise = noise if coarse else max(noise, steps[1] / 3.0)
    return Case(Drive(slots, pins, internal), theta, noise, input_noise, (steps[0], steps[1]))


def column_of(kind: str, case: Case, random: np.random.Generator) -> tuple[str, np.ndarray]:
    """Where an error of one radian of this kind acts, and how it shows in the output."""
    theta, drive = case.theta, case.drive
    slope, phi = drive.slope(theta), drive.position(theta)
    start = random.uniform(0.0, TURN)
    if kind == "eccentric" and random.random() < 0.5:
        return "input", slope * np.sin(theta + start)
    if kind == "eccentric":
        return "output", np.sin(phi + start)
    if kind == "slot":
        engaged = drive.engaged(theta)
        return "output", (engaged == random.choice(np.unique(engaged))).astype(float)
    if kind == "lost step":
        return "input", slope * (
            np.arange(theta.size) >= random.integers(0.1 * theta.size, 0.9 * theta.size)
        )
    far = np.zeros(theta.size)
    far[random.integers(theta.size)] = 1.0
    return "output", far


def standard_error(column: np.ndarray, case: Case) -> float:
    """Of the size of an error, beside phase and offset."""
    slope = case.drive.slope(case.theta)
    weight = 1.0 / case.deviation(slope)
    base = np.column_stack([np.ones_like(slope), slope]) * weight[:, None]
    own = column * weight
    left = own - base @ np.linalg.lstsq(base, own, rcond=None)[0]
    return float(1.0 / np.sqrt(max(left @ left, 1e-300)))


def read(
    case: Case, random: np.random.Generator, at: np.ndarray, drive: Drive, added: np.ndarray | float
) -> esc.Readings:
    """Both encoders: the input is read at `theta` while the driver stands at `at`."""
    size = case.theta.size
    angle = case.theta - case.theta[0] + case.input_noise * random.standard_normal(size)
    output = drive.position(at) + added + case.noise * random.standard_normal(size)
    output = random.choice([-1.0, 1.0]) * output + random.uniform(-9.0, 9.0)
    columns = [
        step * np.round(one / step) if step else one
        for one, step in zip((angle, output), case.steps, strict=True)
    ]
    if random.random() < 0.5:
        columns = [np.mod(one, TURN) for one in columns]
        if np.abs(np.diff(case.theta)).max() > 0.45 * TURN:
            columns[0] = angle
    time = np.cumsum(random.uniform(0.5, 1.5, size)) * 1e-3 if random.random() < 0.5 else None
    return esc.Readings(*columns, time=time)


def planted(
    kind: str, random: np.random.Generator, coarse: bool = False
) -> tuple[Drive, esc.Readings, Case, float]:
    """A drive and readings with an error of this kind, and its size in standard errors."""
    while True:
        case = case_of(random, coarse)
        drive, theta = case.drive, case.theta
        if kind == "none":
            return drive, read(case, random, theta, drive, 0.0), case, 0.0
        if kind == "other mechanism":
            other = Drive(drive.slots + int(random.choice([-1, 1])), drive.pins, drive.internal)
            if random.random() < 0.5:
                other = Drive(drive.slots, 1, not drive.internal)
            if other.slots < 3 or (other.internal and other.pins > 1):
                continue
            return drive, read(case, random, theta, other, 0.0), case, np.inf
        shaft, column = column_of(kind, case, random)
        times = LEAST * (MOST / LEAST) ** random.random()
        size = times * standard_error(column, case)
        if size > LARGEST * TURN / drive.slots:
            continue
        at, added = theta, size * column
        if shaft == "input":
            # where the transmission is 0 its column says nothing, so the cause is used itself
            slope = drive.slope(theta)
            safe = np.where(np.abs(slope) > 1e-9, slope, 1.0)
            at = theta + size * np.where(np.abs(slope) > 1e-9, column / safe, 0.0)
            added = 0.0
        return drive, read(case, random, at, drive, added), case, times


Judged = tuple[bool | None, float, str]
"""A verdict, the size of the error in standard errors, and the words."""


def verdict_of(kind: str, seed: int, coarse: bool = False) -> Judged:
    """The verdict on one set of readings."""
    random = np.random.default_rng([seed, ("none", *KINDS).index(kind), coarse])
    drive, readings, case, times = planted(kind, random, coarse)
    wheel = esc.Geneva(drive.slots, pins=drive.pins, internal=drive.internal)
    encoder = None
    if all(case.steps) and random.random() < 0.5:
        encoder = tuple(esc.Encoder(round(TURN / step)) for step in case.steps)
    verdict = esc.measure(readings, wheel, encoder=encoder).verdict
    return verdict.good, times, verdict.text


def row_of(error: str, times: str, found: list[Judged]) -> Row:
    """Verdicts counted."""
    verdicts = [good for good, *_ in found]
    counts = (sum(one is word for one in verdicts) for word in (True, None, False))
    return Row(error, times, len(found), *counts)


def by_size(found: list[Judged]) -> list[Row]:
    """How many errors are seen, by their size."""
    edges = (LEAST, 6.0, 8.0, 12.0, MOST)
    return [
        row_of("all", f"{low:g} to {high:g}", [one for one in found if low <= one[1] < high])
        for low, high in pairwise(edges)
    ]


def main() -> None:
    """Judge all sets, print and write the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=600)
    parser.add_argument("--show", action="store_true", help="print the verdicts that are wrong")
    args = parser.parse_args()
    each, rows = args.seeds // len(KINDS), []
    for coarse in (False, True):
        found = {kind: [verdict_of(kind, seed, coarse) for seed in range(each)] for kind in KINDS}
        found["none"] = [verdict_of("none", seed, coarse) for seed in range(args.seeds)]
        for kind, some in found.items() if args.show else ():
            for seed, (good, times, text) in enumerate(some):
                if (good is True) != (kind == "none"):
                    print(f"{kind} {seed} {coarse} {times:.1f}: {text}")
        mark = ", coarse" if coarse else ""
        span, every = f"{LEAST:g} to {MOST:g}", [one for kind in KINDS for one in found[kind]]
        rows.append(row_of(f"none{mark}", "", found["none"]))
        rows += [row_of(f"{kind}{mark}", span, found[kind]) for kind in KINDS]
        rows.append(row_of(f"all{mark}", span, every))
        rows += [] if coarse else by_size(every)
    print_columns([list(Row._fields)], [list(row) for row in rows])
    if args.seeds == 600:
        write_csv(ROOT / "benchmarks" / "results" / "planted_errors.csv", rows)


if __name__ == "__main__":
    main()
