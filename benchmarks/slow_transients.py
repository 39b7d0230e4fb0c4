"""Figures of wheels nearly without losses: how long they take, and whether they are right.

Random friction, drag and loads, so that up to a million engagements pass before the terminal cycle
is near. Up to 40 000 engagements the times of the transient are compared with those of a motion
that is simulated to its end. Writes results/slow_transients.csv.

    python benchmarks/slow_transients.py [SCENES] [FIRST SEED]
"""

import sys
from collections import Counter
from pathlib import Path
from time import process_time

import numpy as np

import escapement as esc
from escapement.base.status import Status
from escapement.dynamics.figure_table import TRANSIENT
from escapement.dynamics.figures_of_merit import fall_times, read_transient

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent / "tests"))
from slow_wheels import random_wheel  # noqa: E402

RESULT = HERE / "results" / "slow_transients.csv"
MOST = 40_000


def difference(escapement, start, figures):
    """Greatest relative difference of the times from a motion's; None if that is too long."""
    decay = 6.0 + 2.0 * np.log1p(start / figures.handoff_velocity)
    if not decay < MOST * (1.0 - figures.contraction):
        return None
    count = 60 + int(decay / (1.0 - figures.contraction))
    motion = esc.simulate(escapement, count, initial_speed=start)
    rise, settled = read_transient(motion, figures)
    cycle = esc.simulate(escapement, 1, initial_speed=figures.handoff_velocity)
    told = (rise, *fall_times(motion, start, cycle), settled)
    pairs = zip((getattr(figures, name) for name in TRANSIENT), told, strict=True)
    return max(abs(a - b) / max(abs(b), 1e-300) for a, b in pairs)


def main(scenes=1500, first=0):
    """Compute so many wheels."""
    esc.terminal(random_wheel(np.random.default_rng(first))[0])
    seconds, differences, ends = [], [], Counter()
    for seed in range(first, first + scenes):
        escapement, start = random_wheel(np.random.default_rng(seed))
        before = process_time()
        figures = esc.terminal(escapement, initial_speed=start)
        seconds.append(process_time() - before)
        ends[figures.status.label] += 1
        if figures.status is Status.OK:
            found = difference(escapement, start, figures)
            differences += [] if found is None else [found]
    head = "scenes,ok,no_terminal,others,median s,greatest s,compared,greatest difference"
    others = scenes - ends["ok"] - ends["no_terminal"]
    row = f"{scenes},{ends['ok']},{ends['no_terminal']},{others},{np.median(seconds):.1e}"
    row += f",{max(seconds):.1e},{len(differences)},{max(differences):.1e}"
    RESULT.write_text(f"{head}\n{row}\n", encoding="utf-8")
    print(head, row, sep="\n")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
