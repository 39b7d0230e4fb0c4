"""Error of the fast engine over random cases, at several tolerances.

``python benchmarks/energy_accuracy.py [--cases 1000] [--references 50]``

The cases are six engagements from rest of three mechanisms. The logarithm (base 10) of the inertia
ratio is uniform from -2 to 1, and friction is uniform up to 0.99 of the Painlevé limit. The error
is the largest relative one of all handoff times and speeds. Every case is compared with the engine
itself at its tightest tolerance. Some cases, half of them those with the largest such errors, are
compared with the integrator of the tests, which has 34 digits.
"""

import argparse
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

import escapement as esc
from escapement.base.text import print_columns
from escapement.benchmark import write_csv

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "reference"))

TIGHTEST, DEFAULT = 1e-13, 1e-12
TOLERANCES = (DEFAULT, 1e-10, 1e-8, 1e-6, 1e-4)
FINEST = 1e-12
"""Error promised at the default tolerance; with a looser tolerance it is the tolerance itself."""
SETTING = {"digits": 34, "order": 26, "tolerance": "1e-23"}


class Case(NamedTuple):
    """One random case and the largest relative error at each tolerance."""

    slots: int
    inertia_ratio: float
    friction: float
    friction_over_limit: float
    judge: str
    error_default: float
    error_1e10: float
    error_1e8: float
    error_1e6: float
    error_1e4: float


class Summary(NamedTuple):
    """Errors of all cases at one tolerance, compared with one reference."""

    judge: str
    rtol: float
    cases: int
    median: float
    percentile_99: float
    largest: float
    broken_promises: int


def draw(count: int, seed: int) -> list[tuple[esc.Escapement, float]]:
    """Random escapements in natural units, and their friction over the limit."""
    rng = np.random.default_rng(seed)
    scenes = []
    for _ in range(count):
        wheel = esc.Geneva(slots=int(rng.choice([3, 4, 6])))
        inertia = esc.Inertia(driver=10.0 ** rng.uniform(-2.0, 1.0), follower=1.0)
        share = rng.uniform(0.0, 0.99)
        friction = share * esc.critical_friction(wheel, inertia)
        scenes.append((esc.Escapement(wheel, inertia, torque=1.0, friction=friction), share))
    return scenes


def handoffs(scene: esc.Escapement, rtol: float, engagements: int) -> np.ndarray:
    """Times and speeds, shape (2, engagements)."""
    motion = esc.simulate(scene, engagements, rtol=rtol)
    return np.array([motion.handoff_times, motion.handoff_velocities])


def reference(scene: esc.Escapement, engagements: int) -> np.ndarray:
    """The same from the tests' integrator."""
    from mpmath import mp
    from taylor import dimensionless, motion

    data = {
        "slots": scene.mechanism.slots,
        "pins": scene.mechanism.pins,
        "internal": False,
        "friction": scene.friction,
        "driver_inertia": scene.inertia.driver,
        "follower_inertia": scene.inertia.follower,
        "torque": scene.torque,
        "load_torque": 0.0,
        "initial_speed": 0.0,
        "engagements": engagements,
    }
    with mp.workdps(SETTING["digits"]):
        found, _ = motion(dimensionless(data)[0], data, SETTING, *dimensionless(data)[1:])
        names = ("handoff_times", "handoff_velocities")
        return np.array([[float(x) for x in found[name]] for name in names])


def judge(scene: esc.Escapement, share: float, truth: np.ndarray, name: str) -> Case:
    """Errors of one case at every tolerance."""
    count = truth.shape[1]
    errors = [
        float(np.abs(handoffs(scene, rtol, count) / truth - 1.0).max()) for rtol in TOLERANCES
    ]
    return Case(scene.mechanism.slots, scene.scene.rho, scene.friction, share, name, *errors)


def summaries(cases: list[Case]) -> list[Summary]:
    """One line for each reference and tolerance."""
    lines = []
    for name in dict.fromkeys(case.judge for case in cases):
        table = np.array([case[5:] for case in cases if case.judge == name])
        for rtol, errors in zip(TOLERANCES, table.T, strict=True):
            lines.append(
                Summary(
                    name,
                    rtol,
                    errors.size,
                    float(np.median(errors)),
                    float(np.percentile(errors, 99)),
                    float(errors.max()),
                    int(np.count_nonzero(errors > max(rtol, FINEST))),
                )
            )
    return lines


def main() -> int:
    """Judge, print, write; returns 1 if an error is too large."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--references", type=int, default=50, help="cases judged in 34 digits")
    parser.add_argument("--engagements", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1973)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "benchmarks" / "results")
    args = parser.parse_args()
    scenes = draw(args.cases, args.seed)
    cases = [
        judge(scene, share, handoffs(scene, TIGHTEST, args.engagements), "energy at 1e-13")
        for scene, share in scenes
    ]
    # the 34 digits judge some cases in their order, and those with the largest errors
    worst = sorted(range(len(scenes)), key=lambda place: -cases[place].error_default)
    chosen = [*range(args.references // 2), *worst[: (args.references + 1) // 2]]
    for scene, share in (scenes[place] for place in dict.fromkeys(chosen)):
        cases.append(judge(scene, share, reference(scene, args.engagements), "34 digits"))
    lines = summaries(cases)
    args.output.mkdir(parents=True, exist_ok=True)
    write_csv(args.output / "energy_accuracy.csv", lines)
    worst_first = sorted(cases, key=lambda case: -case.error_default)
    write_csv(args.output / "energy_accuracy_worst.csv", worst_first[:20])
    print_columns([Summary._fields], lines)
    print(f"\nworst at the default tolerance: {worst_first[0]}")
    return 1 if any(line.broken_promises for line in lines) else 0


if __name__ == "__main__":
    sys.exit(main())
