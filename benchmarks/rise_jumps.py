"""Whether the times of the start jump where parts get errors of 1e-15 m or 1e-13 rad.

Random timers of perfect parts are compared with the same timers with eight sets of errors. A time
jumps if it changes by more than 1e-4 of the period. Writes results/rise_jumps.csv.

    python benchmarks/rise_jumps.py [TIMERS] [FIRST SEED]
"""

import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

from common import write_rows

import escapement as esc
from escapement.base.status import Status
from escapement.dynamics.figure_table import TRANSIENT

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent / "tests"))
from nearly_perfect import random_timer, slight_errors  # noqa: E402


def main(timers=300, first=0):
    """Compare so many timers."""
    compared, jumps = 0, Counter()
    for seed in range(first, first + timers):
        timer, start, rng = random_timer(seed)
        perfect = esc.terminal(timer, initial_speed=start)
        if perfect.status is not Status.OK:
            continue
        for errors in slight_errors(timer.mechanism, rng):
            uneven = replace(timer, mechanism=replace(timer.mechanism, **errors))
            found = esc.terminal(uneven, initial_speed=start)
            compared += 1
            for name in TRANSIENT:
                one, two = getattr(perfect, name), getattr(found, name)
                both_missing = one != one and two != two
                jumps[name] += not (abs(one - two) <= 1e-4 * perfect.period or both_missing)
    row = {"timers": timers, "compared": compared} | {name: jumps[name] for name in TRANSIENT}
    write_rows("rise_jumps", [row])
    print(row)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
