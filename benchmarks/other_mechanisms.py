"""Both engines on random motions of mechanisms other than Geneva wheels.

``python benchmarks/other_mechanisms.py [--cases 300] [--seed 1974]``

The mechanisms are gear-driven wheels of all four curves, planetary drives with elliptical gears,
and tables of 20 to 120 rows. Inertia ratios are 1e-4 to 1e4, friction is up to 0.99 of the
Painlevé limit or efficiency from 0.3 to 1, and loads are up to 0.9 of those that the drive carries
in every position; motions start at rest or fast and have three engagements. The engines share no
numerical method, so a common error is unlikely. The result is the greatest difference of handoff
times and speeds in tolerances; it is infinite if the motions end differently.
"""

import argparse
import sys
import warnings
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import numpy as np

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.text import print_columns
from escapement.benchmark import write_csv
from escapement.mechanisms.gear_equation import CURVES

ROOT = Path(__file__).resolve().parents[1]
RTOL = 1e-10


class Line(NamedTuple):
    """Differences of the two engines over one kind's cases, in units of the tolerance."""

    mechanism: str
    cases: int
    median: float
    percentile_99: float
    largest: float
    unlike: int
    largest_ledger_residual: float


def gear_driven(random):
    """A gear-driven wheel of any curve, with as many pins as it can take, or fewer."""
    while True:
        lobes = Fraction(int(random.integers(0, 80)), int(random.integers(1, 4)))
        curve = CURVES[random.integers(len(CURVES))]
        try:
            wheel = esc.GearDriven(int(random.integers(3, 21)), lobes, curve)
            pins = int(random.integers(1, int(1.0 / wheel.lobe_ratio) + 1))
            wheel = esc.GearDriven(wheel.stations, lobes, curve, pins=pins)
            _ = wheel.path  # none where the pin passes through the wheel's centre
        except InvalidValue:
            continue
        return wheel


def elliptical(random):
    """A planetary drive with elliptical gears of any eccentricity."""
    return esc.EllipticalPlanetary(sun_radius=1.0, planet_radius=random.uniform(0.1, 0.95))


def table(random):
    """A table of a Geneva wheel or of a planetary drive, with rows evenly spaced or not."""
    drive = esc.Geneva(int(random.integers(3, 12)), pins=1)
    drive = drive if random.random() < 0.5 else elliptical(random)
    rows = int(random.integers(20, 121))
    theta = np.linspace(drive.breaks[0], drive.breaks[-1], rows)
    theta[1:-1] += (
        random.choice([0.0, 0.3]) * random.uniform(-1.0, 1.0, rows - 2) * np.diff(theta)[0]
    )
    return esc.Tabulated(theta, drive.follower_angle(theta))


KINDS = {"gear-driven": gear_driven, "elliptical-planetary": elliptical, "tabulated": table}


def draw(kind, random):
    """A random escapement in natural units, and the speed it starts with."""
    mechanism, inertia = KINDS[kind](random), esc.Inertia(10.0 ** random.uniform(-4.0, 4.0), 1.0)
    friction, efficiency = 0.0, 1.0
    if kind == "gear-driven":
        friction = random.uniform(0.02, 0.99) * esc.critical_friction(mechanism, inertia)
    else:
        efficiency = random.uniform(0.3, 1.0)
    found = mechanism.transmission(
        np.linspace(*mechanism.breaks[:: len(mechanism.breaks) - 1], 801)
    )
    carried = efficiency / np.max(np.abs(found.g) + friction * np.abs(found.u))
    load = random.choice([0.0, random.uniform(0.0, 0.9) * carried])
    speed = random.choice([0.0, 10.0 ** random.uniform(-1.0, 2.0)])
    timer = esc.Escapement(mechanism, inertia, 1.0, friction, load, efficiency=efficiency)
    return timer, speed


def difference(timer, speed):
    """Greatest relative difference over the tolerance, and the residual of the energy balance."""
    fast, slow = (
        esc.simulate(timer, 3, initial_speed=speed, engine=name, rtol=RTOL)
        for name in ("energy", "ivp")
    )
    alike = fast.status is slow.status and all(
        getattr(fast, name).theta.size == getattr(slow, name).theta.size
        for name in ("reversals", "extrema")
    )
    if not alike or fast.handoff_times.size != slow.handoff_times.size:
        return np.inf, abs(fast.ledger.residual)
    errors = [
        np.abs(getattr(fast, name) / getattr(slow, name) - 1.0).max(initial=0.0)
        for name in ("handoff_times", "handoff_velocities")
    ]
    return max(errors) / RTOL, abs(fast.ledger.residual)


def main() -> int:
    """Compare, print, write; returns 1 if the engines differ by more than both tolerances."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=300, help="of every kind")
    parser.add_argument("--seed", type=int, default=1974)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "benchmarks" / "results")
    args = parser.parse_args()
    warnings.simplefilter("error")
    lines = []
    for place, kind in enumerate(KINDS):
        found = []
        for case in range(args.cases):
            timer, speed = draw(kind, np.random.default_rng([args.seed, place, case]))
            found.append(difference(timer, speed))
            if not found[-1][0] <= 20.0:
                print(kind, case, found[-1], timer, speed, flush=True)
        errors, residuals = np.array(found).T
        alike = errors[np.isfinite(errors)]
        quantiles = (float(np.percentile(alike, q)) for q in (50, 99, 100))
        unlike = errors.size - alike.size
        lines.append(Line(kind, args.cases, *quantiles, unlike, float(residuals.max())))
    args.output.mkdir(parents=True, exist_ok=True)
    write_csv(args.output / "other_mechanisms.csv", lines)
    print_columns([Line._fields], lines)
    return int(any(line.largest > 20.0 or line.unlike for line in lines))


if __name__ == "__main__":
    sys.exit(main())
