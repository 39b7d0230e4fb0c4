"""How often readings with an error are called good, and readings without one are not.

``python benchmarks/planted_errors.py [--seeds 600]``

The readings are made here and not by the package: a Geneva wheel in closed form, independent noise
of both encoders, rounding to counts, any start and sense of turning. One set has no error, in the
other each set has one: an eccentric disc, a slot, a lost step, one reading far out, or another
mechanism. The size of an error is 5 to 50 times the standard error with which its own least-squares
fit finds it (the logarithm is uniform); both shafts move through two cells or more. The noise is at
least a third of the output's count, so that rounding is noise too; rows "coarse" have less of it.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from common import asked, tell

import escapement as esc

DEG, TURN = np.pi / 180.0, 2.0 * np.pi
KINDS = ("eccentric", "slot", "lost step", "far out", "other mechanism")
LEAST, MOST = 5.0, 50.0
LARGEST = 0.2  # share of a step; greater errors need no statistics


class Drive(NamedTuple):
    """A Geneva wheel."""

    slots: int
    pins: int
    internal: bool

    def position(self, theta):
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

    def engaged(self, theta):
        """Number of the slot that a pin is in, or was in last."""
        reach = np.pi / 2.0 + (1 if self.internal else -1) * np.pi / self.slots
        return np.floor((theta + reach) / (TURN / self.pins)) % self.slots

    def slope(self, theta):
        """Transmission by central differences."""
        return (self.position(theta + 1e-6) - self.position(theta - 1e-6)) / 2e-6


class Case(NamedTuple):
    """A drive, the angles at which it was read, and its encoders."""

    drive: Drive
    theta: np.ndarray
    noise: float
    input_noise: float
    steps: tuple[float, float]

    def deviation(self, slope):
        """Standard deviation of the error of each sample, rounding included."""
        of_output = self.noise**2 + self.steps[1] ** 2 / 12.0
        return np.sqrt(of_output + slope**2 * (self.input_noise**2 + self.steps[0] ** 2 / 12.0))


def case_of(random, coarse):
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


def column_of(kind, case, random):
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


def standard_error(column, case):
    """Of the size of an error, beside phase and offset."""
    slope = case.drive.slope(case.theta)
    weight = 1.0 / case.deviation(slope)
    base = np.column_stack([np.ones_like(slope), slope]) * weight[:, None]
    own = column * weight
    left = own - base @ np.linalg.lstsq(base, own, rcond=None)[0]
    return float(1.0 / np.sqrt(max(left @ left, 1e-300)))


def read(case, random, at, drive, added):
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


def planted(kind, random, coarse=False):
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


def verdict_of(kind, seed, coarse=False):
    """The verdict on one set of readings, and the size of its error in standard errors."""
    random = np.random.default_rng([seed, ("none", *KINDS).index(kind), coarse])
    drive, readings, case, times = planted(kind, random, coarse)
    wheel = esc.Geneva(drive.slots, pins=drive.pins, internal=drive.internal)
    encoder = None
    if all(case.steps) and random.random() < 0.5:
        encoder = tuple(esc.Encoder(round(TURN / step)) for step in case.steps)
    return esc.measure(readings, wheel, encoder=encoder).verdict.good, times


def row_of(error, times, found):
    """Verdicts counted; `times` is the size of errors in standard errors."""
    row, verdicts = {"error": error, "times": times, "sets": len(found)}, [one[0] for one in found]
    words = {"good": True, "cannot_say": None, "not_good": False}
    return row | {name: sum(one is word for one in verdicts) for name, word in words.items()}


def main():
    """Judge all sets, print and write the counts."""
    seeds, whole = asked(__doc__, seeds=600)
    each, span, rows = seeds // len(KINDS), f"{LEAST:g} to {MOST:g}", []
    for coarse in (False, True):
        mark = ", coarse" if coarse else ""
        none = [verdict_of("none", seed, coarse) for seed in range(seeds)]
        found = {kind: [verdict_of(kind, seed, coarse) for seed in range(each)] for kind in KINDS}
        found["all"] = [one for some in found.values() for one in some]
        rows.append(row_of(f"none{mark}", "", none))
        rows += [row_of(f"{kind}{mark}", span, some) for kind, some in found.items()]
        for low, high in () if coarse else pairwise((LEAST, 6.0, 8.0, 12.0, MOST)):
            some = [one for one in found["all"] if low <= one[1] < high]
            rows.append(row_of("all", f"{low:g} to {high:g}", some))
    tell("planted_errors", rows, whole)


if __name__ == "__main__":
    main()
